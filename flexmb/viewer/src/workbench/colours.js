/** Colours of the drawing, light and dark. What the page's style sheet names as well is taken from there. */
import { isDark } from "../theme.js";

const LIGHT = {
  back: "#ffffff", text: "#1d2329", soft: "#5b6672", edge: "#d3d6da", focus: "#0b63ce", grid: "#eef0f3", major: "#dde1e6",
  "axis-x": "#c8443a", "axis-y": "#2f8f46", "axis-z": "#2f62c9",
  beam: "#0072b2", bar: "#0072b2", rigid: "#6b6f73", spring: "#009e73", joint: "#8a8f94", block: "#7a4fb5",
  ghost: "#9aa1a9", mark: "#22262a", load: "#c24a00", dof: "#00795a", input: "#00718f", output: "#7a3fb0",
  chosen: "#d00070", problem: "#c21f1f",
};
const DARK = {
  back: "#14181c", text: "#e8ebee", soft: "#a9b3bd", edge: "#3a434c", focus: "#7ab8ff", grid: "#1c2227", major: "#2a323a",
  "axis-x": "#ff7b70", "axis-y": "#63c97c", "axis-z": "#7fa8ff",
  beam: "#3fa3e0", bar: "#3fa3e0", rigid: "#a3a9af", spring: "#2cc79a", joint: "#858c93", block: "#b794f0",
  ghost: "#6c7680", mark: "#e8ebee", load: "#ff8a4c", dof: "#37d3a3", input: "#4cc3e6", output: "#c79bf2",
  chosen: "#ff6bb5", problem: "#ff7a7a",
};

export function palette() {
  const style = getComputedStyle(document.documentElement);
  const own = isDark() ? DARK : LIGHT;
  const named = Object.entries(own).map(([name, value]) => {
    const told = style.getPropertyValue(`--${name}`).trim();
    return [name, /^#[0-9a-f]{6}$/i.test(told) ? told : value];
  });
  return Object.fromEntries(named);
}

/** A colour "#rrggbb" as [red, green, blue] from 0 to 255. */
export const numbers = (hex) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));

export const fade = (hex, alpha) => `rgba(${numbers(hex).join(", ")}, ${alpha})`;
