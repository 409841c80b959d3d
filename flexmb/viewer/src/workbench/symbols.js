/** Signs of engineering drawings, in pixels: supports, masses, springs, arrows. A direction is [x, y] of length one. */

export const unit = ([x, y], otherwise = [0, -1]) => {
  const size = Math.hypot(x, y);
  return size > 1e-9 ? [x / size, y / size] : otherwise;
};

/** A pen that draws at a place with its x axis along a direction. */
function turned(pen, [x, y], [u, v], draw) {
  pen.save();
  pen.translate(x, y);
  pen.transform(u, v, -v, u, 0, 0);
  draw();
  pen.restore();
}

function hatch(pen, x, half) {
  pen.beginPath();
  pen.moveTo(x, -half);
  pen.lineTo(x, half);
  pen.stroke();
  pen.save();
  pen.lineWidth = 1;
  pen.beginPath();
  for (let y = -half + 1; y <= half; y += 5) {
    pen.moveTo(x, y);
    pen.lineTo(x - 6, y - 5);
  }
  pen.stroke();
  pen.restore();
}

/** A wall that holds a clamped node; `out` points from the wall into the mechanism. */
export function clamp(pen, at, out) {
  turned(pen, at, out, () => hatch(pen, -1, 14));
}

/** A node that is held but turns. */
export function pin(pen, at, out, rolls = false) {
  turned(pen, at, out, () => {
    pen.beginPath();
    pen.moveTo(-3, 0);
    pen.lineTo(-15, -9);
    pen.lineTo(-15, 9);
    pen.closePath();
    pen.stroke();
    if (rolls) {
      for (const y of [-5, 5]) {
        pen.beginPath();
        pen.arc(-18, y, 2.6, 0, 2 * Math.PI);
        pen.stroke();
      }
    }
    hatch(pen, rolls ? -21 : -15, 13);
  });
}

/** A node that may go but not turn. */
export function unturned(pen, [x, y]) {
  pen.strokeRect(x - 8, y - 8, 16, 16);
}

export function diamond(pen, [x, y], size = 9) {
  pen.beginPath();
  pen.moveTo(x, y - size);
  pen.lineTo(x + size, y);
  pen.lineTo(x, y + size);
  pen.lineTo(x - size, y);
  pen.closePath();
  pen.stroke();
}

/** A lumped mass: the sign of a centre of mass. */
export function mass(pen, [x, y], dark, light, radius = 8) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fillStyle = light;
  pen.fill();
  pen.fillStyle = dark;
  for (const start of [0, Math.PI]) {
    pen.beginPath();
    pen.moveTo(x, y);
    pen.arc(x, y, radius, start, start + Math.PI / 2);
    pen.fill();
  }
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.stroke();
}

/** An arrow; `heads` at its end, and with `both` at its beginning too. */
export function arrow(pen, [x, y], [u, v], { heads = 1, both = false, open = false, size = 9 } = {}) {
  const along = unit([u - x, v - y]);
  const inside = open ? 0 : 0.8 * size;
  const ends = [[[u, v], along], ...(both ? [[[x, y], [-along[0], -along[1]]]] : [])];
  pen.beginPath();
  pen.moveTo(x + (both ? inside * along[0] : 0), y + (both ? inside * along[1] : 0));
  pen.lineTo(u - inside * along[0], v - inside * along[1]);
  pen.stroke();
  for (const [[p, q], [a, b]] of ends) {
    for (let k = 0; k < heads; k += 1) head(pen, [p - 0.8 * k * size * a, q - 0.8 * k * size * b], [a, b], size, open);
  }
}

function head(pen, [x, y], [a, b], size, open) {
  pen.beginPath();
  pen.moveTo(x - size * a - 0.42 * size * b, y - size * b + 0.42 * size * a);
  pen.lineTo(x, y);
  pen.lineTo(x - size * a + 0.42 * size * b, y - size * b - 0.42 * size * a);
  if (open) pen.stroke();
  else pen.fill();
}

/** A moment about the axis towards the reader, counter-clockwise where it is positive. */
export function turn(pen, [x, y], positive = true, radius = 16) {
  const [from, to] = positive ? [0.5, -4.1] : [2.64, 7.24];
  pen.beginPath();
  pen.arc(x, y, radius, from, to, positive);
  pen.stroke();
  const side = positive ? 1 : -1;
  const end = [x + radius * Math.cos(to), y + radius * Math.sin(to)];
  head(pen, end, [side * Math.sin(to), -side * Math.cos(to)], 9, false);
}

/** A spring between two places. */
export function spring(pen, [x, y], [u, v]) {
  const size = Math.hypot(u - x, v - y);
  const coil = Math.max(Math.min(0.6 * size, 60), 0);
  turned(pen, [x, y], unit([u - x, v - y]), () => {
    const start = (size - coil) / 2;
    pen.beginPath();
    pen.moveTo(0, 0);
    pen.lineTo(start, 0);
    for (let k = 0; k < 8; k += 1) pen.lineTo(start + ((k + 0.5) * coil) / 8, k % 2 ? 6 : -6);
    pen.lineTo(start + coil, 0);
    pen.lineTo(size, 0);
    pen.stroke();
  });
}

/** Corners of the smallest convex outline around points, in order. */
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const side = (list) => {
    const found = [];
    for (const point of list) {
      while (found.length > 1 && !left(found.at(-2), found.at(-1), point)) found.pop();
      found.push(point);
    }
    return found.slice(0, -1);
  };
  return [...side(sorted), ...side(sorted.reverse())];
}

const left = ([a, b], [c, d], [e, f]) => (c - a) * (f - b) - (d - b) * (e - a) > 0;

export function circle(pen, [x, y], radius) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
}

/** A line with arrows at both ends and ticks, as a dimension is drawn, beside two places. */
export function dimension(pen, from, to, apart = 16) {
  const along = unit([to[0] - from[0], to[1] - from[1]], [1, 0]);
  const across = [along[1] * apart, -along[0] * apart];
  const [a, b] = [from, to].map(([x, y]) => [x + across[0], y + across[1]]);
  pen.beginPath();
  for (const [start, end] of [[from, a], [to, b]]) {
    pen.moveTo(start[0] + 0.3 * across[0], start[1] + 0.3 * across[1]);
    pen.lineTo(end[0] + 0.3 * across[0], end[1] + 0.3 * across[1]);
  }
  pen.stroke();
  if (Math.hypot(b[0] - a[0], b[1] - a[1]) > 24) arrow(pen, a, b, { both: true, size: 7 });
  return [(a[0] + b[0]) / 2 + 0.55 * across[0], (a[1] + b[1]) / 2 + 0.55 * across[1]];
}
