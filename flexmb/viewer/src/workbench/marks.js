/** Supports, loads, masses and signals of a document, each drawn at its node or element. */
import { listOf, middleOf } from "./plan.js";
import { isPlain, shown } from "./arithmetic.js";
import { fade } from "./colours.js";
import * as symbols from "./symbols.js";

const LONG = 44;

/** `taken` counts what stands at a node already, so that marks of one node lie beside each other. */
export function mark(drawing, own, taken) {
  const { pen, colours, eye } = drawing;
  const at = own.node ? eye.project(own.node.at) : own.line ? eye.project(middleOf(own.line)) : null;
  const place = own.node?.name ?? own.line?.name ?? "";
  const before = taken.get(place) ?? 0;
  taken.set(place, before + 1);
  if (!at) {
    nowhere(drawing, own, before);
    return;
  }
  const colour = drawing.problems.has(own.id) ? colours.problem : colours[COLOURS[own.kind]] ?? colours.mark;
  pen.strokeStyle = pen.fillStyle = colour;
  pen.lineWidth = 1.8;
  pen.setLineDash([]);
  const spot = (SIGNS[own.kind] ?? tag)(drawing, own, at, { colour, before }) ?? at;
  drawing.spot(own.id, spot);
  const chosen = drawing.selection.has(own.id);
  if (chosen || drawing.hovered === own.id) {
    symbols.circle(pen, spot, 13);
    pen.fillStyle = fade(chosen ? colours.chosen : colours.focus, 0.25);
    pen.fill();
  }
}

// What a call is drawn in and as; any other is a tag with its name.
const COLOURS = {
  force: "load", moment: "load", gravity: "load", temperature: "load", prestress: "load", strain: "load",
  input: "input", actuator: "input", output: "output", sensor: "output", dof: "dof", prescribe: "dof",
};
const SIGNS = {
  fix: support, prescribe, force: load, moment: load, mass: lump, body: lump, inertia: lump,
  input: signal, output: signal, actuator: signal, sensor: signal, dof: signal,
};

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/** A direction towards the reader or away from him has no arrow. */
function seen(drawing, vector) {
  const direction = drawing.eye.direction(vector);
  const whole = Math.hypot(...vector) / drawing.eye.scale;
  return Math.hypot(...direction) > 0.12 * whole ? symbols.unit(direction) : null;
}

function axisOf(component) {
  const k = ["x", "y", "z"].indexOf(component);
  return k < 0 ? null : AXES[k];
}

/** The nearest of the four directions of the page. */
const upright = ([u, v]) => (Math.abs(u) > Math.abs(v) ? [Math.sign(u), 0] : [0, Math.sign(v) || -1]);

/** Walls stand upright or lie where the element leaves them about squarely. */
const nearly = (into) => (Math.max(...into.map(Math.abs)) > 0.86 ? upright(into) : into);

function support(drawing, own, at) {
  const { pen, eye } = drawing;
  const into = drawing.into(own.node?.name);
  const held = own.components;
  const all = eye.planar ? ["x", "y"] : ["x", "y", "z"];
  const shifts = all.filter((axis) => held.includes(axis));
  const turns = held.filter((name) => !all.includes(name) && name !== "position");
  const behind = (out, by) => [at[0] - by * out[0], at[1] - by * out[1]];
  if (!held.length || (turns.length && shifts.length === all.length)) {
    const out = nearly(into);
    symbols.clamp(pen, at, out);
    return behind(out, 6);
  }
  if (held.includes("position") || shifts.length === all.length || (!eye.planar && shifts.length > 1)) {
    symbols.pin(pen, at, upright(into));
    if (shifts.length < all.length && shifts.length) drawing.words.write(shifts.join(" "), at[0] + 12, at[1] + 14, drawing.colours.soft);
    return behind(upright(into), 12);
  }
  if (shifts.length) {
    const along = seen(drawing, axisOf(shifts[0])) ?? [0, -1];
    const out = along[0] * into[0] + along[1] * into[1] < -0.1 ? [-along[0], -along[1]] : along;
    symbols.pin(pen, at, out, true);
    if (turns.length) symbols.unturned(pen, at);
    return behind(out, 14);
  }
  symbols.unturned(pen, at);
  drawing.words.write(turns.join(" ").replace("phi", "φ"), at[0] + 11, at[1] + 14, drawing.colours.soft);
  return [at[0] + 8, at[1] + 8];
}

function prescribe(drawing, own, at) {
  symbols.diamond(drawing.pen, at);
  drawing.words.write(`given ${own.components.join(" ")}`, at[0] + 12, at[1] + 14, drawing.colours.dof);
  return [at[0], at[1] + 9];
}

/** Number with unit, or the arithmetic as it stands. */
function sized(own, unit) {
  const texts = listOf(own.args[own.kind]);
  const named = texts.filter((text) => !isPlain(text));
  if (named.length) return named.join(", ").slice(0, 24);
  const size = own.vector ? Math.hypot(...own.vector) : Number(texts[0]);
  return Number.isFinite(size) ? `${shown(size)} ${unit}` : "";
}

