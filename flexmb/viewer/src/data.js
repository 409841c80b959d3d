/** What the page was given: names, and arrays of 32-bit floats in base64. */

function floats(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i += 1) bytes[i] = raw.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}

/** Read the data element of the page. */
export const read = (element) => decode(JSON.parse(element.textContent));

/** Data of a page with its arrays; every array flat, as the Python side has it. */
export function decode(data) {
  const optional = (text) => (text === null ? null : floats(text));
  const parts = data.parts.map(([name, kind, start, count, shape]) => ({
    name,
    kind,
    start,
    count,
    shape: shape && { width: shape[0], thickness: shape[1], round: shape[2] },
  }));
  const colours = data.colours && { ...data.colours, values: floats(data.colours.values) };
  return {
    ...data,
    parts,
    colours,
    along: floats(data.along),
    base: floats(data.base),
    states: floats(data.states),
    across: optional(data.across),
    acrossStates: optional(data.acrossStates),
    nodes: { names: data.nodes.names, base: floats(data.nodes.base), states: floats(data.nodes.states) },
  };
}

/** Smallest box around flat points: its corners, centre and largest side. */
export function box(arrays) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const points of arrays) {
    for (let i = 0; i < points.length; i += 1) {
      low[i % 3] = Math.min(low[i % 3], points[i]);
      high[i % 3] = Math.max(high[i % 3], points[i]);
    }
  }
  const size = high.map((value, k) => Math.max(value - low[k], 0) || 0);
  return { low, high, size, extent: Math.max(...size) || 1, centre: high.map((value, k) => (value + low[k]) / 2) };
}
