/** Distances: measured by two clicks, and told while something is drawn. */
import { length, shown } from "./arithmetic.js";
import * as symbols from "./symbols.js";

/** Length and direction between two places. */
export class Measure {
  constructor(canvas) {
    this.canvas = canvas;
    this.places = [];
    this.options = {};
    this.prompt = "Click the first place to measure from";
  }

  press(place) {
    if (this.places.length === 2) this.places = [];
    this.places.push(place);
    this.prompt = this.places.length === 1 ? "Click the second place" : "Click the first place to measure from";
    this.options = this.places.length === 1 ? { from: this.places[0] } : {};
    if (this.places.length === 2) this.canvas.say(words(...this.places));
    this.canvas.told();
  }

  drag() {}

  release() {}

  cancel() {
    const some = this.places.length > 0;
    this.places = [];
    this.options = {};
    return some;
  }

  draw(drawing) {
    const [first, second = this.canvas.place] = this.places;
    if (first && second) drawDimension(drawing, first.point, second.point, words(first, second));
  }
}

/** "100 mm (60 mm, 80 mm), 53.1°": the length, its parts along the axes, and in the plane the angle. */
export function words({ point: from }, { point: to }, planar = from[2] === to[2]) {
  const delta = to.map((value, k) => value - from[k]);
  const parts = delta.slice(0, planar ? 2 : 3);
  const skew = parts.filter((value) => Math.abs(value) > 1e-12).length > 1;
  const angle = (Math.atan2(delta[1], delta[0]) * 180) / Math.PI;
  const told = [length(Math.hypot(...delta))];
  if (skew) told.push(`(${parts.map(length).join(", ")})`);
  return planar ? `${told.join(" ")}, ${shown(angle)}°` : told.join(" ");
}

export function drawDimension({ pen, eye, colours, words: texts }, from, to, text) {
  const [a, b] = [eye.project(from), eye.project(to)];
  if (Math.hypot(b[0] - a[0], b[1] - a[1]) < 4) return;
  pen.strokeStyle = pen.fillStyle = colours.focus;
  pen.lineWidth = 1.2;
  const [x, y] = symbols.dimension(pen, a, b);
  const wide = pen.measureText(text).width + 12;
  const right = x < Math.min(a[0], b[0]) && x > wide;
  texts.write(text, right ? x : Math.min(x, eye.stage.width - wide), y, colours.focus, right ? "right" : "left");
}
