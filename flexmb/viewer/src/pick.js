/** What is under the pointer: a node, or the nearest element. */

const NEAR_NODE = 8;
const NEAR_LINE = 8;

export function pick(x, y, { data, motion, visible, project }) {
  let best = null;
  let nearest = NEAR_NODE;
  for (let i = 0; i < data.nodes.names.length; i += 1) {
    const [u, v] = project(motion.nodes, i);
    const distance = Math.hypot(u - x, v - y);
    if (distance < nearest) {
      nearest = distance;
      best = { kind: "node", index: i };
    }
  }
  if (best) return best;
  nearest = NEAR_LINE;
  data.parts.forEach((part, number) => {
    if (!visible[number]) return;
    let [u, v] = project(motion.points, part.start);
    if (part.count === 1 && Math.hypot(u - x, v - y) < nearest) {
      best = { kind: "part", index: number, point: part.start };
    }
    for (let i = part.start + 1; i < part.start + part.count; i += 1) {
      const [p, q] = project(motion.points, i);
      const length = (p - u) ** 2 + (q - v) ** 2;
      const share = length ? Math.min(Math.max(((x - u) * (p - u) + (y - v) * (q - v)) / length, 0), 1) : 0;
      const distance = Math.hypot(u + share * (p - u) - x, v + share * (q - v) - y);
      if (distance < nearest) {
        nearest = distance;
        best = { kind: "part", index: number, point: share < 0.5 ? i - 1 : i };
      }
      [u, v] = [p, q];
    }
  });
  return best;
}

const number = (value) => Number(value.toPrecision(5)).toString();

/** A picked node or element in words. */
export function describe({ kind, index, point }, { data, motion, extent }) {
  // Below the digits of a 32-bit float nothing is told.
  const told = (value) => number(Math.abs(value) < 1e-6 * extent ? 0 : value);
  if (kind === "node") {
    const at = [...motion.nodes.slice(3 * index, 3 * index + data.dimension)];
    const base = data.nodes.base;
    const moved = Math.hypot(...[0, 1, 2].map((k) => motion.nodes[3 * index + k] - base[3 * index + k]));
    const place = at.map((value, k) => `${"xyz"[k]} = ${told(value)}`).join(", ");
    const more = moved > 1e-6 * extent && data.kind !== "modes" ? `, displaced by ${number(moved)} m` : "";
    return `node ${data.nodes.names[index]}: ${place} m${more}`;
  }
  const part = data.parts[index];
  const words = [`${part.kind} ${part.name}`];
  if (part.shape) {
    const sides = part.shape.round ? [part.shape.width] : [part.shape.width, part.shape.thickness];
    words.push(`${part.shape.round ? "diameter " : ""}${sides.map((side) => number(1000 * side)).join(" × ")} mm`);
  }
  if (motion.values && Number.isFinite(motion.values[point])) {
    const [, name, unit] = data.colours.label.match(/^(.*) \[(.*)\]$/) ?? [null, data.colours.label, ""];
    const own = motion.values.slice(part.start, part.start + part.count);
    const largest = own.reduce((most, value) => (Math.abs(value) > Math.abs(most) ? value : most), 0);
    words.push(`${name} ${number(motion.values[point])} ${unit} here, ${number(largest)} ${unit} at most`);
  }
  return words.join(", ");
}
