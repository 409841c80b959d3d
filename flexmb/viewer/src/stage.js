/** The three-dimensional picture: camera, elements and ghost. */
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  ColorManagement,
  LinearSRGBColorSpace,
  LineBasicMaterial,
  LineSegments,
  MOUSE,
  OrthographicCamera,
  Scene,
  Spherical,
  TOUCH,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { MANY } from "./sweep.js";
import { css } from "./theme.js";

// Colours are shown as they are given.
ColorManagement.enabled = false;
const MARGIN = 1.25;

/** Whether a processor draws in place of a graphics card: smooth edges then cost many times the rest. */
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const told = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

/** Whether the points of a part lie on the line between its ends. */
function isStraight(base, { start, count }, close) {
  const [first, last] = [start, start + count - 1].map((i) => base.subarray(3 * i, 3 * i + 3));
  const along = first.map((value, k) => last[k] - value);
  const square = along.reduce((sum, value) => sum + value * value, 0) || 1;
  for (let i = start + 1; i < start + count - 1; i += 1) {
    const from = first.map((value, k) => base[3 * i + k] - value);
    const share = from.reduce((sum, value, k) => sum + value * along[k], 0) / square;
    if (share < 0 || share > 1 || Math.hypot(...from.map((value, k) => value - share * along[k])) > close) return false;
  }
  return true;
}

/** Line segments along every part, one where it is straight. */
function segments({ base, parts }, extent) {
  const index = [];
  for (const part of parts) {
    const end = part.start + part.count - 1;
    const step = part.count > 1 && isStraight(base, part, 1e-3 * extent) ? end - part.start : 1;
    for (let i = part.start; i < end; i += step) index.push(i, i + step);
  }
  return index;
}

export class Stage {
  constructor(canvas, data, around) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: !(data.parts.length >= MANY && isSoftware()), alpha: true });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.scene = new Scene();
    this.ghost = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
    this.ghost.frustumCulled = false;
    this.scene.add(this.ghost);
    this.replace(data, around);
  }

  /** Show another mechanism; the camera stays where it is, but where the plane gives way to space. */
  replace(data, around) {
    this.around = around;
    this.ghost.geometry.dispose();
    this.ghost.geometry = new BufferGeometry();
    this.ghost.geometry.setAttribute("position", new BufferAttribute(data.base, 3));
    this.ghost.geometry.setIndex(segments(data, around.extent));
    if (this.planar !== (data.dimension === 2)) this.hold(data.dimension === 2);
  }

  /** What turns and moves the camera by hand: in the plane it does not turn. */
  hold(planar) {
    this.planar = planar;
    this.controls?.dispose();
    this.camera.up.set(0, planar ? 1 : 0, planar ? 0 : 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    if (planar) {
      this.controls.enableRotate = false;
      this.controls.mouseButtons.LEFT = MOUSE.PAN;
      this.controls.touches.ONE = TOUCH.PAN;
    }
  }

  /** Look from a direction, at everything. */
  look(direction) {
    const { camera, controls, around } = this;
    const reach = 10 * around.extent;
    controls.target.set(...around.centre);
    camera.position.copy(controls.target).addScaledVector(new Vector3(...direction).normalize(), reach);
    camera.near = 0.01 * around.extent;
    camera.far = 2 * reach;
    camera.zoom = 1;
    this.fitted = this.span();
    this.resize();
    controls.update();
  }

  /** Width and height of everything as the camera sees it. */
  span() {
    const { camera, around, controls } = this;
    camera.lookAt(controls.target);
    camera.updateMatrixWorld();
    const right = new Vector3();
    const up = new Vector3();
    camera.matrixWorld.extractBasis(right, up, new Vector3());
    return [right, up].map((axis) => {
      const size = around.size.reduce((sum, side, k) => sum + side * Math.abs(axis.getComponent(k)), 0);
      return Math.max(size, 0.05 * around.extent) * MARGIN;
    });
  }

  /** From where a mechanism is seen best: in the plane head-on, in space so that its flat side shows. */
  best() {
    if (this.planar) return [0, 0, 1];
    const [x, y] = this.around.size;
    return x < 0.5 * y ? [1, -0.4, 0.55] : [0.4, -1, 0.55];
  }

  turn(sideways, upwards) {
    if (this.planar) return;
    const { camera, controls } = this;
    // Spherical measures from the y axis; here up is z.
    const offset = camera.position.clone().sub(controls.target);
    const at = new Spherical().setFromCartesianCoords(offset.x, offset.z, -offset.y);
    at.theta += sideways;
    at.phi -= upwards;
    at.makeSafe();
    const turned = new Vector3().setFromSpherical(at);
    camera.position.copy(controls.target).add(new Vector3(turned.x, -turned.z, turned.y));
    controls.update();
  }

  move(right, up) {
    const { camera, controls } = this;
    const step = (camera.right - camera.left) / camera.zoom;
    const x = new Vector3();
    const y = new Vector3();
    camera.matrixWorld.extractBasis(x, y, new Vector3());
    const by = x.multiplyScalar(right * step).addScaledVector(y, up * step);
    controls.target.add(by);
    camera.position.add(by);
    controls.update();
  }

  zoom(factor) {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  resize() {
    const { camera, canvas } = this;
    this.width = canvas.clientWidth || 1;
    this.height = canvas.clientHeight || 1;
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(this.width, this.height, false);
    const scale = Math.max(this.fitted[0] / this.width, this.fitted[1] / this.height) / 2;
    Object.assign(camera, {
      left: -scale * this.width,
      right: scale * this.width,
      top: scale * this.height,
      bottom: -scale * this.height,
    });
    camera.updateProjectionMatrix();
  }

  recolour(colours) {
    this.ghost.material.color = new Color(css(colours.ghost));
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  /** Function that gives the place in the picture, from its upper left corner, of the points of a flat array. */
  projection() {
    const { camera, width, height } = this;
    camera.updateMatrixWorld();
    const m = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements;
    return (array, index) => {
      const x = array[3 * index];
      const y = array[3 * index + 1];
      const z = array[3 * index + 2];
      return [
        ((m[0] * x + m[4] * y + m[8] * z + m[12] + 1) * width) / 2,
        ((1 - (m[1] * x + m[5] * y + m[9] * z + m[13])) * height) / 2,
      ];
    };
  }
}
