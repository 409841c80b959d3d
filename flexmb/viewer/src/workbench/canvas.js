/** The stage of the workbench: shows the document and what was computed of it, and changes it by mouse, pen, finger and keys. */
import { valueOf } from "./arithmetic.js";
import { around } from "./around.js";
import { describe } from "./describe.js";
import { nodesOf } from "./dragging.js";
import { Drawing } from "./draw.js";
import { Eye } from "./eye.js";
import { Ground } from "./ground.js";
import { Hands } from "./hands.js";
import { Keys } from "./keys.js";
import { legend } from "./legend.js";
import { numbers, palette } from "./colours.js";
import { middleOf, planOf } from "./plan.js";
import { takeTool } from "./toolbox.js";
import { snap } from "./snap.js";
import * as space from "./space.js";
import { Swing } from "./swing.js";
import { toolOf } from "./tools.js";

export class Canvas {
  constructor({ scene, overlay, store }) {
    Object.assign(this, { scene, overlay, store });
    this.grid = { snap: true, step: null };
    this.moved = {};
    this.cursor = [0, 0, 0];
    this.keyed = false;
    this.hovered = null;
    this.place = null;
    this.times = [];
    this.revision = null;
    Object.assign(this, around(scene.parentElement, scene));
    this.eye = new Eye(scene, store.state.document?.dimension ?? 2);
    this.eye.onChange = () => this.see();
    this.ground = new Ground(this.under);
    this.drawing = new Drawing(overlay);
    this.swing = new Swing(this.eye.stage);
    this.plan = planOf(store.state);
    this.tool = toolOf(this, store.state.tool);
    this.hands = new Hands(this);
    this.keys = new Keys(this);
    this.listen();
    this.recolour();
    this.see();
    this.document();
    this.live();
    requestAnimationFrame((time) => this.frame(time));
  }

  listen() {
    const { store } = this;
    for (const key of ["document", "positions", "values", "catalogue", "revision"]) store.on(key, () => (this.stale = true));
    store.on("problems", () => (this.dirty = true));
    store.on("count", () => (this.dirty = true));
    store.on("selection", () => (this.dirty = true));
    store.on("scene", () => this.live());
    store.on("want", () => this.wanted());
    store.on("tool", () => this.choose(store.state.tool));
    // What the server said is on the screen in this frame already, not in the next.
    store.on("*", () => this.render());
    new ResizeObserver(() => this.eye.resize()).observe(this.host);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
    new MutationObserver(() => this.recolour()).observe(document.documentElement, { attributeFilter: ["data-theme", "class", "style"] });
    this.scene.addEventListener("focus", () => (this.dirty = true));
    this.scene.addEventListener("blur", () => (this.dirty = true));
  }

  // What is shown.

  get step() {
    return this.grid.step ?? this.eye.step;
  }

  /** The camera moved. */
  see() {
    this.eye.update();
    this.swing.near(this.eye.scale);
    this.grounded = this.dirty = this.sceneDirty = true;
  }

  recolour() {
    this.colours = palette();
    this.swing.recolour(this.colours);
    const { colours } = this;
    for (const box of [this.tipBox, this.promptBox, this.entry]) {
      Object.assign(box.style, { background: colours.back, color: colours.text, border: `1px solid ${colours.edge}` });
    }
    this.grounded = this.dirty = this.sceneDirty = true;
  }

  /** The document changed. */
  document() {
    this.stale = false;
    const { state } = this.store;
    const before = this.count ?? 0;
    const other = this.file !== undefined && this.file !== (state.file ?? null);
    if (state.document) {
      if (this.swing.data && this.swing.data.dimension !== state.document.dimension) this.swing.remove();
      this.eye.setDimension(state.document.dimension);
      this.file = state.file ?? null;
    }
    this.replan();
    const { nodes } = this.plan;
    this.count = nodes.length;
    // Something that was opened is looked at as a whole; what is drawn here leaves the eye where it is.
    if (nodes.length > 1 && (other || (before === 0 && !this.drawn))) this.fit();
    this.waiters = (this.waiters ?? []).filter(({ revision, done }) => state.revision < revision || done());
    if (this.analysed && this.analysed.revision !== state.revision) {
      this.live();
      this.told();
    }
    this.behind();
  }

  replan() {
    this.plan = planOf(this.store.state, this.moved);
    this.swing.only(new Set([...this.plan.lines.map(({ name }) => name), ...Object.keys(this.store.state.positions)]));
    this.dirty = this.sceneDirty = true;
  }

  /** Wait until the document of a revision is here. */
  reached(revision) {
    if (this.store.state.revision >= revision) {
      this.document();
      return Promise.resolve();
    }
    return new Promise((resolve) => (this.waiters ??= []).push({ revision, done: () => void resolve() }));
  }

  live() {
    const { scene, revision } = this.store.state;
    if (this.analysed && this.analysed.revision !== revision) this.analysed = null;
    const flat = this.store.state.document?.dimension;
    // A picture of the plane says nothing in space, and the other way round.
    this.swing.replace(scene?.view?.dimension === flat || this.analysed ? this.analysed ?? scene : null);
    this.replan();
    this.behind();
  }

