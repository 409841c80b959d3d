/** The live picture: what the server computed, swinging on while newer ones come. */
import { box, decode } from "../data.js";
import { Motion } from "../motion.js";
import { Sweep } from "../sweep.js";
import { onScale } from "../theme.js";
import { numbers } from "./colours.js";

// What a mode takes to swing once, and what a path or motion takes [s].
const PERIOD = 2;
const DURATION = 6;
// So long a picture of an older document is taken for current, since a newer one is on its way [ms].
const PATIENCE = 500;
// Half widths in the picture [px], whatever the eye's distance: the least one, and that of what is rigid.
const LEAST = 1.8;
const RIGID = 3.2;

export class Swing {
  constructor(stage) {
    this.stage = stage;
    this.scale = 0;
    this.state = { choice: 0, amplitude: 0.1, position: 0.25 };
    this.speed = 1;
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.amplitude = null;
    this.old = false;
  }

  /** Show another scene; the phase goes on, and a mode keeps its sign, which means nothing. */
  replace(scene) {
    const data = scene && decode(scene.view ?? scene);
    if (!data?.parts.length) {
      this.remove();
      return;
    }
    if (data.kind === "modes") alike(data, this.data);
    this.data = data;
    this.motion = new Motion(data);
    this.extent = box([data.base, data.nodes.base]).extent;
    this.names = new Set(data.parts.map(({ name }) => name));
    this.visible = data.parts.map(() => true);
    // Where nothing is displaced, the rest state is what is seen.
    this.displaced = data.states.some((value, i) => Math.abs(value - (data.kind === "modes" ? 0 : data.base[i % data.base.length])) > 1e-6 * this.extent);
    this.lay();
  }

  /** A mesh for the scene as it is seen from now on. */
  lay() {
    const { sweep: before, data } = this;
    this.laid = this.scale;
    this.sweep = new Sweep(data, (RIGID / 0.006) * this.scale, LEAST * this.scale);
    if (before) {
      this.sweep.mesh.material.dispose();
      this.sweep.mesh.material = before.mesh.material;
      before.geometry.dispose();
      this.stage.scene.remove(before.mesh);
    }
    this.stage.scene.add(this.sweep.mesh);
    this.sweep.show(this.visible);
    this.move();
    this.paint();
  }

  /** The eye came nearer or went away: `scale` in metres for a pixel. */
  near(scale) {
    this.scale = scale;
    if (this.data && (scale > 1.4 * this.laid || scale < this.laid / 1.4)) this.lay();
  }

  remove() {
    if (this.sweep) {
      this.stage.scene.remove(this.sweep.mesh);
      this.sweep.geometry.dispose();
      this.sweep.mesh.material.dispose();
    }
    this.sweep = this.data = this.names = null;
  }

  /** Parts of things that are no longer there are left out. */
  only(names) {
    if (!this.data) return;
    const visible = this.data.parts.map(({ name }) => names.has(name) || blockOf(name, names));
    if (visible.some((own, i) => own !== this.visible[i])) {
      this.visible = visible;
      this.sweep.show(visible);
    }
  }

  get plays() {
    return Boolean(this.data) && (this.data.kind === "modes" || this.motion.rows > 1);
  }

  /** Whether the picture changed. */
  advance(elapsed) {
    if (!this.playing || !this.plays) return false;
    const whole = this.data.kind === "modes" ? PERIOD : DURATION;
    this.state.position = (this.state.position + (elapsed * this.speed) / whole) % 1;
    this.move();
    return true;
  }

  move() {
    if (!this.data) return;
    const { data, state } = this;
    const position = data.kind === "modes" || this.motion.rows > 1 ? state.position : 1;
    const choice = Math.min(state.choice, Math.max(data.choices.length - 1, 0));
    this.motion.update({ choice, position, amplitude: this.amplitude ?? data.amplitude[0] });
    this.sweep.update(this.motion.points, this.motion.across);
    if (data.colours && !data.choices.length && this.motion.rows > 1) this.paint();
  }

  /** Colours of a scale or of the kinds of elements; grey while the picture is of an older document. */
  paint() {
    if (!this.data || !this.palette) return;
    const { data, motion, palette } = this;
    const plain = (part) => numbers(palette[this.old ? "ghost" : part.kind] ?? palette.joint);
    const scale = !this.old && data.colours;
    this.sweep.paint((part, i) =>
      scale && Number.isFinite(motion.values[i]) ? onScale(scale, motion.values[i]) : plain(part),
    );
  }

  recolour(palette) {
    this.palette = palette;
    this.paint();
  }

  /** Whether greying changed; `since` is when the picture fell behind the document, null while it is not. */
  age(since, time) {
    const old = since !== null && time - since > PATIENCE;
    if (old === this.old) return false;
    this.old = old;
    this.paint();
    return true;
  }
}

/** Whether an element was made by a thing of the document: its name begins with that of the block. */
function blockOf(name, names) {
  for (let at = name.lastIndexOf(" "); at > 0; at = name.lastIndexOf(" ", at - 1)) {
    if (names.has(name.slice(0, at))) return true;
  }
  return false;
}

/** Turn modes about so that nodes move as they did in the last scene. */
function alike(data, last) {
  if (last?.kind !== "modes" || last.nodes.names.join() !== data.nodes.names.join()) return;
  const size = data.nodes.base.length;
  const count = Math.min(data.nodes.states.length, last.nodes.states.length) / (size || 1);
  for (let k = 0; k < count; k += 1) {
    let product = 0;
    for (let i = k * size; i < (k + 1) * size; i += 1) product += data.nodes.states[i] * last.nodes.states[i];
    if (product >= 0) continue;
    negate(data.nodes.states, k, size);
    negate(data.states, k, data.base.length);
    if (data.acrossStates) negate(data.acrossStates, k, data.across.length);
  }
}

function negate(array, k, size) {
  for (let i = k * size; i < (k + 1) * size; i += 1) array[i] = -array[i];
}
