/** From where the mechanism is seen, and what a place on the screen means in it. */
import { MOUSE, TOUCH, Vector3 } from "three";
import { box } from "../data.js";
import { Stage } from "../stage.js";

// Size of an empty page [m]: what flexure mechanisms have.
const EMPTY = [0.25, 0.16, 0.12];
// Lines of the grid are so far apart at least [px].
const APART = 13;
// A plane seen flatter than this, as sine of the angle, is not drawn on.
const FLAT = 0.08;

const ROOM = 1.35;

const nothing = (dimension) => ({ dimension, parts: [], base: new Float32Array(0) });

export class Eye {
  constructor(canvas, dimension) {
    this.axis = 2;
    this.height = 0;
    this.stage = new Stage(canvas, nothing(dimension), aroundOf([]));
    this.stage.ghost.visible = false;
    this.hands();
    this.fit([]);
  }

  get planar() {
    return this.stage.planar;
  }

  setDimension(dimension) {
    if ((dimension === 2) === this.planar) return;
    this.stage.replace(nothing(dimension), aroundOf([]));
    this.axis = 2;
    this.height = 0;
    this.hands();
    this.fit([]);
  }

  /** The left button and one finger draw; the others move and turn. */
  hands() {
    const { controls } = this.stage;
    controls.mouseButtons = { LEFT: null, MIDDLE: MOUSE.PAN, RIGHT: this.planar ? MOUSE.PAN : MOUSE.ROTATE };
    controls.touches = { ONE: null, TWO: this.planar ? TOUCH.DOLLY_PAN : TOUCH.DOLLY_ROTATE };
    controls.addEventListener("change", () => this.onChange?.());
  }

  /** Look at all of some places, from a direction or from where they are seen best. */
  fit(places, direction) {
    this.stage.around = aroundOf(places);
    this.stage.look(direction ?? this.stage.best());
    this.onChange?.();
  }

  resize() {
    this.stage.resize();
    this.onChange?.();
  }

  /** To be called once before a picture or an event: the camera may have moved. */
  update() {
    const { camera, width, height } = this.stage;
    camera.updateMatrixWorld();
    this.matrix = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements;
    this.width = width;
    this.height2 = height;
    this.scale = (camera.right - camera.left) / camera.zoom / width;
    this.forward = camera.getWorldDirection(new Vector3()).toArray();
    this.step = stepOf(this.scale * APART);
  }

  /** Place on the screen of a place in the mechanism. */
  project([x, y, z]) {
    const m = this.matrix;
    return [
      ((m[0] * x + m[4] * y + m[8] * z + m[12] + 1) * this.width) / 2,
      ((1 - (m[1] * x + m[5] * y + m[9] * z + m[13])) * this.height2) / 2,
    ];
  }

  /** Direction on the screen, in pixels for each metre. */
  direction(vector) {
    const [x, y] = this.project([0, 0, 0]);
    const [u, v] = this.project(vector);
    return [u - x, v - y];
  }

  /** Axis across the plane that is drawn on: as chosen, or the one best seen where that is seen edge-on. */
  normal() {
    if (Math.abs(this.forward[this.axis]) > FLAT) return this.axis;
    const seen = this.forward.map(Math.abs);
    return seen.indexOf(Math.max(...seen));
  }

  /** Place in the mechanism under a place on the screen, in a plane through `through` or the one that is drawn on. */
  at(x, y, through = null) {
    const axis = this.normal();
    const height = through ? through[axis] : axis === this.axis ? this.height : 0;
    const { camera } = this.stage;
    const start = new Vector3((2 * x) / this.width - 1, 1 - (2 * y) / this.height2, 0).unproject(camera).toArray();
    const far = (height - start[axis]) / this.forward[axis];
    const place = start.map((value, k) => value + far * this.forward[k]);
    place[axis] = height;
    return place;
  }

  /** The two axes of the plane that is drawn on. */
  axes() {
    return [0, 1, 2].filter((axis) => axis !== this.normal());
  }
}

/** Smallest of 1, 2, 5, 10, … that is not below a size. */
export function stepOf(size) {
  const ten = 10 ** Math.floor(Math.log10(size));
  const factor = [1, 2, 5, 10].find((value) => value * ten >= size * (1 - 1e-9));
  return Number((factor * ten).toPrecision(3));
}

function aroundOf(places) {
  const around = box(places.length ? [Float64Array.from(places.flat())] : [Float64Array.of(-0.05, -0.03, 0, 0.2, 0.13, 0)]);
  // One node alone, or a line of them, is seen in some room.
  const least = places.length > 1 ? 0 : EMPTY[0];
  around.extent = Math.max(...around.size, least) || EMPTY[0];
  if (places.length === 1) around.size = [EMPTY[0], EMPTY[1], 0];
  // Room to draw on, for loads and names, and for what swings.
  around.size = around.size.map((side) => ROOM * side);
  return around;
}