function load(drawing, own, at, { colour }) {
  const { pen, eye, words } = drawing;
  const text = sized(own, own.kind === "force" ? "N" : "N m");
  const along = own.vector && seen(drawing, own.vector);
  if (own.kind === "moment" && eye.planar) {
    symbols.turn(pen, at, !String(own.args.moment ?? "").trim().startsWith("-"));
    words.write(text, at[0] + 20, at[1] - 14, colour);
    return [at[0], at[1] - 16];
  }
  if (!along) {
    tag(drawing, own, at, { colour, before: 0 });
    return [at[0] + 14, at[1] + 14];
  }
  const into = drawing.into(own.node?.name);
  // A push comes from outside, a pull goes outwards.
  const pushes = along[0] * into[0] + along[1] * into[1] > 0.2;
  const far = [at[0] + (pushes ? -1 : 1) * LONG * along[0], at[1] + (pushes ? -1 : 1) * LONG * along[1]];
  const near = [at[0] + (pushes ? -6 : 6) * along[0], at[1] + (pushes ? -6 : 6) * along[1]];
  pen.lineWidth = 2.2;
  symbols.arrow(pen, ...(pushes ? [far, near] : [near, far]), { heads: own.kind === "moment" ? 2 : 1, size: 11 });
  const right = far[0] - at[0] >= -4;
  words.write(text, far[0] + (right ? 7 : -7), far[1] + (far[1] < at[1] ? -4 : 6), colour, right ? "left" : "right");
  return [(near[0] + far[0]) / 2, (near[1] + far[1]) / 2];
}

function lump(drawing, own, at, { before }) {
  const { pen, colours, words } = drawing;
  symbols.mass(pen, at, colours.mark, colours.back);
  const told = own.args.mass ?? own.args.inertia;
  const unit = own.args.mass === undefined ? "kg m²" : "kg";
  const text = Array.isArray(told) || told === undefined ? own.kind : isPlain(told) ? `${shown(told)} ${unit}` : String(told).slice(0, 24);
  words.write(text, at[0] + 12, at[1] + 14 + 13 * Math.max(before - 1, 0), colours.soft);
  return at;
}

function signal(drawing, own, at, { colour, before }) {
  const { pen, words, eye } = drawing;
  const component = own.components[0] ?? "";
  const vector = axisOf(component);
  const along = vector && seen(drawing, vector);
  pen.lineWidth = 1.6;
  if (!along || !own.node) {
    const turns = eye.planar && component.startsWith("phi");
    if (turns && own.kind !== "output" && own.kind !== "sensor") symbols.turn(pen, at, true, 20);
    return tag(drawing, { ...own, tag: `${WORDS[own.kind] ?? own.kind} ${component.replace("phi", "φ")}` }, at, { colour, before });
  }
  // Beside the node, on the side where no element is, one above the other.
  const into = drawing.into(own.node.name);
  const side = -along[1] * into[0] + along[0] * into[1] > 0 ? -1 : 1;
  const row = `${own.node.name} ${own.components[0]}`;
  const rows = drawing.rows.get(row) ?? 0;
  drawing.rows.set(row, rows + 1);
  const aside = 16 + 17 * rows;
  const shift = (by) => [at[0] + by * along[0] - side * aside * along[1], at[1] + by * along[1] + side * aside * along[0]];
  const [from, to] = [shift(10), shift(46)];
  symbols.arrow(pen, from, to, own.kind === "dof" ? { both: true, size: 8 } : { open: true, size: 8 });
  const flat = Math.abs(along[0]) > 0.5;
  const left = along[0] < -0.5;
  const text = own.kind === "dof" ? `DOF ${component}` : own.name ? cutTo(own.name, 16) : `${WORDS[own.kind]} ${component}`;
  words.write(text, to[0] + (left ? -6 : flat ? 6 : 4), to[1] + (flat ? 0 : 7 * Math.sign(along[1])), colour, left ? "right" : "left");
  return shift(28);
}

const WORDS = { input: "in", output: "out", actuator: "in", sensor: "out", dof: "DOF" };
const cutTo = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

/** Whatever has no sign of its own. */
function tag(drawing, own, at, { colour, before }) {
  const x = at[0] + 14;
  const y = at[1] + 16 + 14 * before;
  drawing.words.write(cutTo(own.tag ?? own.name ?? own.kind, 20), x, y, colour);
  return [x + 8, y];
}

/** What belongs to no node, such as gravity, stands in the upper right corner. */
function nowhere(drawing, own, before) {
  const { pen, eye, colours, words } = drawing;
  const at = [eye.stage.width - 34, 30 + 54 * before];
  const along = own.vector && seen(drawing, own.vector);
  pen.strokeStyle = pen.fillStyle = colours[COLOURS[own.kind]] ?? colours.load;
  pen.lineWidth = 2;
  if (along) {
    const [from, to] = [-14, 14].map((by) => [at[0] + by * along[0], at[1] + by * along[1]]);
    symbols.arrow(pen, from, to, { size: 8 });
  }
  words.write(own.kind === "gravity" ? "g" : cutTo(own.name ?? own.kind, 20), at[0] - 16, at[1], pen.fillStyle, "right");
  drawing.spot(own.id, at, 16);
}
