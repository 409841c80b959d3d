/** What helps to find one's way: cursor, snapping marks, axes to drag along, the working plane. */
import { length } from "./arithmetic.js";
import { fade } from "./colours.js";
import * as symbols from "./symbols.js";

const LETTERS = "xyz";
const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const HANDLE = 46;

/** Where a click would go, and the lines through other nodes that it follows. */
export function target({ pen, eye, colours }, place) {
  const at = eye.project(place.point);
  pen.lineWidth = 1;
  pen.strokeStyle = fade(colours.focus, 0.6);
  pen.setLineDash([2, 4]);
  for (const { from } of place.guides) {
    pen.beginPath();
    pen.moveTo(...eye.project(from));
    pen.lineTo(...at);
    pen.stroke();
  }
  pen.setLineDash([]);
  pen.strokeStyle = colours.focus;
  pen.lineWidth = 1.8;
  if (place.kind === "node") {
    symbols.circle(pen, at, 9);
    pen.stroke();
  } else if (place.kind === "line") {
    symbols.diamond(pen, at, 7);
  } else {
    pen.beginPath();
    for (const [u, v] of [[1, 0], [0, 1]]) {
      pen.moveTo(at[0] - 5 * u, at[1] - 5 * v);
      pen.lineTo(at[0] + 5 * u, at[1] + 5 * v);
    }
    pen.stroke();
  }
}

/** The keyboard's cursor. */
export function cross({ pen, eye, colours, words }, point) {
  const [x, y] = eye.project(point);
  pen.strokeStyle = colours.chosen;
  pen.lineWidth = 1.6;
  pen.beginPath();
  for (const [u, v] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    pen.moveTo(x + 5 * u, y + 5 * v);
    pen.lineTo(x + 17 * u, y + 17 * v);
  }
  pen.stroke();
  words.write(point.slice(0, eye.planar ? 2 : 3).map(length).join(", "), x + 12, y + 20, colours.chosen);
}

export const words = (point, planar) => point.slice(0, planar ? 2 : 3).map(length).join(", ");

/** Change of place by an arrow key: one axis of the plane goes with left and right, the other with up and down. */
export function along(eye, [right, down], size) {
  const axes = eye.axes();
  const seen = axes.map((axis) => symbols.unit(eye.direction(AXES[axis])));
  const [[a, b], [c, d]] = seen;
  const first = Math.abs(a) + Math.abs(d) >= Math.abs(b) + Math.abs(c) - 1e-9 ? 0 : 1;
  const k = right ? first : 1 - first;
  const sign = Math.sign(seen[k][0] * right + seen[k][1] * down) || 1;
  return AXES[axes[k]].map((value) => value * sign * size);
}

/** In space, arrows along the axes at the node that is chosen. */
export function handles({ pen, eye, colours, words: texts }, canvas) {
  const at = handlesAt(canvas);
  if (!at) return;
  const start = eye.project(at);
  AXES.forEach((axis, k) => {
    const end = tip(eye, start, axis);
    if (!end) return;
    pen.strokeStyle = pen.fillStyle = colours[`axis-${LETTERS[k]}`];
    pen.lineWidth = 2.2;
    const [u, v] = symbols.unit([end[0] - start[0], end[1] - start[1]]);
    symbols.arrow(pen, [start[0] + 9 * u, start[1] + 9 * v], end, { size: 10 });
    texts.write(LETTERS[k], end[0] + 8 * u, end[1] + 8 * v, pen.fillStyle, "center");
  });
}

function handlesAt(canvas) {
  if (canvas.eye.planar) return null;
  const ids = canvas.movable();
  const node = ids.length === 1 ? canvas.plan.nodes.find(({ id }) => id === ids[0]) : null;
  return node?.at ?? null;
}

function tip(eye, start, axis) {
  const [u, v] = eye.direction(axis);
  const share = Math.hypot(u, v) * eye.scale;
  return share > 0.15 ? [start[0] + HANDLE * u * eye.scale, start[1] + HANDLE * v * eye.scale] : null;
}

/** The axis whose arrow is under a place on the screen, or null. */
export function handleAt(canvas, x, y) {
  const at = handlesAt(canvas);
  if (!at) return null;
  const start = canvas.eye.project(at);
  for (const [k, axis] of AXES.entries()) {
    const end = tip(canvas.eye, start, axis);
    if (!end) continue;
    const [u, v] = [end[0] - start[0], end[1] - start[1]];
    const square = u * u + v * v;
    const share = ((x - start[0]) * u + (y - start[1]) * v) / square;
    const off = Math.abs((x - start[0]) * v - (y - start[1]) * u) / Math.sqrt(square);
    if (share > 0.3 && share < 1.25 && off < 7) return k;
  }
  return null;
}

/** How the axes lie, and the plane that is drawn on. */
export function triad({ pen, eye, colours, words: texts }, { axis, height }) {
  const start = [46, eye.stage.height - 46];
  AXES.forEach((own, k) => {
    const [u, v] = eye.direction(own).map((value) => value * eye.scale);
    const end = [start[0] + 28 * u, start[1] + 28 * v];
    pen.strokeStyle = pen.fillStyle = colours[`axis-${LETTERS[k]}`];
    pen.lineWidth = 1.8;
    if (Math.hypot(u, v) > 0.1) symbols.arrow(pen, start, end, { size: 6 });
    texts.write(LETTERS[k], start[0] + 38 * u, start[1] + 38 * v, pen.fillStyle, "center");
  });
  const plane = ["yz", "zx", "xy"][axis];
  texts.write(`plane ${plane} at ${LETTERS[axis]} = ${length(height)}`, 100, eye.stage.height - 18, colours.soft);
}