  wanted() {
    this.swing.amplitude = this.store.state.want.amplitude ?? this.swing.amplitude;
    this.swing.move();
    this.sceneDirty = this.dirty = true;
  }

  /** Since when the live picture is of an older document. */
  behind() {
    const { scene, revision } = this.store.state;
    const current = this.analysed || !scene || scene.of_revision === undefined || scene.of_revision === revision;
    this.since = current ? null : this.since ?? performance.now();
  }

  frame(time) {
    const elapsed = Math.min((time - (this.last ?? time)) / 1000, 0.25);
    this.last = time;
    this.tool.dragging?.send();
    if (this.swing.advance(elapsed)) this.sceneDirty = true;
    if (this.swing.age(this.since ?? null, performance.now())) this.sceneDirty = this.dirty = true;
    if (this.sceneDirty || this.dirty || this.grounded) this.times = [...this.times.filter((other) => time - other < 1000), time];
    this.render();
    requestAnimationFrame((next) => this.frame(next));
  }

  /** Draw what has changed. */
  render() {
    if (this.stale) this.document();
    const { stage } = this.eye;
    if (this.sceneDirty) stage.draw();
    // Of which document the picture on the screen is.
    if (this.sceneDirty) this.pictured = this.swing.data ? this.store.state.scene?.of_revision ?? null : null;
    if (this.grounded) this.ground.draw(this.eye, this.colours, stage.ratio, this.step);
    if (this.dirty) this.draw();
    this.sceneDirty = this.grounded = this.dirty = false;
  }

  draw() {
    const { state } = this.store;
    const { swing } = this;
    this.drawing.draw({
      plan: this.plan,
      eye: this.eye,
      colours: this.colours,
      selection: new Set(state.selection),
      hovered: this.hovered,
      problems: new Set((state.problems ?? []).map(({ address }) => String(address ?? "").split("/")[0])),
      shares: this.shares(),
      alive: swing.names && !swing.old ? (name) => swing.names.has(name) : null,
      displaced: swing.displaced,
      more: (drawing) => this.above(drawing),
    });
  }

  /** Colours of elements by their share of a self-stress, where no live picture shows it. */
  shares() {
    const { count, want, scene } = this.store.state;
    const own = want?.state === "self-stress" && scene?.kind !== "self-stress" && count?.shares?.[want.mode ?? 0];
    if (!own) return null;
    const [from, to] = [this.colours.ghost, this.colours.load].map(numbers);
    return (name) => {
      const share = Math.min(Math.abs(own[name] ?? 0), 1);
      return `rgb(${from.map((value, k) => Math.round(value + share * (to[k] - value))).join(", ")})`;
    };
  }

  /** What the tool, the pointer and the keyboard's cursor add to the drawing. */
  above(drawing) {
    const shown = this.place && (this.tool.prompt || this.tool.dragging) ? this.place : null;
    this.tool.draw(drawing);
    if (shown) space.target(drawing, shown);
    space.handles(drawing, this);
    if (this.keyed && document.activeElement === this.scene) space.cross(drawing, this.cursor);
    if (!this.eye.planar) space.triad(drawing, this.eye);
    const { data, old } = this.swing;
    if (data?.colours && !old) legend(drawing, data.colours);
  }

  fit(direction) {
    this.eye.fit(this.plan.nodes.map(({ at }) => at), direction);
  }

  /** Look from a direction, in space. */
  look(direction) {
    this.fit(this.eye.planar ? undefined : direction);
  }

  zoom(factor) {
    this.eye.stage.zoom(factor);
    this.see();
  }

  /** Turn in space, move in the plane. */
  turn(right, down) {
    if (this.eye.planar) this.eye.stage.move(0.05 * right, -0.05 * down);
    else this.eye.stage.turn(0.1 * right, -0.1 * down);
    this.see();
  }

  /** Show the picture of an analysis in place of the live one, until the document changes; null ends it. */
  playView(view) {
    this.analysed = view && { view, revision: this.store.state.revision };
    this.live();
    this.told();
    if (view) this.play();
  }

  setAmplitude(value) {
    this.swing.amplitude = value;
    this.swing.move();
    this.sceneDirty = true;
  }

  /** All that is seen, as one canvas. */
  picture() {
    const { stage } = this.eye;
    stage.draw();
    const all = document.createElement("canvas");
    all.width = this.overlay.width;
    all.height = this.overlay.height;
    const pen = all.getContext("2d");
    pen.fillStyle = this.colours.back;
    pen.fillRect(0, 0, all.width, all.height);
    for (const layer of [this.under, this.scene, this.overlay]) pen.drawImage(layer, 0, 0, all.width, all.height);
    return all;
  }

  play(on = true) {
    this.swing.playing = on;
    this.say(on ? "Playing." : "Paused.");
  }

  setGrid(changes) {
    Object.assign(this.grid, changes);
    this.see();
    this.say(this.grid.snap ? `Grid of ${this.words([this.step])}.` : "Grid off.");
  }

