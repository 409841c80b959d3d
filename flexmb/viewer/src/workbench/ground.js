/** What lies under the drawing: the grid of the plane that is drawn on, its axes and its measures. */
import { length } from "./arithmetic.js";

const MOST = 160;
const LETTERS = "xyz";

/** Every so many lines of the grid one is drawn stronger: at each decade. */
const strong = (step) => (/^2/.test((step / 10 ** Math.floor(Math.log10(step) + 1e-9)).toFixed(0)) ? 5 : 10);

export class Ground {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
  }

  draw(eye, colours, ratio, step) {
    const { pen, canvas } = this;
    const { width, height } = eye.stage;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const corners = [[0, 0], [width, 0], [width, height], [0, height]].map(([x, y]) => eye.at(x, y));
    const axes = eye.axes();
    const spans = axes.map((axis) => {
      const values = corners.map((corner) => corner[axis]);
      return { axis, low: Math.min(...values), high: Math.max(...values) };
    });
    // Seen flat, the plane reaches far: the middle of it is drawn.
    const own = Math.max(step, ...spans.map(({ low, high }) => (eye.planar ? 0 : (high - low) / MOST)));
    const used = own > step ? this.coarser(step, own) : step;
    const every = strong(used);
    const plain = corners[0].slice();
    const measures = [];
    for (const [k, span] of spans.entries()) {
      const other = spans[1 - k];
      for (let i = Math.ceil(span.low / used); i * used <= span.high; i += 1) {
        const line = [other.low, other.high].map((end) => {
          const place = plain.slice();
          place[span.axis] = i * used;
          place[other.axis] = end;
          return eye.project(place);
        });
        this.line(line, this.colour(i, every, other.axis, colours));
        if (eye.planar && i % every === 0) measures.push([k, line, i * used]);
      }
    }
    for (const own of measures) this.measure(...own, colours, width, height);
  }

  coarser(step, least) {
    let found = step;
    for (let factor = 2; found < least; factor = factor === 2 ? 2.5 : 2) found *= factor;
    return found;
  }

  colour(i, every, along, colours) {
    if (i === 0) return colours[`axis-${LETTERS[along]}`];
    return i % every ? colours.grid : colours.major;
  }

  line([[a, b], [c, d]], colour) {
    const { pen } = this;
    // On whole pixels, where it can be, a thin line is a sharp one.
    const sharp = (value, other) => (Math.abs(value - other) < 0.01 ? Math.round(value) + 0.5 : value);
    pen.lineWidth = 1;
    pen.strokeStyle = colour;
    pen.beginPath();
    pen.moveTo(sharp(a, c), sharp(b, d));
    pen.lineTo(sharp(c, a), sharp(d, b));
    pen.stroke();
  }

  measure(k, [[x], [, y]], value, colours, width, height) {
    const { pen } = this;
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = colours.soft;
    pen.strokeStyle = colours.back;
    pen.lineWidth = 4;
    pen.lineJoin = "round";
    const write = (...told) => {
      pen.strokeText(...told);
      pen.fillText(...told);
    };
    if (k === 0 && x > 60 && x < width - 30) {
      pen.textAlign = "center";
      pen.textBaseline = "bottom";
      write(length(value), x, height - 4);
    } else if (k === 1 && y > 20 && y < height - 26) {
      pen.textAlign = "left";
      pen.textBaseline = "middle";
      write(length(value), 5, y);
    }
  }
}
