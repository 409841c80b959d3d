/** A thing in words, for those who point at it and those who listen. */
import { isPlain, length, shown } from "./arithmetic.js";
import { listOf } from "./plan.js";

const cut = (text) => (text.length > 60 ? `${text.slice(0, 57)}…` : text);

/** One line on a thing of the document. */
export function describe(canvas, id) {
  const thing = canvas.thing(id);
  if (!thing) return "";
  const told = [...words(canvas, thing), ...problems(canvas, id)];
  return told.join(", ");
}

function problems(canvas, id) {
  return (canvas.store.state.problems ?? [])
    .filter(({ address }) => String(address ?? "").split("/")[0] === id)
    .map(({ message }) => message);
}

function words(canvas, thing) {
  const { catalogue } = canvas.store.state;
  const title = catalogue?.[thing.call]?.title ?? thing.call.split(".").pop().replaceAll("_", " ");
  const name = thing.name ? ` ${cut(thing.name)}` : "";
  if (thing.call === "node") {
    const texts = listOf(thing.args.position);
    const node = canvas.plan.byName.get(thing.name);
    const at = texts.map((text, k) => (isPlain(text) ? length(Number(text)) : `${text} = ${length(node?.at[k] ?? NaN)}`));
    return [`Node${name}: ${at.join(", ")}`];
  }
  const line = canvas.plan.lines.find((own) => own.id === thing.id);
  if (line) return [`${title}${name}`, ...along(line)];
  const mark = canvas.plan.marks.find((own) => own.id === thing.id);
  const where = mark?.node ? ` at ${cut(mark.node.name)}` : mark?.line ? ` of ${cut(mark.line.name)}` : "";
  return [`${title}${name}${where}`, ...values(thing)];
}

function along(line) {
  const names = line.nodes.map(({ name }) => cut(name)).join("–");
  const [first, last] = [line.places[0], line.places[line.places.length - 1]];
  const size = Math.hypot(...first.map((value, k) => last[k] - value));
  const section = typeof line.args.section === "string" && line.args.section ? [`section ${cut(line.args.section)}`] : [];
  return [names, ...(size > 0 ? [length(size)] : []), ...section];
}

const UNITS = { force: "N", moment: "N m", mass: "kg", acceleration: "m/s²" };

function values({ args }) {
  const told = [];
  for (const [name, value] of Object.entries(args)) {
    if (["node", "of", "element", "nodes"].includes(name) || value === "" || value === null) continue;
    const texts = listOf(value).map((text) => (isPlain(text) ? shown(Number(text)) : cut(text)));
    const unit = UNITS[name] ? ` ${UNITS[name]}` : "";
    told.push(`${UNITS[name] ? "" : `${name} `}${texts.join(", ")}${unit}`);
  }
  return told.slice(0, 4);
}
