/** What the hand means: a node, the middle of an element, a line through another node, a crossing of the grid. */
import { isPlain, length, textOf } from "./arithmetic.js";
import { stepOf } from "./eye.js";
import { listOf, middleOf } from "./plan.js";

const NEAR = 11;
const NEAR_MIDDLE = 10;
const NEAR_LINE = 7;
const ALIGNED = 6;
const LETTERS = "xyz";

/**
 * The place under a place on the screen.
 *
 * `from` is where a line was begun, `except` names nodes that move along, `through` a place whose height is kept; with
 * `lines`, elements are met too; `free` switches grid and lines off; `reach` widens everything, for fingers.
 */
export function snap(canvas, x, y, { from = null, except = null, through = null, lines = true, free = false, reach = 1 } = {}) {
  const { eye, plan } = canvas;
  const node = nearestNode(canvas, x, y, except, NEAR * reach);
  if (node) return { kind: "node", point: node.at.slice(), node, guides: [], word: `node ${node.name}` };
  const line = lines && !free ? nearestLine(canvas, x, y, except, reach) : null;
  if (line) return line;
  const point = eye.at(x, y, through);
  if (free) return finished(canvas, point.map((value) => Number(textOf(value, stepOf(0.5 * eye.scale)))), "free", []);
  const guides = [];
  for (const axis of eye.axes()) {
    const own = aligned(plan, point[axis], axis, from, except, eye.scale * ALIGNED);
    if (own) {
      guides.push({ axis, from: own.at, name: own.name ?? null, text: textAt(canvas, own, axis) });
      point[axis] = own.at[axis];
    } else if (canvas.grid.snap) {
      point[axis] = Number(textOf(point[axis], canvas.step));
    } else {
      point[axis] = Number(textOf(point[axis], stepOf(0.5 * eye.scale)));
    }
  }
  return finished(canvas, point, "grid", guides);
}

function finished(canvas, point, kind, guides) {
  const { planar } = canvas.eye;
  const texts = point.slice(0, planar ? 2 : 3).map((value) => textOf(value));
  // In line with a node whose coordinate is a name or arithmetic, a new one follows it.
  for (const { axis, text } of guides) if (text !== null) texts[axis] = text;
  const told = guides.filter(({ name }) => name).map(({ axis, name }) => `${LETTERS[axis]} of ${name}`);
  const place = point.slice(0, texts.length).map(length).join(", ");
  return { kind, point, texts, guides, word: told.length ? `${place} (${told.join(", ")})` : place };
}

function textAt(canvas, node, axis) {
  if (!node.id) return null;
  const text = listOf(canvas.thing(node.id)?.args.position)[axis];
  return text === undefined || isPlain(text) ? null : text;
}

export function nearestNode({ eye, plan }, x, y, except, near) {
  let best = null;
  let least = near;
  for (const node of plan.nodes) {
    if (except?.has(node.name)) continue;
    const [u, v] = eye.project(node.at);
    const distance = Math.hypot(u - x, v - y);
    if (distance < least || (distance === least && node.id)) {
      least = distance;
      best = node;
    }
  }
  return best;
}

/** Place along a line on the screen that is nearest: its share, and how far it is. */
export function along([[a, b], [c, d]], x, y) {
  const square = (c - a) ** 2 + (d - b) ** 2;
  const share = square ? Math.min(Math.max(((x - a) * (c - a) + (y - b) * (d - b)) / square, 0), 1) : 0;
  return { share, distance: Math.hypot(a + share * (c - a) - x, b + share * (d - b) - y) };
}

function nearestLine(canvas, x, y, except, reach) {
  const { eye, plan } = canvas;
  let best = null;
  let least = NEAR_LINE * reach;
  for (const line of plan.lines) {
    if (line.places.length !== 2 || line.style === "block" || line.nodes.some(({ name }) => except?.has(name))) continue;
    const ends = line.places.map((place) => eye.project(place));
    const middle = eye.project(middleOf(line));
    if (Math.hypot(middle[0] - x, middle[1] - y) < NEAR_MIDDLE * reach) {
      return onLine(line, 0.5, `middle of ${line.name}`);
    }
    const { share, distance } = along(ends, x, y);
    if (distance < least && share > 0.02 && share < 0.98) {
      least = distance;
      const own = Math.round(20 * share) / 20;
      best = onLine(line, own, `on ${line.name}, ${Math.round(100 * own)} %`);
    }
  }
  return best;
}

function onLine(line, share, word) {
  const [first, last] = line.places;
  const point = first.map((value, k) => (1 - share) * value + share * last[k]);
  return { kind: "line", point, line, share, guides: [], word };
}

function aligned(plan, value, axis, from, except, near) {
  if (from && Math.abs(from.point[axis] - value) < near) {
    return { at: from.point, name: from.node?.name ?? null, id: from.node?.id ?? null };
  }
  let best = null;
  let least = near;
  for (const node of plan.nodes) {
    const distance = Math.abs(node.at[axis] - value);
    if (distance < least && !except?.has(node.name)) {
      least = distance;
      best = node;
    }
  }
  return best;
}

/** The thing under a place on the screen: a mark, a node, or the nearest line; its id, null for nothing. */
export function thingAt(canvas, x, y, reach = 1) {
  const { eye, plan, drawing } = canvas;
  const node = nearestNode(canvas, x, y, null, 9 * reach);
  if (node?.id) return node.id;
  let best = null;
  let least = Infinity;
  for (const spot of drawing.spots) {
    const distance = Math.hypot(spot.x - x, spot.y - y);
    if (distance < spot.radius * reach && distance < least) {
      least = distance;
      best = spot.id;
    }
  }
  if (best) return best;
  least = 9 * reach;
  for (const line of plan.lines) {
    const ends = line.places.map((place) => eye.project(place));
    if (ends.length === 1) ends.push(ends[0]);
    for (let i = 1; i < ends.length; i += 1) {
      const { distance } = along([ends[i - 1], ends[i]], x, y);
      if (distance < least) {
        least = distance;
        best = line.id;
      }
    }
  }
  return best;
}

/** Ids of what lies in a rectangle; drawn from right to left, also of what it touches. */
export function within(canvas, [a, b], [c, d]) {
  const { eye, plan, drawing } = canvas;
  const [left, right] = [Math.min(a, c), Math.max(a, c)];
  const [top, bottom] = [Math.min(b, d), Math.max(b, d)];
  const inside = ([x, y]) => x >= left && x <= right && y >= top && y <= bottom;
  const touches = c < a;
  const found = plan.nodes.filter((node) => node.id && inside(eye.project(node.at))).map(({ id }) => id);
  for (const line of plan.lines) {
    const ends = line.places.map((place) => eye.project(place));
    const all = ends.every(inside);
    if (all || (touches && (ends.some(inside) || crosses(ends, left, right, top, bottom)))) found.push(line.id);
  }
  for (const spot of drawing.spots) if (inside([spot.x, spot.y])) found.push(spot.id);
  return [...new Set(found)];
}

function crosses(ends, left, right, top, bottom) {
  if (ends.length < 2) return false;
  for (let i = 0; i <= 40; i += 1) {
    const [x, y] = [0, 1].map((k) => ends[0][k] + (i / 40) * (ends[1][k] - ends[0][k]));
    if (x >= left && x <= right && y >= top && y <= bottom) return true;
  }
  return false;
}
