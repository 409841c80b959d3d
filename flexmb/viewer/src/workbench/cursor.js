/** The drawing cursor of those who draw by keyboard. */
import * as space from "./space.js";

/** Move it by an arrow key, over so many steps of the grid, onto the grid. */
export function move(canvas, arrow, steps) {
  const { step } = canvas;
  const delta = space.along(canvas.eye, arrow, steps * step);
  const onGrid = (value) => Number((Math.round(value / step) * step).toPrecision(12));
  const next = canvas.cursor.map((value, k) => (delta[k] ? onGrid(value + delta[k]) : value));
  put(canvas, next);
  const { place } = canvas;
  canvas.say(place.kind === "grid" ? canvas.words(next) : `${place.word}, ${canvas.words(next)}`);
}

export function put(canvas, point) {
  canvas.cursor = point.slice();
  canvas.keyed = true;
  canvas.place = here(canvas);
  canvas.hovered = null;
  canvas.dirty = true;
}

/** What is where it stands: a node, a place on an element, or a place of its own. */
function here(canvas) {
  const [x, y] = canvas.eye.project(canvas.cursor);
  const met = canvas.snapAt(x, y, { free: true, lines: true });
  const near = met.point.every((value, k) => Math.abs(value - canvas.cursor[k]) < 3 * canvas.eye.scale);
  if ((met.kind === "node" || met.kind === "line") && near) return met;
  const point = canvas.cursor.slice();
  const texts = point.slice(0, canvas.eye.planar ? 2 : 3).map((value) => String(Number(value.toPrecision(12)) || 0));
  return { kind: "grid", point, texts, guides: [], word: canvas.words(point) };
}

/** A click at a place, which may be given as texts with names. */
export function click(canvas, point = canvas.cursor, { texts = null, shift = false } = {}) {
  put(canvas, point);
  if (texts && canvas.place.kind === "grid") canvas.place.texts = texts;
  const [x, y] = canvas.eye.project(point);
  const event = { x, y, shift, reach: 1 };
  canvas.tool.press(canvas.place, event);
  canvas.tool.release(canvas.place, event);
}
