/** The three-dimensional picture: camera, light, elements and ghost. */
import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  ColorManagement,
  DirectionalLight,
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

// A colour is shown as it is given where a face looks at the reader, so that it is the one of the scale.
ColorManagement.enabled = false;
const AMBIENT = 0.7;
const MARGIN = 1.25;

/** Whether a processor draws in place of a graphics card: smooth edges then cost many times the rest. */
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const told = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

/** Line segments between the points of every part. */
function segments(data) {
  const index = [];
  for (const { start, count } of data.parts) {
    for (let i = start; i + 1 < start + count; i += 1) index.push(i, i + 1);
  }
  return index;
}

export class Stage {
  constructor(canvas, data, around) {
    this.canvas = canvas;
    this.around = around;
    this.planar = data.dimension === 2;
    this.renderer = new WebGLRenderer({ canvas, antialias: !(data.parts.length >= MANY && isSoftware()), alpha: true });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.camera.up.set(0, this.planar ? 1 : 0, this.planar ? 0 : 1);
    this.scene = new Scene();
    const sun = new DirectionalLight(0xffffff, (1 - AMBIENT) * Math.PI);
    this.camera.add(sun, sun.target);
    sun.position.set(0, 0, 1);
    sun.target.position.set(0, 0, 0);
    this.scene.add(this.camera, new AmbientLight(0xffffff, AMBIENT * Math.PI));
    this.ghost = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
    this.ghost.geometry.setAttribute("position", new BufferAttribute(data.base, 3));
    this.ghost.geometry.setIndex(segments(data));
    this.ghost.frustumCulled = false;
    this.scene.add(this.ghost);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    if (this.planar) {
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
    return x < 0.5 * y ? [1, -0.45, 0.45] : [0.45, -1, 0.45];
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
