/** The document as it is drawn: nodes, lines between them, and what is marked on either. */
import { valueOf } from "./arithmetic.js";

// Fields that say where a thing is, when the catalogue is not there yet.
const PLACES = { node: "node", nodes: "nodes", of: "of", element: "element", base: "node" };
const WHERE = ["node", "nodes", "of", "element"];

/** Fields of a call by kind, in their order: [name, kind]. */
export function fieldsOf(catalogue, call, kinds = WHERE) {
  const told = catalogue?.[call]?.fields;
  if (told) return told.filter((field) => kinds.includes(field.kind));
  return Object.entries(PLACES).filter(([, kind]) => kinds.includes(kind)).map(([name, kind]) => ({ name, kind }));
}

export function groupOf(catalogue, call) {
  if (catalogue?.[call]?.group) return catalogue[call].group;
  if (call.startsWith("planar.") || call.startsWith("spatial.")) return "element";
  return call.startsWith("blocks.") ? "block" : call;
}

/** How an element is drawn, from its name alone, so that a new one is drawn too. */
export function styleOf(call) {
  const last = call.split(".").pop();
  if (call.startsWith("blocks.")) return "block";
  if (/rigid/.test(last)) return "rigid";
  if (/beam|leaf/.test(last)) return "beam";
  if (/truss|wire|cable/.test(last)) return "bar";
  if (/spring/.test(last)) return "spring";
  return /hinge/.test(last) ? "hinge" : "joint";
}

/** A list as the document has it: a list, or one text with blanks or commas between. */
export function listOf(value) {
  if (Array.isArray(value)) return value.map(String);
  return String(value ?? "").split(/[\s,]+/).filter(Boolean);
}

const inSpace = (place) => [Number(place[0]), Number(place[1]), Number(place[2] ?? 0)];
const isPlace = (place) => place && place.every((value) => Number.isFinite(value));

/** Everything that is drawn; `moved` are places by node name that the hand is ahead with. */
export function planOf(state, moved = {}) {
  const { document: own, positions = {}, values = {}, catalogue } = state;
  const things = own?.things ?? [];
  const nodes = [];
  const byName = new Map();
  const known = new Map(things.filter((thing) => thing.name).map((thing) => [thing.name, thing]));
  const add = (name, id, place) => {
    if (!isPlace(place)) return;
    const node = { id, name, at: place };
    nodes.push(node);
    byName.set(name, node);
  };
  for (const thing of things.filter(({ call }) => call === "node")) {
    const told = positions[thing.name] ?? listOf(thing.args.position).map((text) => valueOf(text, values));
    add(thing.name, thing.id, moved[thing.name] ?? inSpace(told));
  }
  // Nodes that a building block made: seen, and joined to, but not moved.
  for (const [name, place] of Object.entries(positions)) {
    if (!byName.has(name) && !known.has(name)) add(name, null, inSpace(place));
  }
  turning(things, byName);
  const lines = [];
  const marks = [];
  for (const thing of things) {
    const group = groupOf(catalogue, thing.call);
    if (group === "element" || group === "block") lines.push(lineOf(thing, byName, catalogue));
  }
  const byElement = new Map(lines.map((line) => [line.name, line]));
  const shared = { byName, byElement, values, catalogue };
  for (const thing of things) {
    if (["node", "rotation", "element", "block", "section", "material"].includes(groupOf(catalogue, thing.call))) continue;
    if (thing.call !== "rotation" && thing.call !== "warping") marks.push(markOf(thing, shared));
  }
  return { dimension: own?.dimension ?? 2, nodes, byName, lines: lines.filter(({ places }) => places.length), byElement, marks };
}

/** Rotations of their own lie where an element names them after a point. */
function turning(things, byName) {
  const names = things.filter(({ call }) => call === "rotation" || call === "warping").map(({ name }) => name);
  if (!names.length) return;
  const waiting = new Set(names);
  for (const thing of things) {
    let last = null;
    for (const name of listOf(thing.args?.nodes)) {
      if (waiting.has(name) && last) byName.set(name, { ...last, turns: name });
      else last = byName.get(name) ?? last;
    }
  }
}

function lineOf(thing, byName, catalogue) {
  const names = fieldsOf(catalogue, thing.call, ["node", "nodes"]).flatMap(({ name }) => listOf(thing.args[name]));
  const points = [];
  for (const name of names) {
    const node = byName.get(name);
    if (node && !points.some((other) => other.id === node.id && other.name === node.name)) points.push(node);
  }
  const places = points.map(({ at }) => at);
  return { id: thing.id, name: thing.name, call: thing.call, style: styleOf(thing.call), nodes: points, places, args: thing.args };
}

function markOf(thing, { byName, byElement, values, catalogue }) {
  const kind = thing.call.split(".").pop().replace("follower_", "");
  const mark = { kind, id: thing.id, name: thing.name, call: thing.call, args: thing.args, node: null, line: null };
  for (const { name } of fieldsOf(catalogue, thing.call)) {
    for (const told of listOf(thing.args[name])) {
      mark.node ??= byName.get(told) ?? null;
      mark.line ??= byElement.get(told) ?? null;
    }
    if (mark.node || mark.line) break;
  }
  mark.components = listOf(thing.args.components ?? thing.args.component);
  mark.vector = vectorOf(kind, thing.args, values);
  return mark;
}

/** Direction of a load, with its size; null where it has none. */
function vectorOf(kind, args, values) {
  const told = args[kind] ?? args.acceleration;
  const list = listOf(told);
  if (list.length < 2) return null;
  const vector = list.map((text) => valueOf(text, values));
  return vector.every(Number.isFinite) && vector.some(Boolean) ? inSpace(vector) : null;
}

/** Middle of a line. */
export function middleOf({ places }) {
  if (places.length === 1) return places[0];
  const [first, last] = [places[0], places[places.length - 1]];
  return first.map((value, k) => (value + last[k]) / 2);
}
