/** The stage by keyboard alone: a drawing cursor, letters for tools, coordinates that are typed. */
import { valueOf } from "./arithmetic.js";
import { duplicate, remove } from "./changes.js";
import * as cursor from "./cursor.js";
import { Dragging, nodesOf } from "./dragging.js";
import { along } from "./space.js";

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
// Arrow keys pressed within this time are one step of the history [ms].
const TOGETHER = 900;

const inPlane = (planar, name) => `${planar ? "planar" : "spatial"}.${name}`;
const place = (call) => () => call;

/** Letters that take the tool of a call in hand. */
export const LETTERS = {
  b: (planar) => inPlane(planar, "beam"),
  r: (planar) => inPlane(planar, "rigid_body"),
  t: (planar) => inPlane(planar, "truss"),
  p: (planar) => inPlane(planar, "leaf_spring"),
  h: place("fix"),
  l: place("force"),
  w: place("mass"),
  i: place("input"),
  o: place("output"),
  q: place("dof"),
};
const KINDS = { s: "select", v: "select", n: "node", m: "measure" };

export class Keys {
  constructor(canvas) {
    this.canvas = canvas;
    this.nudged = { time: -Infinity };
    this.leaving = false;
    canvas.scene.addEventListener("keydown", (event) => this.down(event));
    this.entry(canvas.entry);
  }

  down(event) {
    if (event.altKey || event.metaKey || event.isComposing) return;
    const { canvas } = this;
    const arrow = ARROWS[event.key];
    let done = true;
    if (event.ctrlKey && arrow) canvas.turn(...arrow);
    else if (event.ctrlKey && event.key === "a") canvas.store.select(canvas.order());
    else if (event.ctrlKey) return;
    else if (arrow) this.arrow(arrow, event.shiftKey ? 10 : 1);
    else if (event.key === "Tab") done = this.tab(event.shiftKey ? -1 : 1);
    else done = this.key(event);
    if (event.key !== "Tab" && event.key !== "Escape") this.leaving = false;
    if (!done) return;
    event.preventDefault();
    event.stopPropagation();
  }

  key({ key, shiftKey }) {
    const { canvas } = this;
    const { planar } = canvas.eye;
    const actions = {
      Enter: () => cursor.click(canvas, canvas.cursor, { shift: shiftKey }),
      Escape: () => (this.leaving = !canvas.escape()),
      Delete: () => remove(canvas),
      Backspace: () => remove(canvas),
      " ": () => canvas.play(!canvas.swing.playing),
      Home: () => canvas.fit(),
      PageUp: () => canvas.zoom(1.25),
      PageDown: () => canvas.zoom(0.8),
      "+": () => canvas.zoom(1.25),
      f: () => canvas.fit(),
      g: () => canvas.setGrid({ snap: !canvas.grid.snap }),
      d: () => duplicate(canvas),
      j: () => canvas.request("mirror"),
      a: () => canvas.request("repeat"),
      e: () => canvas.request("edit"),
    };
    const space = {
      "[": () => canvas.setPlane({ height: canvas.eye.height - canvas.step }),
      "]": () => canvas.setPlane({ height: canvas.eye.height + canvas.step }),
      x: () => canvas.setPlane({ axis: 0 }),
      y: () => canvas.setPlane({ axis: 1 }),
      z: () => canvas.setPlane({ axis: 2 }),
    };
    const action = actions[key] ?? (planar ? null : space[key]);
    if (action) {
      action();
      return true;
    }
    if (KINDS[key]) {
      canvas.store.setTool({ kind: KINDS[key] });
      return true;
    }
    if (LETTERS[key]) {
      canvas.take(LETTERS[key](planar));
      return true;
    }
    if (/^[-0-9.@=]$/.test(key)) {
      this.open(key === "=" ? "" : key);
      return true;
    }
    return false;
  }

  /** Move what is selected, or the cursor, by steps of the grid. */
  arrow(arrow, steps) {
    const { canvas } = this;
    const { store } = canvas;
    const moves = store.state.tool.kind === "select" ? nodesOf(canvas, store.state.selection) : [];
    if (!moves.length) {
      cursor.move(canvas, arrow, steps);
      return;
    }
    const delta = along(canvas.eye, arrow, steps * canvas.step);
    const now = performance.now();
    const same = this.nudged.ids === store.state.selection && now - this.nudged.time < TOGETHER;
    if (!same) this.nudged = { ids: store.state.selection, dragging: new Dragging(canvas, moves), total: [0, 0, 0] };
    const { dragging, total } = this.nudged;
    this.nudged.time = now;
    delta.forEach((value, k) => (total[k] += value));
    dragging.by(total);
    dragging.send();
    const node = dragging.nodes[0];
    canvas.cursor = canvas.plan.byName.get(node.name)?.at.slice() ?? canvas.cursor;
    canvas.say(`${node.name} at ${canvas.words(node.at.map((value, k) => value + total[k]))}. ${dragging.words}`);
    clearTimeout(this.settle);
    this.settle = setTimeout(() => dragging.end(), TOGETHER);
  }

