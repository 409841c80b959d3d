/** What the panels ask of the document: things by id, names of a kind, words for what stands there. */

export const things = (store) => store.state.document?.things ?? [];
export const thing = (store, id) => things(store).find((other) => other.id === id);
export const entry = (store, call) => store.state.catalogue?.[call];
export const group = (store, call) => entry(store, call)?.group ?? (call === "node" ? "node" : "element");

/** Names of the things that are nodes, elements, sections, …, for lists to choose from. */
export function namesOf(store, kinds) {
  const makes = (call) => entry(store, call)?.makes ?? (call === "node" ? "node" : null);
  return things(store)
    .filter(({ call, name }) => name && kinds.includes(makes(call)))
    .map(({ name }) => name);
}

/** A number that may differ in the plane and in space. */
export function countOf(store, field) {
  const { count } = field;
  return count !== null && typeof count === "object" ? count[String(store.state.document?.dimension ?? 2)] : count;
}

/** The fields of a call that mean something here. */
export function fieldsOf(store, call) {
  const own = store.state.document?.dimension ?? 2;
  const fields = entry(store, call)?.fields ?? [];
  return fields.filter(
    (field) =>
      (!field.dimension || field.dimension === own) && !(field.kind === "vector" && countOf(store, field) === 0),
  );
}

export function fits(store, call) {
  const { dimension } = entry(store, call) ?? {};
  return !dimension || dimension === store.state.document?.dimension;
}

/** "rotary_spring_damper" in words. */
export function words(call) {
  return call.split(".").at(-1).replaceAll("_", " ");
}

export function title(store, call) {
  const text = entry(store, call)?.title ?? words(call);
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** How a thing is called in a sentence: its name, or what it does to whom. */
export function spoken(store, { call, name, args = {} }) {
  if (name) return name;
  const of = args.node ?? args.of ?? args.element;
  return of ? `${title(store, call)} of ${of}` : title(store, call);
}

/** The texts of a thing in a line. */
export function summary({ args = {} }) {
  return Object.values(args)
    .filter((value) => value !== "" && value !== null)
    .map((value) => (Array.isArray(value) ? `(${value.join(", ")})` : String(value)))
    .join("  ");
}

/** Problem of a field, or of anything inside it where it has none of its own. */
export function problemAt(store, address, within = false) {
  const all = store.state.problems ?? [];
  const found = all.find((problem) => problem.address === address);
  return (found ?? (within && all.find((problem) => problem.address?.startsWith(`${address}/`))))?.message ?? null;
}

const NUMBER = /^\s*[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?\s*$/i;
export const isNumber = (text) => NUMBER.test(text);

const tokensOf = (text) =>
  String(text).match(/(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|[\p{L}_][\p{L}\p{N}_]*|\*\*|[-+*/()]|\S/giu) ?? [];

/** The names in a text that the document does not know. */
export function unknown(store, text) {
  const known = store.state.document?.names ?? {};
  const names = tokensOf(text).filter((token) => /^[\p{L}_]/u.test(token));
  return [...new Set(names)].filter((name) => name !== "pi" && !Object.hasOwn(known, name));
}

// Powers of ten of the units that are written behind numbers.
const UNITS = { m: 0, mm: -3, um: -6, µm: -6, μm: -6, nm: -9, kN: 3, mN: -3, N: 0, Pa: 0, kPa: 3, MPa: 6, GPa: 9, kg: 0, g: -3 };

/** What to write where a number stands before a unit, or null. */
export function unitAdvice(text) {
  const [, number, unit] = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([a-zµμ]+|°)\s*$/i.exec(text) ?? [];
  if (!number) return null;
  if (unit === "deg" || unit === "°") return `Numbers are in SI units here: write ${number}*pi/180.`;
  if (!Object.hasOwn(UNITS, unit)) return null;
  const power = UNITS[unit] ? (/e/i.test(number) ? `*1e${UNITS[unit]}` : `e${UNITS[unit]}`) : "";
  return `Numbers are in SI units here: write ${number}${power}.`;
}

/** Value of a text: a number, or arithmetic with + - * / ** and parentheses of names; null where it has none.
 *
 * Only for what is shown beside a field while it is typed; what is computed with is the server's.
 */
export function evaluate(store, text) {
  const values = store.state.values ?? {};
  const tokens = tokensOf(text);
  let at = 0;
  const take = (sign) => tokens[at] === sign && Boolean((at += 1));
  const sum = () => {
    let value = product();
    for (;;) {
      if (take("+")) value += product();
      else if (take("-")) value -= product();
      else return value;
    }
  };
  const product = () => {
    let value = signed();
    for (;;) {
      if (take("*")) value *= signed();
      else if (take("/")) value /= signed();
      else return value;
    }
  };
  const signed = () => (take("-") ? -signed() : take("+") ? signed() : power());
  const power = () => {
    const base = atom();
    return take("**") ? base ** signed() : base;
  };
  const atom = () => {
    if (take("(")) {
      const value = sum();
      return take(")") ? value : NaN;
    }
    const token = tokens[at] ?? "";
    at += 1;
    if (isNumber(token)) return Number(token);
    return token === "pi" ? Math.PI : (values[token] ?? NaN);
  };
  const value = sum();
  return at === tokens.length && Number.isFinite(value) ? value : null;
}
