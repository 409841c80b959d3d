/** The drawing of a document: lines, supports, loads, masses, signals, nodes and names, over the live picture. */
import { Words } from "../words.js";
import { fade } from "./colours.js";
import { middleOf } from "./plan.js";
import { mark } from "./marks.js";
import * as symbols from "./symbols.js";

// From so many things on names are shown of what is chosen or pointed at alone.
const MANY = 40;
const WIDTH = { beam: 3.5, bar: 2.5, rigid: 6, spring: 1.8, joint: 2, hinge: 2, block: 1.5 };
const DASH = { block: [6, 4], joint: [3, 3] };

export class Drawing {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    // What was drawn where, to be pointed at: {id, x, y, radius}.
    this.spots = [];
  }

  /** `scene` tells whether the live picture is there: what it shows is then drawn thin, as the rest state. */
  draw({ plan, eye, colours, selection, hovered, problems, shares, alive, displaced, names = true, more }) {
    const { pen, canvas } = this;
    const { width, height, ratio } = eye.stage;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.lineCap = pen.lineJoin = "round";
    Object.assign(this, { plan, eye, colours, selection, hovered, problems, shares, alive, displaced });
    this.words = new Words(pen, width, height, fade(colours.back, 0.85));
    this.spots = [];
    this.places = new Map(plan.nodes.map((node) => [node.name, eye.project(node.at)]));
    for (const line of plan.lines) if (line.style === "block") this.block(line);
    for (const line of plan.lines) this.halo(line);
    for (const line of plan.lines) this.line(line);
    this.outwards();
    const taken = new Map();
    this.rows = new Map();
    for (const own of plan.marks) mark(this, own, taken);
    for (const node of plan.nodes) this.node(node);
    more?.(this);
    if (names) this.names();
  }

  // Lines.

  screen(line) {
    return line.places.map((place) => this.eye.project(place));
  }

  path(points) {
    const { pen } = this;
    pen.beginPath();
    points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  }

  halo(line) {
    const chosen = this.selection.has(line.id);
    if (!chosen && this.hovered !== line.id) return;
    const { pen, colours } = this;
    pen.strokeStyle = chosen ? fade(colours.chosen, 0.3) : fade(colours.focus, 0.25);
    pen.lineWidth = 12;
    const points = this.screen(line);
    if (points.length > 1) {
      this.path(points);
      pen.stroke();
    } else {
      symbols.circle(pen, points[0], 13);
      pen.stroke();
    }
  }

  /** What a building block covers, by the nodes that it made. */
  block(line) {
    const { pen, colours } = this;
    const own = this.plan.nodes.filter(({ id, name }) => !id && name.startsWith(`${line.name} `));
    const points = symbols.hull([...this.screen(line), ...own.map(({ name }) => this.places.get(name))]);
    if (points.length < 3) return;
    this.path(points);
    pen.closePath();
    pen.fillStyle = fade(colours.block, 0.1);
    pen.fill();
    pen.strokeStyle = fade(colours.block, 0.5);
    pen.lineWidth = 1;
    pen.setLineDash([4, 4]);
    pen.stroke();
    pen.setLineDash([]);
  }

  line(line) {
    const { pen, colours } = this;
    const points = this.screen(line);
    const wrong = this.problems.has(line.id);
    const colour = wrong ? colours.problem : this.shares?.(line.name) ?? colours[line.style] ?? colours.joint;
    pen.strokeStyle = colour;
    pen.lineWidth = WIDTH[line.style] ?? 2;
    pen.setLineDash(wrong ? [5, 4] : DASH[line.style] ?? []);
    if (this.alive?.(line.name) && !wrong) {
      // The live picture shows it: here its rest state is seen.
      if (!this.displaced && points.length > 1) return;
      pen.strokeStyle = fade(colours.ghost, 0.9);
      pen.lineWidth = 1.1;
      pen.setLineDash([4, 4]);
    }
    if (points.length < 2) {
      this.joint(points[0], colour);
    } else if (line.style === "spring" && points.length === 2) {
      symbols.spring(pen, ...points);
    } else {
      this.path(points);
      pen.stroke();
    }
    pen.setLineDash([]);
    if (line.style === "hinge" && points.length > 1) this.joint(points[0], colour);
  }

  joint(point, colour) {
    const { pen, colours } = this;
    symbols.circle(pen, point, 6.5);
    pen.fillStyle = colours.back;
    pen.fill();
    pen.setLineDash([]);
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.stroke();
  }

  /** Where lines leave each node, so that supports and loads stand on the other side. */
  outwards() {
    this.out = new Map();
    for (const line of this.plan.lines) {
      for (const node of line.nodes) {
        const here = this.places.get(node.name) ?? this.eye.project(node.at);
        const sum = this.out.get(node.name) ?? [0, 0];
        for (const other of line.nodes) {
          if (other === node) continue;
          const there = this.places.get(other.name) ?? this.eye.project(other.at);
          const along = symbols.unit([there[0] - here[0], there[1] - here[1]], [0, 0]);
          sum[0] += along[0];
          sum[1] += along[1];
        }
        this.out.set(node.name, sum);
      }
    }
  }

  /** Direction from a node into the mechanism. */
  into(name) {
    const sum = this.out.get(name) ?? [0, 0];
    return Math.hypot(...sum) > 0.3 ? symbols.unit(sum) : [0, -1];
  }

  // Nodes and names.

  node(node) {
    const { pen, colours } = this;
    const at = this.places.get(node.name);
    const chosen = node.id && this.selection.has(node.id);
    if (chosen || (node.id && this.hovered === node.id)) {
      symbols.circle(pen, at, 9);
      pen.fillStyle = chosen ? fade(colours.chosen, 0.3) : fade(colours.focus, 0.3);
      pen.fill();
    }
    symbols.circle(pen, at, node.id ? 3.6 : 2.2);
    pen.fillStyle = chosen ? colours.chosen : colours.back;
    pen.fill();
    pen.lineWidth = 1.6;
    pen.strokeStyle = this.problems.has(node.id) ? colours.problem : chosen ? colours.chosen : colours.mark;
    pen.stroke();
  }

  names() {
    const { plan, colours, selection, hovered } = this;
    const all = plan.lines.length + plan.nodes.length <= 2 * MANY;
    for (const node of plan.nodes) {
      // Those that a building block made for itself have long names.
      if ((!node.id && node.name.includes(" ")) || !(all || selection.has(node.id) || hovered === node.id)) continue;
      const [x, y] = this.places.get(node.name);
      const [u, v] = this.into(node.name);
      // Beside the line, on its outer side.
      const side = Math.abs(u) > 0.9 ? [-Math.sign(u) * 9, -11] : [u > 0.2 ? -9 : 9, v < 0 ? 9 : -10];
      this.words.write(cut(node.name), x + side[0], y + side[1], colours.text, side[0] < 0 ? "right" : "left", BOLD);
    }
    for (const line of plan.lines) {
      if (!line.name || !(all || selection.has(line.id) || hovered === line.id)) continue;
      const [x, y] = this.eye.project(middleOf(line));
      this.words.write(cut(line.name), x + 8, y - 9, colours.soft, "left", ITALIC);
    }
  }

  /** Something that can be pointed at. */
  spot(id, [x, y], radius = 9) {
    this.spots.push({ id, x, y, radius });
  }
}

const BOLD = "600 12px system-ui, sans-serif";
const ITALIC = "italic 12px system-ui, sans-serif";

/** A name that is too long to stand in a drawing. */
export const cut = (text) => (text.length > 24 ? `${text.slice(0, 22)}…` : text);