  /** The next thing, or out of the stage after the last one. */
  tab(by) {
    const { canvas } = this;
    const all = canvas.order();
    const at = all.indexOf(canvas.store.state.selection.at(-1));
    const next = at < 0 ? (by > 0 ? 0 : all.length - 1) : at + by;
    if (this.leaving || next < 0 || next >= all.length) {
      this.leaving = false;
      return false;
    }
    canvas.store.select([all[next]]);
    const place = canvas.placeOf(all[next]);
    if (place) cursor.put(canvas, place);
    canvas.tell(all[next]);
    return true;
  }

  // Coordinates that are typed.

  entry(input) {
    input.addEventListener("keydown", (event) => {
      event.stopPropagation();
      if (event.key === "Escape") this.close();
      if (event.key === "Enter") {
        event.preventDefault();
        this.typed(input.value);
      }
    });
    input.addEventListener("blur", () => this.close(false));
  }

  open(text) {
    const { entry } = this.canvas;
    entry.hidden = false;
    entry.value = text;
    entry.focus();
    this.canvas.say("Coordinates: x, y; @ for from here; length < angle. Enter.");
  }

  close(focus = true) {
    const { canvas } = this;
    if (canvas.entry.hidden) return;
    canvas.entry.hidden = true;
    canvas.entry.removeAttribute("aria-invalid");
    if (focus) canvas.scene.focus();
  }

  typed(text) {
    const { canvas } = this;
    const { state } = canvas.store;
    const found = coordinates(text, canvas.from() ?? canvas.cursor, canvas.eye.planar, state.values, canvas.cursor);
    if (found.problem) {
      canvas.say(found.problem, true);
      canvas.entry.setAttribute("aria-invalid", "true");
      return;
    }
    this.close();
    cursor.put(canvas, found.point);
    const nodes = state.tool.kind === "select" ? nodesOf(canvas, state.selection) : [];
    const one = nodes.length === 1 && canvas.thing(nodes[0]);
    if (one) {
      canvas.edit([{ op: "set", address: `${one.id}/position`, to: found.texts }], `Move ${one.name}`);
      canvas.say(`${one.name} at ${canvas.words(found.point)}.`);
    } else if (state.tool.kind !== "select") {
      cursor.click(canvas, found.point, { texts: found.texts });
    }
  }
}

const UNITS = { m: 1, mm: 1e-3, um: 1e-6, "µm": 1e-6 };

/** A typed place: {point, texts}, or {problem}. Millimetres where "mm" stands behind a number. */
export function coordinates(text, from, planar, values, at = from) {
  const relative = text.trim().startsWith("@");
  const body = text.trim().replace(/^@\s*/, "");
  const polar = body.split("<");
  const parts = (polar.length === 2 ? polar : body.split(/[,;]\s*|\s+(?=[-+]?[\d.])/)).map((part) => numberIn(part.trim(), values));
  const wanted = planar ? 2 : 3;
  if (parts.some((part) => !part)) return { problem: `'${text}' is no place: give ${planar ? "x, y" : "x, y, z"} in metres, or with mm.` };
  if (polar.length === 2) {
    const angle = (parts[1].value * Math.PI) / 180;
    const point = [from[0] + parts[0].value * Math.cos(angle), from[1] + parts[0].value * Math.sin(angle), from[2]];
    return { point, texts: clean(point, wanted) };
  }
  if (parts.length > wanted || parts.length < 2) {
    return { problem: `A place has ${wanted} coordinates here, but '${text}' has ${parts.length}.` };
  }
  const point = at.slice();
  parts.forEach((part, k) => (point[k] = part.value + (relative ? from[k] : 0)));
  if (relative) for (let k = parts.length; k < 3; k += 1) point[k] = from[k];
  const texts = clean(point, wanted);
  if (!relative) parts.forEach((part, k) => (texts[k] = part.text ?? texts[k]));
  return { point, texts };
}

const clean = (point, wanted) => point.slice(0, wanted).map((value) => String(Number(value.toPrecision(12)) || 0));

/** Value of a number with or without a unit, or of arithmetic of names, whose text is kept. */
function numberIn(part, values) {
  const found = part.match(/^([-+]?[\d.]+(?:e[-+]?\d+)?)\s*(mm|um|µm|m)$/i);
  if (found) return { value: Number((Number(found[1]) * UNITS[found[2].toLowerCase()]).toPrecision(12)), text: null };
  const value = valueOf(part, values);
  return Number.isFinite(value) ? { value, text: part } : null;
}

