/** The panel beside the picture: what it offers, the scale of the colours, the list of elements. */
import { byId, KINDS } from "./page.js";
import { isDark } from "./theme.js";

/** Show in the panel what there is, as it stands. */
export function fill(viewer) {
  const { data } = viewer;
  byId("title").textContent = data.title;
  byId("choice-row").hidden = !data.choices.length;
  data.choices.forEach((name, i) => byId("choice").append(new Option(name, String(i))));
  byId("play-row").hidden = byId("speed-row").hidden = !viewer.plays;
  const moves = data.kind === "modes" || viewer.motion.rows > 0;
  byId("amplitude-row").hidden = !moves;
  byId("amplitude-label").textContent = data.kind === "modes" ? "Amplitude" : "Displacement";
  byId("amplitude").max = String(data.amplitude[1]);
  byId("amplitude").step = String(data.amplitude[1] / 100);
  const has = {
    ...Object.fromEntries(KINDS.map((kind) => [kind, data.parts.some((part) => part.kind === kind)])),
    supports: Object.values(data.supports).some((nodes) => nodes.length),
    masses: data.masses.length > 0,
    loads: data.marks.some((mark) => mark.kind !== "dof"),
    dofs: data.marks.some((mark) => mark.kind === "dof"),
    names: true,
    ghost: moves,
    colours: Boolean(data.colours),
  };
  for (const [what, exists] of Object.entries(has)) {
    byId(`show-${what}`).checked = viewer.shown[what];
    byId(`show-${what}`).closest("label").hidden = !exists;
  }
  if (data.colours) legend(data.colours);
  byId("scene").setAttribute("aria-label", [data.title, ...data.choices.slice(0, 1)].join(". "));
  viewer.setAmplitude(data.amplitude[0]);
  viewer.setSpeed(1);
  byId("theme").setAttribute("aria-pressed", String(isDark()));
  byId("look").hidden = viewer.stage.planar;
}

function legend({ label, low, high, table }) {
  const stops = table.map(([r, g, b]) => `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`);
  byId("legend-bar").style.background = `linear-gradient(to top, ${stops.join(", ")})`;
  byId("legend-label").textContent = label;
  byId("legend-high").textContent = Number(high.toPrecision(4));
  byId("legend-middle").textContent = Number(((high + low) / 2).toPrecision(4));
  byId("legend-low").textContent = Number(low.toPrecision(4));
}

/** List of elements with a box each, made when it is first opened. */
export function list(viewer) {
  const list = byId("elements-list");
  if (list.childElementCount) return;
  for (const part of viewer.data.parts) {
    const label = document.createElement("label");
    const tick = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
    tick.addEventListener("change", () => viewer.hide(part.name, !tick.checked));
    label.append(tick, ` ${part.name} (${part.kind})`);
    list.append(label);
  }
}

/** Leave in the list what has a text in its name or kind. */
export function filter(text) {
  const wanted = text.trim().toLowerCase();
  for (const label of byId("elements-list").children) {
    label.hidden = !label.textContent.toLowerCase().includes(wanted);
  }
}
