/** Names for what is newly made. */

const LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ";

function used({ store: { state } }, taken) {
  return new Set([...taken, ...Object.keys(state.positions ?? {}), ...(state.document?.things ?? []).map(({ name }) => name)]);
}

/** A letter for a node, or a number once all are taken. */
export function freshName(canvas, taken = new Set()) {
  const all = used(canvas, taken);
  for (const letter of LETTERS) if (!all.has(letter)) return letter;
  return freeName(canvas, "N", taken);
}

/** A word with the first number that is free, "beam 1" or "N1". */
export function freeName(canvas, prefix, taken = new Set()) {
  const all = used(canvas, taken);
  const blank = prefix.length > 1 ? " " : "";
  for (let k = 1; ; k += 1) if (!all.has(`${prefix}${blank}${k}`)) return `${prefix}${blank}${k}`;
}