  setPlane({ axis = this.eye.axis, height }) {
    if (axis !== this.eye.axis) this.eye.height = this.cursor[axis];
    this.eye.axis = axis;
    if (height !== undefined) this.eye.height = Number(height.toPrecision(12));
    this.cursor[axis] = this.eye.height;
    this.see();
    this.say(`Working plane ${["yz", "zx", "xy"][axis]} at ${"xyz"[axis]} = ${this.words([this.eye.height])}.`);
    this.host.dispatchEvent(new CustomEvent("plane"));
  }

  // Things.

  thing(id) {
    return this.store.state.document?.things.find((own) => own.id === id);
  }

  /** Ids of all that is drawn, in the order of the document. */
  order() {
    const drawn = new Set([...this.plan.nodes, ...this.plan.lines, ...this.plan.marks].map(({ id }) => id));
    return (this.store.state.document?.things ?? []).map(({ id }) => id).filter((id) => drawn.has(id));
  }

  placeOf(id) {
    const node = this.plan.nodes.find((own) => own.id === id);
    const mark = this.plan.marks.find((own) => own.id === id);
    const line = this.plan.lines.find((own) => own.id === id) ?? mark?.line;
    return node?.at ?? mark?.node?.at ?? (line ? middleOf(line) : null);
  }

  nodeOn(point) {
    const near = 1e-9 + 1e-3 * this.eye.scale;
    return this.plan.nodes.find(({ at }) => at.every((value, k) => Math.abs(value - point[k]) < near)) ?? null;
  }

  tell(id) {
    this.say(describe(this, id));
  }

  // What is done to them.

  async edit(ops, label, merge) {
    try {
      return await this.store.edit(ops, merge ? { label, merge } : { label });
    } catch (problem) {
      this.say(problem.message, true);
      return null;
    }
  }

  /** Ask the page for a dialog: "mirror", "repeat", "edit" or "keys". */
  request(what) {
    this.host.dispatchEvent(new CustomEvent("request", { detail: { what, ids: [...this.store.state.selection] }, bubbles: true }));
  }

  // Tools.

  choose(tool) {
    const same = this.tool.call !== undefined && this.tool.kind === tool.kind && this.tool.call === (tool.call ?? tool.kind);
    if (same) {
      // Only what the next thing is given has changed: clicks that were made stay.
      this.tool.args = tool.args ?? {};
      return;
    }
    this.tool.cancel();
    this.tip(null);
    this.tool = toolOf(this, tool);
    this.keys.leaving = false;
    this.told();
    if (this.tool.prompt) this.say(`${this.tool.prompt}.`);
  }

  /** Take the tool of a call in hand, with what the last thing of it was given. */
  take(call) {
    if (!this.store.state.catalogue?.[call]) {
      this.say(`There is no ${call} to draw.`, true);
      return;
    }
    takeTool(this.store, call).catch((problem) => this.say(problem.message, true));
  }

  /** What the tool waits for changed. */
  told() {
    const { prompt } = this.tool;
    const shown = prompt || (this.analysed ? "The drawing shows an analysis; Esc returns to the live drawing" : "");
    this.promptBox.hidden = !shown;
    this.promptBox.textContent = shown;
    this.scene.style.cursor = prompt ? "crosshair" : "default";
    this.dirty = true;
  }

  /** Whether there was something to end. */
  escape() {
    const { store } = this;
    if (this.tool.cancel()) {
      this.told();
      return true;
    }
    if (this.analysed) {
      this.playView(null);
      return true;
    }
    if (store.state.tool.kind !== "select") {
      store.setTool({ kind: "select" });
      return true;
    }
    const some = store.state.selection.length > 0;
    store.select([]);
    return some;
  }

  from() {
    return this.tool.options?.from?.point ?? null;
  }

  snapAt(x, y, options = {}) {
    return snap(this, x, y, { ...this.tool.options, ...options });
  }

  handleAt(x, y) {
    return space.handleAt(this, x, y);
  }

  movable() {
    return this.store.state.tool.kind === "select" ? nodesOf(this, this.store.state.selection) : [];
  }

  // Words.

  words(point) {
    return space.words(point, this.eye.planar);
  }

  /** Tell to those who do not see it; with `aloud` also beside the pointer. */
  say(text, aloud = false) {
    this.spoken.textContent = text;
    if (!aloud) return;
    this.tip(text, ...this.eye.project(this.cursor));
    clearTimeout(this.quiet);
    this.quiet = setTimeout(() => this.tip(null), 5000);
  }

  tip(text, x = 0, y = 0) {
    const { tipBox } = this;
    tipBox.hidden = !text;
    if (!text) return;
    tipBox.textContent = text;
    const { width, height } = this.eye.stage;
    tipBox.style.left = `${Math.max(4, Math.min(x + 14, width - tipBox.offsetWidth - 8))}px`;
    tipBox.style.top = `${y + 34 + tipBox.offsetHeight > height ? y - 10 - tipBox.offsetHeight : y + 14}px`;
  }

  /** Value of a text of the document. */
  value(text) {
    return valueOf(text, this.store.state.values);
  }

  get framesPerSecond() {
    return this.times.length;
  }
}
