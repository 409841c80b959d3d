/** The viewer of one result: reads the page's data, draws it, and answers the reader's hand and keyboard. */
import { box, read } from "./data.js";
import { Motion } from "./motion.js";
import { Overlay } from "./overlay.js";
import { describe, pick } from "./pick.js";
import { picture } from "./picture.js";
import { Stage } from "./stage.js";
import { Sweep } from "./sweep.js";
import * as theme from "./theme.js";

// What a mode takes to swing once, and what a path or motion takes from its beginning to its end [s].
const PERIOD = 2;
const DURATION = 6;
const KINDS = ["beam", "bar", "rigid", "spring", "joint", "hinge"];
const MARKS = ["supports", "masses", "loads", "dofs", "names", "ghost"];
const byId = (id) => document.getElementById(id);

/** Where the points get to: in the states, or at both ends of the swing of every mode. */
function reached({ kind, base, states, amplitude }) {
  if (kind !== "modes") return [states];
  return [-amplitude[0], amplitude[0]].map((factor) => states.map((move, i) => base[i % base.length] + factor * move));
}

class Viewer {
  constructor(data) {
    this.data = data;
    const around = box([data.base, data.nodes.base, ...reached(data)]);
    this.extent = box([data.base, data.nodes.base]).extent;
    this.motion = new Motion(data);
    this.plays = data.kind === "modes" || this.motion.rows > 1;
    this.stage = new Stage(byId("scene"), data, around);
    this.sweep = new Sweep(data, this.extent);
    this.stage.scene.add(this.sweep.mesh);
    this.overlay = new Overlay(byId("overlay"), data, this.extent);
    this.state = { choice: 0, amplitude: data.amplitude[0], position: data.kind === "modes" ? 0.25 : 1, speed: 1 };
    this.playing = false;
    this.framesPerSecond = 0;
    this.times = [];
    this.shown = Object.fromEntries(KINDS.map((kind) => [kind, true]));
    for (const mark of MARKS) this.shown[mark] = true;
    this.shown.names = data.parts.length <= 30;
    this.shown.colours = Boolean(data.colours);
    this.hidden = new Set();
    this.chosen = null;
    this.panel();
    this.listen();
    this.recolour();
    this.visibility();
    this.stage.look(this.stage.best());
    this.overlaySize();
    this.update();
    if (this.plays && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
    requestAnimationFrame((time) => this.frame(time));
  }

  // The picture.

  frame(time) {
    const elapsed = Math.min((time - (this.last ?? time)) / 1000, 0.25);
    this.last = time;
    if (this.playing) {
      const whole = this.data.kind === "modes" ? PERIOD : DURATION;
      this.state.position = (this.state.position + (elapsed * this.state.speed) / whole) % 1;
      this.update();
    }
    if (this.dirty) {
      this.draw();
      this.count(time);
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  count(time) {
    this.times = [...this.times.filter((other) => time - other < 1000), time];
    if (!this.playing) return;
    this.framesPerSecond = this.times.length;
    if (time - (this.told ?? 0) > 500) {
      byId("rate").textContent = `${this.framesPerSecond} frames/s`;
      this.told = time;
    }
  }

  update() {
    this.motion.update(this.state);
    this.sweep.update(this.motion.points, this.motion.across);
    const { colours, choices } = this.data;
    if (colours && !choices.length && this.motion.rows > 1 && this.shown.colours) this.paint();
    this.tellPosition();
    this.dirty = true;
  }

  draw() {
    this.dirty = false;
    const { stage, motion, shown, visible, colours } = this;
    stage.ghost.visible = shown.ghost;
    stage.draw();
    this.project = stage.projection();
    const { ratio, width, height } = stage;
    const chosen = this.place();
    this.overlay.draw({ motion, project: this.project, visible, shown, colours, chosen, ratio, width, height });
  }

  /** Where a ring marks what is chosen. */
  place() {
    if (!this.chosen) return null;
    const { kind, index, point } = this.chosen;
    return kind === "node" ? { array: this.motion.nodes, index } : { array: this.motion.points, index: point };
  }

  paint() {
    const { data, motion, colours, shown } = this;
    const scale = shown.colours && data.colours;
    const plain = (part) => colours[part.kind] ?? colours.joint;
    this.sweep.paint((part, i) =>
      scale && Number.isFinite(motion.values[i]) ? theme.onScale(scale, motion.values[i]) : plain(part),
    );
    this.dirty = true;
  }

  recolour() {
    this.colours = theme.colours();
    this.stage.recolour(this.colours);
    this.motion.update(this.state);
    this.paint();
    byId("legend").hidden = !(this.data.colours && this.shown.colours);
  }

  visibility() {
    this.visible = this.data.parts.map((part) => this.shown[part.kind] && !this.hidden.has(part.name));
    this.sweep.show(this.visible);
    this.dirty = true;
  }

  overlaySize() {
    const { ratio, width, height } = this.stage;
    byId("overlay").width = Math.round(width * ratio);
    byId("overlay").height = Math.round(height * ratio);
    this.dirty = true;
  }

  // What the reader asks for.

  choose(number) {
    const { choices } = this.data;
    if (!choices.length) return;
    this.state.choice = (number + choices.length) % choices.length;
    byId("choice").value = String(this.state.choice);
    this.update();
    if (this.data.kind === "self-stress") this.paint();
    this.say(choices[this.state.choice]);
  }

  play(on = true) {
    if (!this.plays) return;
    this.playing = on;
    this.times = [];
    byId("play").textContent = on ? "Pause" : "Play";
    byId("play").setAttribute("aria-pressed", String(on));
    if (!on) byId("rate").textContent = "";
  }

  seek(position) {
    this.play(false);
    this.state.position = position;
    this.update();
  }

  setAmplitude(value) {
    this.state.amplitude = value;
    byId("amplitude").value = String(value);
    byId("amplitude-text").textContent =
      this.data.kind === "modes" ? `${(100 * value).toFixed(0)} % of the size` : `× ${value.toFixed(1)}`;
    this.update();
  }

  setSpeed(value) {
    this.state.speed = value;
    byId("speed").value = String(value);
    const { along, kind } = this.data;
    const real = ((along[along.length - 1] - along[0]) * value) / DURATION;
    byId("speed-text").textContent = kind === "motion" ? `× ${real.toPrecision(2)} of real time` : `× ${value.toFixed(1)}`;
  }

  show(what, on) {
    this.shown[what] = on;
    byId(`show-${what}`).checked = on;
    if (what === "colours") this.recolour();
    this.visibility();
  }

  hide(name, on = true) {
    if (on) this.hidden.add(name);
    else this.hidden.delete(name);
    this.visibility();
  }

  toggleTheme() {
    theme.toggle();
    this.recolour();
    byId("theme").setAttribute("aria-pressed", String(theme.isDark()));
  }

  /** Choose a node or an element, or nothing, and tell about it. */
  point(found, x, y) {
    this.chosen = found;
    const tip = byId("tip");
    tip.hidden = !found;
    this.dirty = true;
    if (!found) return;
    tip.textContent = describe(found, this);
    const most = this.stage.width - tip.offsetWidth - 8;
    tip.style.left = `${Math.max(4, Math.min(x + 14, most))}px`;
    tip.style.top = `${y + 34 + tip.offsetHeight > this.stage.height ? y - 10 - tip.offsetHeight : y + 14}px`;
  }

  /** Go to the next or the last element that is seen, for those who point by keyboard. */
  step(by) {
    const count = this.data.parts.length;
    let index = this.chosen?.kind === "part" ? this.chosen.index : by > 0 ? -1 : count;
    for (let tried = 0; tried < count; tried += 1) {
      index = (index + by + count) % count;
      if (this.visible[index]) break;
    }
    const part = this.data.parts[index];
    const found = { kind: "part", index, point: part.start + (part.count >> 1) };
    this.point(found, ...this.project(this.motion.points, found.point));
    this.say(byId("tip").textContent);
  }

  say(text) {
    byId("live").textContent = text;
  }

  tellPosition() {
    const { kind } = this.data;
    const { position } = this.state;
    byId("position").value = String(position);
    const told = {
      modes: () => `phase ${Math.round(360 * position)}°`,
      path: () => `load factor ${this.motion.along(position).toPrecision(4)}`,
      motion: () => `${this.motion.along(position).toPrecision(4)} s`,
    }[kind];
    const text = told ? told() : "";
    byId("position-text").textContent = text;
    byId("position").setAttribute("aria-valuetext", text);
  }

  // The panel.

  panel() {
    const { data } = this;
    byId("title").textContent = data.title;
    byId("choice-row").hidden = !data.choices.length;
    data.choices.forEach((name, i) => byId("choice").append(new Option(name, String(i))));
    byId("play-row").hidden = byId("speed-row").hidden = !this.plays;
    const moves = data.kind === "modes" || this.motion.rows > 0;
    byId("amplitude-row").hidden = !moves;
    byId("amplitude-label").textContent = data.kind === "modes" ? "Amplitude" : "Displacement";
    byId("amplitude").max = String(data.amplitude[1]);
    byId("amplitude").step = String(data.amplitude[1] / 100);
    const has = {
      ...Object.fromEntries(KINDS.map((kind) => [kind, data.parts.some((part) => part.kind === kind)])),
      supports: Object.values(data.supports).some((nodes) => nodes.length),
      masses: data.masses.length > 0,
      loads: data.marks.some((mark) => mark.kind !== "dof"),
      dofs: data.marks.some((mark) => mark.kind === "dof"),
      names: true,
      ghost: moves,
      colours: Boolean(data.colours),
    };
    for (const [what, exists] of Object.entries(has)) {
      byId(`show-${what}`).checked = this.shown[what];
      byId(`show-${what}`).closest("label").hidden = !exists;
    }
    if (data.colours) this.legend();
    byId("scene").setAttribute("aria-label", `${data.title}. ${data.choices[0] ?? ""}`);
    this.setAmplitude(data.amplitude[0]);
    this.setSpeed(1);
    byId("theme").setAttribute("aria-pressed", String(theme.isDark()));
    byId("look").hidden = this.stage.planar;
  }

  legend() {
    const { label, low, high, table } = this.data.colours;
    const stops = table.map(([r, g, b]) => `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`);
    byId("legend-bar").style.background = `linear-gradient(to top, ${stops.join(", ")})`;
    byId("legend-label").textContent = label;
    byId("legend-high").textContent = Number(high.toPrecision(4));
    byId("legend-middle").textContent = Number(((high + low) / 2).toPrecision(4));
    byId("legend-low").textContent = Number(low.toPrecision(4));
  }

  /** List of elements with a box each, made when it is first opened. */
  list() {
    const list = byId("elements-list");
    if (list.childElementCount) return;
    for (const part of this.data.parts) {
      const label = document.createElement("label");
      const tick = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
      tick.addEventListener("change", () => this.hide(part.name, !tick.checked));
      label.append(tick, ` ${part.name} (${part.kind})`);
      list.append(label);
    }
  }

  filter(text) {
    const wanted = text.trim().toLowerCase();
    for (const label of byId("elements-list").children) {
      label.hidden = !label.textContent.toLowerCase().includes(wanted);
    }
  }

  listen() {
    const on = (id, event, action) => byId(id).addEventListener(event, action);
    on("choice", "change", () => this.choose(Number(byId("choice").value)));
    on("play", "click", () => this.play(!this.playing));
    on("position", "input", () => this.seek(Number(byId("position").value)));
    on("amplitude", "input", () => this.setAmplitude(Number(byId("amplitude").value)));
    on("speed", "input", () => this.setSpeed(Number(byId("speed").value)));
    on("theme", "click", () => this.toggleTheme());
    on("fit", "click", () => this.look(this.stage.best()));
    on("save", "click", () => this.save());
    on("elements", "toggle", () => this.list());
    on("filter", "input", () => this.filter(byId("filter").value));
    for (const [id, direction] of Object.entries({ "look-x": [1, 0, 0], "look-y": [0, -1, 0], "look-z": [0, -1e-4, 1] })) {
      on(id, "click", () => this.look(direction));
    }
    for (const what of [...KINDS, ...MARKS, "colours"]) {
      on(`show-${what}`, "change", (event) => this.show(what, event.target.checked));
    }
    on("scene", "pointermove", (event) => this.hover(event));
    on("scene", "pointerleave", () => this.point(null));
    on("scene", "keydown", (event) => this.arrows(event));
    document.addEventListener("keydown", (event) => this.key(event));
    this.stage.controls.addEventListener("change", () => (this.dirty = true));
    new ResizeObserver(() => {
      this.stage.resize();
      this.overlaySize();
    }).observe(byId("stage"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
  }

  look(direction) {
    this.stage.look(direction);
    this.overlaySize();
  }

  hover(event) {
    if (event.buttons || !this.project) return;
    this.point(pick(event.offsetX, event.offsetY, this), event.offsetX, event.offsetY);
  }

  arrows(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    if (event.shiftKey || this.stage.planar) this.stage.move(-0.05 * step[0], -0.05 * step[1]);
    else this.stage.turn(0.1 * step[0], 0.1 * step[1]);
    this.dirty = true;
  }

  key(event) {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || target.matches("select, input[type=search]")) return;
    // A button or box in focus answers the space bar itself.
    if (event.key === " " && target.matches("button, input, summary")) return;
    const toggles = { n: "names", g: "ghost", c: "colours", l: "loads", d: "dofs" };
    const actions = {
      " ": () => this.play(!this.playing),
      m: () => this.choose(this.state.choice + 1),
      M: () => this.choose(this.state.choice - 1),
      ".": () => this.seek(Math.min(1, this.state.position + 0.02)),
      ",": () => this.seek(Math.max(0, this.state.position - 0.02)),
      "+": () => this.stage.zoom(1.2),
      "-": () => this.stage.zoom(1 / 1.2),
      f: () => this.look(this.stage.best()),
      e: () => this.step(1),
      E: () => this.step(-1),
      Escape: () => this.point(null),
      t: () => this.toggleTheme(),
      s: () => this.save(),
    };
    const what = toggles[event.key];
    const action = what ? () => this.show(what, !this.shown[what]) : actions[event.key];
    if (!action || (what && byId(`show-${what}`).closest("label").hidden)) return;
    event.preventDefault();
    action();
    this.dirty = true;
  }

  /** Leave the picture as a PNG file; the answer is its address, for those who want it otherwise. */
  save() {
    this.draw();
    const canvas = picture(this.stage, byId("overlay"), this.colours, byId("legend").hidden ? null : this.data.colours);
    canvas.toBlob((blob) => {
      const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: "flexmb.png" });
      link.click();
      URL.revokeObjectURL(link.href);
      this.say("Picture saved.");
    });
    return canvas.toDataURL("image/png");
  }
}

function start() {
  const data = read(byId("data"));
  try {
    window.flexmb = new Viewer(data);
  } catch (fault) {
    byId("fault").hidden = false;
    byId("fault").textContent = `This picture cannot be drawn: ${fault.message}. It takes a browser with WebGL 2.`;
    throw fault;
  }
}

start();
