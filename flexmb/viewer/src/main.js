/** The viewer of one result: reads the page's data, draws it, and answers the reader's hand and keyboard. */
import { box, read } from "./data.js";
import { listen } from "./input.js";
import { Motion } from "./motion.js";
import { Overlay } from "./overlay.js";
import { byId, KINDS, MARKS } from "./page.js";
import { fill } from "./panel.js";
import { describe } from "./pick.js";
import { picture } from "./picture.js";
import { Stage } from "./stage.js";
import { Sweep } from "./sweep.js";
import * as theme from "./theme.js";

// What a mode takes to swing once, and what a path or motion takes from its beginning to its end [s].
const PERIOD = 2;
const DURATION = 6;

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
    // What is drawn comes before the panel, which sets amplitude and speed and so asks for it.
    this.recolour();
    this.visibility();
    fill(this);
    listen(this);
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
    byId("scene").setAttribute("aria-label", `${this.data.title}. ${choices[this.state.choice]}`);
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

  look(direction) {
    this.stage.look(direction);
    this.overlaySize();
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
    byId("fault").textContent = `This picture cannot be drawn: ${fault.message}. It needs a browser with WebGL 2.`;
    throw fault;
  }
}

start();
