/** Colours of the page: dark or light as the system asks, until the reader chooses. */

const KINDS = ["beam", "bar", "rigid", "spring", "joint", "ghost", "text", "back", "mark", "load", "dof", "chosen"];

/** Names of the page's colours with their values as [red, green, blue], from its style sheet. */
export function colours() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(KINDS.map((kind) => [kind, parse(style.getPropertyValue(`--${kind}`).trim())]));
}

function parse(text) {
  return [1, 3, 5].map((at) => Number.parseInt(text.slice(at, at + 2), 16));
}

export function css([red, green, blue], alpha = 1) {
  return `rgba(${red}, ${green}, ${blue}, ${alpha})`;
}

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

export function toggle() {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
}

/** Colour of a value on a scale, from a table of [red, green, blue] from 0 to 1. */
export function onScale({ table, low, high }, value) {
  const at = Math.min(Math.max((value - low) / (high - low), 0), 1) * (table.length - 1);
  const first = Math.min(Math.floor(at), table.length - 2);
  const share = at - first;
  return table[first].map((part, k) => Math.round(255 * ((1 - share) * part + share * table[first + 1][k])));
}
