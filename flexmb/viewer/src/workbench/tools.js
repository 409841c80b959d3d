/** What a click does: select and move, or make something new. */
import { Dragging, nodesOf } from "./dragging.js";
import { Measure } from "./measure.js";
import { Placing } from "./placing.js";
import { thingAt, within } from "./snap.js";
import * as symbols from "./symbols.js";
import { fade } from "./colours.js";

/** The tool of the store's description of it. */
export function toolOf(canvas, tool) {
  if (tool.kind === "select") return new Select(canvas);
  if (tool.kind === "measure") return new Measure(canvas);
  if (tool.kind === "node") return new Placing(canvas, "node", {}, "node");
  return new Placing(canvas, tool.call, tool.args ?? {}, tool.kind);
}

// How far the hand goes before a click becomes a drag [px].
const SLACK = 4;

class Select {
  constructor(canvas) {
    this.canvas = canvas;
    this.prompt = "";
  }

  get options() {
    const { dragging, anchor } = this;
    if (!dragging) return { lines: false };
    return { except: dragging.names, through: anchor?.at ?? null, lines: false };
  }

  press(place, { x, y, shift, reach }) {
    const { canvas } = this;
    this.start = [x, y];
    this.place = place;
    this.axis = canvas.handleAt(x, y);
    const id = this.axis === null ? thingAt(canvas, x, y, reach) : null;
    this.rectangle = this.axis === null && id === null;
    this.shift = shift;
    const selected = canvas.store.state.selection;
    if (id === null) return;
    this.toggled = shift && selected.includes(id);
    if (shift) canvas.store.select([id], { add: true });
    else if (!selected.includes(id)) canvas.store.select([id]);
    else this.only = id;
    canvas.tell(id);
  }

  drag(place, { x, y }) {
    const { canvas } = this;
    this.end = [x, y];
    if (this.rectangle || !this.start) return;
    if (!this.dragging && Math.hypot(x - this.start[0], y - this.start[1]) < SLACK) return;
    this.dragging ??= this.begin();
    if (!this.dragging) return;
    const delta = place.point.map((value, k) => value - this.anchor.at[k]);
    if (this.axis !== null) {
      // Along one axis: how far the hand went along its picture.
      const [u, v] = canvas.eye.direction([0, 1, 2].map((k) => Number(k === this.axis)));
      const far = ((x - this.start[0]) * u + (y - this.start[1]) * v) / (u * u + v * v);
      const own = canvas.grid.snap ? Math.round(far / canvas.step) * canvas.step : far;
      delta.fill(0)[this.axis] = own;
    }
    this.delta = delta;
    this.dragging.by(delta);
    this.join = this.axis === null && place.kind === "node" && this.dragging.nodes.length === 1 ? place.node : null;
    const told = this.join ? `join ${this.anchor.name} to ${this.join.name}` : place.word;
    canvas.tip([told, this.dragging.words].filter(Boolean).join("; "), x, y);
  }

  begin() {
    const { canvas } = this;
    const ids = nodesOf(canvas, canvas.store.state.selection);
    if (!ids.length) {
      canvas.say("This moves with its node: move the node.");
      this.start = null;
      return null;
    }
    const dragging = new Dragging(canvas, ids);
    const near = ([x, y]) => Math.hypot(x - this.start[0], y - this.start[1]);
    const sorted = [...dragging.nodes].sort((a, b) => near(canvas.eye.project(a.at)) - near(canvas.eye.project(b.at)));
    this.anchor = sorted[0];
    // A line that is taken in the middle goes by whole steps from where it was taken.
    if (near(canvas.eye.project(this.anchor.at)) > 12 && this.axis === null) {
      this.anchor = { ...this.anchor, at: canvas.snapAt(...this.start, { lines: false, except: dragging.names }).point };
    }
    return dragging;
  }

  release(place, { x, y, shift }) {
    const { canvas, dragging, start } = this;
    this.dragging = this.start = null;
    canvas.tip(null);
    if (dragging) {
      const join = this.join;
      this.join = null;
      dragging.end(join?.name ?? null);
      canvas.say(join ? `${this.anchor.name} joined to ${join.name}.` : `Moved to ${place.word}. ${dragging.words}`);
      return;
    }
    if (this.rectangle && start) {
      const far = Math.hypot(x - start[0], y - start[1]) > SLACK;
      canvas.store.select(far ? within(canvas, start, [x, y]) : [], { add: shift && far });
      if (far) canvas.say(`${canvas.store.state.selection.length} selected.`);
    } else if (this.only && !shift) {
      canvas.store.select([this.only]);
    }
    this.rectangle = false;
    this.only = null;
  }

  cancel() {
    const { dragging, canvas } = this;
    this.start = this.dragging = this.join = null;
    canvas.tip(null);
    if (dragging) {
      dragging.cancel();
      canvas.say("Moved back.");
      return true;
    }
    const was = this.rectangle && this.end;
    this.rectangle = false;
    return Boolean(was);
  }

  get merge() {
    return this.dragging;
  }

  draw({ pen, colours, eye }) {
    if (this.rectangle && this.start && this.end) {
      const [[a, b], [c, d]] = [this.start, this.end];
      pen.strokeStyle = colours.focus;
      pen.fillStyle = fade(colours.focus, 0.08);
      pen.lineWidth = 1;
      pen.setLineDash(c < a ? [4, 3] : []);
      pen.fillRect(a, b, c - a, d - b);
      pen.strokeRect(a, b, c - a, d - b);
      pen.setLineDash([]);
    }
    if (this.join) {
      pen.strokeStyle = colours.chosen;
      pen.lineWidth = 2.5;
      symbols.circle(pen, eye.project(this.join.at), 12);
      pen.stroke();
    }
  }
}
