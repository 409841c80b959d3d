/** Mouse, pen and fingers on the stage. */
import { describe } from "./describe.js";
import { thingAt } from "./snap.js";

// A finger covers more than a mouse points at.
const REACH = { mouse: 1, pen: 1.3, touch: 2 };

export class Hands {
  constructor(canvas) {
    this.canvas = canvas;
    this.down = new Set();
    const on = (name, action) => canvas.scene.addEventListener(name, action);
    on("pointerdown", (event) => this.press(event));
    on("pointermove", (event) => this.move(event));
    on("pointerup", (event) => this.release(event));
    on("pointercancel", (event) => this.lost(event));
    on("pointerleave", () => this.leave());
    on("dblclick", () => canvas.request("edit"));
    on("contextmenu", (event) => event.preventDefault());
  }

  get busy() {
    return this.active !== undefined && this.active !== null;
  }

  at(event) {
    const { left, top } = this.canvas.scene.getBoundingClientRect();
    return { x: event.clientX - left, y: event.clientY - top, shift: event.shiftKey, reach: REACH[event.pointerType] ?? 1 };
  }

  snapped(own, event) {
    return this.canvas.snapAt(own.x, own.y, { free: event.altKey, reach: own.reach });
  }

  press(event) {
    const { canvas } = this;
    this.down.add(event.pointerId);
    // A second finger moves the page: what the first began is left.
    if (this.down.size > 1) {
      canvas.tool.cancel();
      this.active = null;
      return;
    }
    if (event.button !== 0) return;
    canvas.scene.focus({ preventScroll: true });
    canvas.keyed = false;
    this.active = event.pointerId;
    const own = this.at(event);
    canvas.place = this.snapped(own, event);
    canvas.cursor = canvas.place.point.slice();
    canvas.tool.press(canvas.place, own);
    canvas.dirty = true;
  }

  move(event) {
    const { canvas } = this;
    if (this.down.size > 1 || (event.buttons && this.active === null)) return;
    const own = this.at(event);
    canvas.keyed = false;
    canvas.place = this.snapped(own, event);
    canvas.dirty = true;
    if (this.active === event.pointerId) {
      canvas.tool.drag(canvas.place, own);
      return;
    }
    this.hover(own);
  }

  hover({ x, y, reach }) {
    const { canvas } = this;
    const id = thingAt(canvas, x, y, reach);
    canvas.hovered = id;
    const selecting = !canvas.tool.prompt;
    if (selecting) canvas.scene.style.cursor = id || canvas.handleAt(x, y) !== null ? "pointer" : "default";
    if (id && selecting) canvas.tip(describe(canvas, id), x, y);
    else if (!selecting) canvas.tip(canvas.place.word, x, y);
    else canvas.tip(null);
  }

  release(event) {
    const { canvas } = this;
    this.down.delete(event.pointerId);
    if (this.active !== event.pointerId) return;
    this.active = null;
    const own = this.at(event);
    canvas.place = this.snapped(own, event);
    canvas.tool.release(canvas.place, own);
    if (event.pointerType === "touch") canvas.place = null;
    canvas.dirty = true;
  }

  lost(event) {
    this.down.delete(event.pointerId);
    if (this.active === event.pointerId) this.canvas.tool.cancel();
    this.active = null;
  }

  leave() {
    const { canvas } = this;
    if (this.busy) return;
    canvas.hovered = null;
    canvas.place = null;
    canvas.tip(null);
    canvas.dirty = true;
  }
}
