/** All elements as one mesh: the outline of a section swept along each line. */
import { BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Mesh, ShaderMaterial } from "three";

// Radius of what has no section, and least half side of what has one, as share of the extent.
const RADIUS = { beam: 0.003, bar: 0.002, rigid: 0.006, spring: 0.0015, joint: 0.0015 };
const LEAST = 0.0015;
// From so many elements on a section is drawn as the cross of its two middle planes, a third of the triangles.
export const MANY = 500;

// Light comes from the reader: a face that looks there has just the colour that it was given, that of the scale.
const VERTEX = `
  varying vec3 shown;
  void main() {
    float facing = abs(normalize(normalMatrix * normal).z);
    shown = color * (0.65 + 0.35 * facing);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const FRAGMENT = `
  varying vec3 shown;
  void main() {
    gl_FragColor = vec4(shown, 1.0);
  }`;

/**
 * What is swept along a line. Each vertex: where it lies over the half sides, along the width and the thickness, and its
 * normal there. Each edge joins two vertices, counter-clockwise.
 */
const STRIP = { vertices: [[0, 1, 1, 0], [0, -1, 1, 0]], edges: [[1, 0]], capped: false };
const CROSS = {
  vertices: [[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 1, 0], [0, -1, 1, 0]],
  edges: [[0, 1], [3, 2]],
  capped: false,
};
const BOX = {
  // Corners twice, once for each side that meets there.
  vertices: [
    [1, 1, 0, 1], [-1, 1, 0, 1], [-1, 1, -1, 0], [-1, -1, -1, 0],
    [-1, -1, 0, -1], [1, -1, 0, -1], [1, -1, 1, 0], [1, 1, 1, 0],
  ],
  edges: [[0, 1], [2, 3], [4, 5], [6, 7]],
  capped: true,
};
const ROUND = {
  vertices: Array.from({ length: 8 }, (_, k) => {
    const [c, s] = [Math.cos((k * Math.PI) / 4), Math.sin((k * Math.PI) / 4)];
    return [c, s, c, s];
  }),
  edges: Array.from({ length: 8 }, (_, k) => [k, (k + 1) % 8]),
  capped: true,
};

/** Half sides of a part, none below the least, and what is swept along it. */
function outline(part, extent, least, planar, many) {
  const flat = planar ? STRIP : many ? CROSS : null;
  if (!part.shape) {
    const radius = Math.max((RADIUS[part.kind] ?? LEAST) * extent, least);
    return { a: radius, b: radius, profile: flat ?? ROUND };
  }
  const { width, thickness, round } = part.shape;
  return { a: Math.max(width / 2, least), b: Math.max(thickness / 2, least), profile: flat ?? (round ? ROUND : BOX) };
}

/** Triangles between the rings of one part, and at both its ends, counter-clockwise seen from outside. */
function triangles({ count, first, profile }) {
  const found = [];
  const size = profile.vertices.length;
  for (let i = 0; i + 1 < count; i += 1) {
    const here = first + i * size;
    const next = here + size;
    for (const [k, l] of profile.edges) found.push(here + k, next + l, next + k, here + k, here + l, next + l);
  }
  const last = first + (count - 1) * size;
  for (let k = 1; profile.capped && k + 1 < size; k += 1) {
    found.push(first, first + k + 1, first + k, last, last + k, last + k + 1);
  }
  return found;
}

export class Sweep {
  constructor(data, extent, least = LEAST * extent) {
    this.planar = data.dimension === 2;
    const many = data.parts.length >= MANY;
    let count = 0;
    this.parts = data.parts.map((part) => {
      const first = count;
      const drawn = outline(part, extent, least, this.planar, many);
      if (part.count > 1) count += part.count * drawn.profile.vertices.length;
      return { ...part, ...drawn, first };
    });
    this.positions = new Float32Array(3 * count);
    this.normals = new Float32Array(3 * count);
    this.colours = new Uint8Array(3 * count);
    this.geometry = new BufferGeometry();
    const attributes = [
      ["position", this.positions, false],
      ["normal", this.normals, false],
      ["color", this.colours, true],
    ];
    for (const [name, array, normalised] of attributes) {
      this.geometry.setAttribute(name, new BufferAttribute(array, 3, normalised).setUsage(DynamicDrawUsage));
    }
    this.pieces = this.parts.map((part) => (part.count > 1 ? triangles(part) : []));
    const shaders = { vertexShader: VERTEX, fragmentShader: FRAGMENT };
    const material = new ShaderMaterial({ ...shaders, vertexColors: true, side: DoubleSide });
    this.mesh = new Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
  }

  /** Draw only the parts that are visible. */
  show(visible) {
    const chosen = this.pieces.filter((_, i) => visible[i]);
    const index = new Uint32Array(chosen.reduce((sum, piece) => sum + piece.length, 0));
    let at = 0;
    for (const piece of chosen) {
      index.set(piece, at);
      at += piece.length;
    }
    this.geometry.setIndex(new BufferAttribute(index, 1));
  }

  /** Lay the mesh around the points; `across` says where a section's width points, zero where nothing does. */
  update(points, across) {
    for (const part of this.parts) {
      if (part.count > 1) this.sweep(part, points, across);
    }
    this.geometry.attributes.position.needsUpdate = true;
    this.geometry.attributes.normal.needsUpdate = true;
  }

  sweep(part, points, across) {
    const { positions, normals } = this;
    const { a, b, profile } = part;
    const last = part.start + part.count - 1;
    let at = 3 * part.first;
    let yx = 0;
    let yy = 0;
    let yz = this.planar ? 1 : 0;
    for (let i = part.start; i <= last; i += 1) {
      const before = 3 * Math.max(i - 1, part.start);
      const after = 3 * Math.min(i + 1, last);
      let tx = points[after] - points[before];
      let ty = points[after + 1] - points[before + 1];
      let tz = points[after + 2] - points[before + 2];
      const length = Math.hypot(tx, ty, tz) || 1;
      tx /= length;
      ty /= length;
      tz /= length;
      if (across && (across[3 * i] || across[3 * i + 1] || across[3 * i + 2])) {
        yx = across[3 * i];
        yy = across[3 * i + 1];
        yz = across[3 * i + 2];
      } else if (!yx && !yy && !yz) {
        // Any direction across the line, from then on carried along it.
        if (Math.abs(tx) < 0.7) yx = 1;
        else yy = 1;
      }
      const along = yx * tx + yy * ty + yz * tz;
      yx -= along * tx;
      yy -= along * ty;
      yz -= along * tz;
      const size = Math.hypot(yx, yy, yz) || 1;
      yx /= size;
      yy /= size;
      yz /= size;
      const zx = ty * yz - tz * yy;
      const zy = tz * yx - tx * yz;
      const zz = tx * yy - ty * yx;
      for (const [u, v, p, q] of profile.vertices) {
        positions[at] = points[3 * i] + a * u * yx + b * v * zx;
        positions[at + 1] = points[3 * i + 1] + a * u * yy + b * v * zy;
        positions[at + 2] = points[3 * i + 2] + a * u * yz + b * v * zz;
        normals[at] = p * yx + q * zx;
        normals[at + 1] = p * yy + q * zy;
        normals[at + 2] = p * yz + q * zz;
        at += 3;
      }
    }
  }

  /** Colour every point; `colourOf(part, point)` gives red, green, blue from 0 to 255. */
  paint(colourOf) {
    for (const part of this.parts) {
      if (part.count < 2) continue;
      let at = 3 * part.first;
      for (let i = part.start; i < part.start + part.count; i += 1) {
        const colour = colourOf(part, i);
        for (let k = 0; k < part.profile.vertices.length; k += 1) {
          this.colours.set(colour, at);
          at += 3;
        }
      }
    }
    this.geometry.attributes.color.needsUpdate = true;
  }
}
