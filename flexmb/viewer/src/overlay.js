/** Marks and texts over the picture, drawn flat: supports, masses, hinges, arrows, names. */
import { css } from "./theme.js";
import { Words } from "./words.js";

const ARROW = 0.15;

export class Overlay {
  constructor(canvas, data, extent) {
    this.canvas = canvas;
    this.data = data;
    this.extent = extent;
    this.context = canvas.getContext("2d");
    this.hinges = data.parts.map((part, i) => ({ part, i })).filter(({ part }) => part.kind === "hinge");
    const forces = data.marks.filter((mark) => mark.kind === "force").map((mark) => Math.hypot(...mark.vector));
    this.largest = Math.max(...forces, 0) || 1;
  }

  /** `project(array, index)` gives the place of a point in the picture. */
  draw({ motion, project, visible, shown, colours, chosen, ratio, width, height }) {
    const { context: pen, data } = this;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    Object.assign(this, { pen, motion, project, colours, width, height });
    this.words = new Words(pen, width, height, css(colours.back, 0.8));
    pen.lineWidth = 1.6;
    pen.strokeStyle = css(colours.mark);
    if (shown.supports) this.supports();
    if (shown.masses) {
      pen.fillStyle = css(colours.mark);
      for (const node of data.masses) this.outline(project(motion.nodes, node), circle(4.5), true);
    }
    if (shown.hinge) {
      pen.fillStyle = css(colours.back);
      for (const { part, i } of this.hinges) {
        if (visible[i]) this.outline(project(motion.points, part.start), circle(5), true);
      }
    }
    if (chosen) this.ring(chosen);
    const reach = ARROW * this.extent;
    for (const mark of data.marks) {
      if (mark.kind === "dof" ? shown.dofs : shown.loads) this.arrow(mark, reach);
    }
    if (shown.names) this.names(visible);
  }

  supports() {
    const { data, motion } = this;
    const shapes = { clamped: square, supported: triangle, prescribed: diamond };
    for (const [kind, nodes] of Object.entries(data.supports)) {
      for (const node of nodes) this.outline(this.project(motion.nodes, node), shapes[kind]);
    }
  }

  outline([x, y], trace, filled = false) {
    const { pen } = this;
    pen.beginPath();
    trace(pen, x, y);
    if (filled) pen.fill();
    pen.stroke();
  }

  ring({ array, index }) {
    const { pen, colours } = this;
    pen.strokeStyle = css(colours.chosen);
    this.outline(this.project(array, index), circle(8));
    pen.strokeStyle = css(colours.mark);
  }

  arrow(mark, reach) {
    const { pen, motion, colours } = this;
    const colour = css(mark.kind === "dof" ? colours.dof : colours.load);
    const start = this.project(motion.nodes, mark.node);
    if (!mark.vector) {
      this.words.write(mark.text, start[0] + 7, start[1] - 7, colour);
      return;
    }
    const size = Math.hypot(...mark.vector);
    const scale = (mark.kind === "force" ? size / this.largest : 1) * (reach / size);
    const at = [0, 1, 2].map((k) => motion.nodes[3 * mark.node + k] + scale * mark.vector[k]);
    const end = this.project(at, 0);
    pen.strokeStyle = pen.fillStyle = colour;
    const length = Math.hypot(end[0] - start[0], end[1] - start[1]) || 1;
    const along = [(end[0] - start[0]) / length, (end[1] - start[1]) / length];
    pen.beginPath();
    pen.moveTo(...start);
    pen.lineTo(...end);
    pen.stroke();
    const head = Math.min(10, length);
    for (const back of mark.kind === "moment" ? [0, 0.7 * head] : [0]) {
      const tip = [end[0] - back * along[0], end[1] - back * along[1]];
      pen.beginPath();
      pen.moveTo(...tip);
      pen.lineTo(tip[0] - head * along[0] - 0.4 * head * along[1], tip[1] - head * along[1] + 0.4 * head * along[0]);
      pen.lineTo(tip[0] - head * along[0] + 0.4 * head * along[1], tip[1] - head * along[1] - 0.4 * head * along[0]);
      pen.fill();
    }
    this.words.write(mark.text, end[0] + 10 * along[0], end[1] + 10 * along[1], colour, along[0] < -0.3 ? "right" : "left");
  }

  names(visible) {
    const { data, motion, colours } = this;
    data.nodes.names.forEach((name, i) => {
      const [x, y] = this.project(motion.nodes, i);
      this.words.write(name, x + 7, y - 8, css(colours.text));
    });
    data.parts.forEach((part, i) => {
      if (!visible[i]) return;
      const [before, after] = [Math.floor, Math.ceil].map((round) =>
        this.project(motion.points, part.start + round((part.count - 1) / 2)),
      );
      const [x, y] = before.map((value, k) => (value + after[k]) / 2);
      this.words.write(part.name, x + 6, y + 6, css(colours.text, 0.65), "left", "italic 12px system-ui, sans-serif");
    });
  }
}

const circle = (radius) => (pen, x, y) => pen.arc(x, y, radius, 0, 2 * Math.PI);
const square = (pen, x, y) => pen.rect(x - 7, y - 7, 14, 14);

function triangle(pen, x, y) {
  pen.moveTo(x, y);
  pen.lineTo(x - 8, y + 13);
  pen.lineTo(x + 8, y + 13);
  pen.closePath();
}

function diamond(pen, x, y) {
  pen.moveTo(x, y - 8);
  pen.lineTo(x + 8, y);
  pen.lineTo(x, y + 8);
  pen.lineTo(x - 8, y);
  pen.closePath();
}
