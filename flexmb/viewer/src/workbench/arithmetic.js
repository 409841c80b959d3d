/** Numbers of the document as text: a number, a name, or arithmetic of them with + - * / ** and parentheses. */

const TOKEN = /[ \t]*(?:((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?![\p{L}\p{N}_.])|([\p{L}_][\p{L}\p{N}_]*)|(\*\*|[-+*/()]))/uy;
const PLAIN = /^\s*[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?\s*$/;
const NAME = /^\s*[\p{L}_][\p{L}\p{N}_]*\s*$/u;

/** Whether a text is a number and no arithmetic. */
export const isPlain = (text) => PLAIN.test(text);

/** The name that a text is, without any arithmetic; null otherwise. */
export const nameIn = (text) => (NAME.test(text) && text.trim() !== "pi" ? text.trim() : null);

/** Value of a text, NaN where it has none; `values` by name. */
export function valueOf(text, values = {}) {
  if (typeof text === "number") return text;
  const tokens = tokensOf(String(text ?? ""));
  if (!tokens?.length) return NaN;
  let at = 0;
  const next = (...signs) => (signs.includes(tokens[at]?.sign) ? tokens[at++].sign : null);
  const sum = () => {
    let value = product();
    for (let sign = next("+", "-"); sign; sign = next("+", "-")) value = sign === "+" ? value + product() : value - product();
    return value;
  };
  const product = () => {
    let value = signed();
    for (let sign = next("*", "/"); sign; sign = next("*", "/")) value = sign === "*" ? value * signed() : value / signed();
    return value;
  };
  const signed = () => {
    const sign = next("+", "-");
    if (sign) return sign === "-" ? -signed() : signed();
    const base = atom();
    return next("**") ? base ** signed() : base;
  };
  const atom = () => {
    if (next("(")) {
      const value = sum();
      return next(")") ? value : NaN;
    }
    const { number, name } = tokens[at++] ?? {};
    if (number !== undefined) return Number(number);
    if (name === "pi") return Math.PI;
    return name !== undefined && Object.hasOwn(values, name) ? Number(values[name]) : NaN;
  };
  const value = sum();
  return at === tokens.length && Number.isFinite(value) ? value : NaN;
}

function tokensOf(text) {
  const tokens = [];
  TOKEN.lastIndex = 0;
  const end = text.trimEnd().length;
  while (TOKEN.lastIndex < end) {
    const found = TOKEN.exec(text);
    if (!found) return null;
    const [, number, name, sign] = found;
    tokens.push({ number, name, sign });
  }
  return tokens;
}

/** A number as text for the document: no round-off of a sum of steps, and no minus zero. */
export function textOf(value, step = 0) {
  const rounded = step > 0 ? Math.round(value / step) * step : value;
  return String(Number(rounded.toPrecision(12)) || 0);
}

/** A number to read, with four digits. */
export const shown = (value) => String(Number(Number(value).toPrecision(4)) || 0).replace("-", "\u2212");

/** A length to read: millimetres below a metre. */
export function length(value) {
  const size = Math.abs(value);
  if (size >= 1) return `${shown(value)} m`;
  return size > 0 && size < 1e-4 ? `${shown(1e6 * value)} µm` : `${shown(1e3 * value)} mm`;
}
