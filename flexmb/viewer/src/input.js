/** What the reader does by hand and keyboard. */
import { byId, KINDS, MARKS } from "./page.js";
import { filter, list } from "./panel.js";
import { pick } from "./pick.js";

export function listen(viewer) {
  const on = (id, event, action) => byId(id).addEventListener(event, action);
  on("choice", "change", () => viewer.choose(Number(byId("choice").value)));
  on("play", "click", () => viewer.play(!viewer.playing));
  on("position", "input", () => viewer.seek(Number(byId("position").value)));
  on("amplitude", "input", () => viewer.setAmplitude(Number(byId("amplitude").value)));
  on("speed", "input", () => viewer.setSpeed(Number(byId("speed").value)));
  on("theme", "click", () => viewer.toggleTheme());
  on("fit", "click", () => viewer.look(viewer.stage.best()));
  on("save", "click", () => viewer.save());
  on("elements", "toggle", () => list(viewer));
  on("filter", "input", () => filter(byId("filter").value));
  for (const [id, direction] of Object.entries({ "look-x": [1, 0, 0], "look-y": [0, -1, 0], "look-z": [0, -1e-4, 1] })) {
    on(id, "click", () => viewer.look(direction));
  }
  for (const what of [...KINDS, ...MARKS, "colours"]) {
    on(`show-${what}`, "change", (event) => viewer.show(what, event.target.checked));
  }
  on("scene", "pointermove", (event) => hover(viewer, event));
  on("scene", "pointerleave", () => viewer.point(null));
  on("scene", "keydown", (event) => arrows(viewer, event));
  document.addEventListener("keydown", (event) => key(viewer, event));
  viewer.stage.controls.addEventListener("change", () => (viewer.dirty = true));
  new ResizeObserver(() => {
    viewer.stage.resize();
    viewer.overlaySize();
  }).observe(byId("stage"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => viewer.recolour());
}

function hover(viewer, event) {
  if (event.buttons || !viewer.project) return;
  viewer.point(pick(event.offsetX, event.offsetY, viewer), event.offsetX, event.offsetY);
}

function arrows(viewer, event) {
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (!step) return;
  event.preventDefault();
  if (event.shiftKey || viewer.stage.planar) viewer.stage.move(-0.05 * step[0], -0.05 * step[1]);
  else viewer.stage.turn(0.1 * step[0], 0.1 * step[1]);
  viewer.dirty = true;
}

function key(viewer, event) {
  const { target } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || target.matches("select, input[type=search]")) return;
  // A button or box in focus answers the space bar itself.
  if (event.key === " " && target.matches("button, input, summary")) return;
  const toggles = { n: "names", g: "ghost", c: "colours", l: "loads", d: "dofs" };
  const actions = {
    " ": () => viewer.play(!viewer.playing),
    m: () => viewer.choose(viewer.state.choice + 1),
    M: () => viewer.choose(viewer.state.choice - 1),
    ".": () => viewer.seek(Math.min(1, viewer.state.position + 0.02)),
    ",": () => viewer.seek(Math.max(0, viewer.state.position - 0.02)),
    "+": () => viewer.stage.zoom(1.2),
    "-": () => viewer.stage.zoom(1 / 1.2),
    f: () => viewer.look(viewer.stage.best()),
    e: () => viewer.step(1),
    E: () => viewer.step(-1),
    Escape: () => viewer.point(null),
    t: () => viewer.toggleTheme(),
    s: () => viewer.save(),
  };
  const what = toggles[event.key];
  const action = what ? () => viewer.show(what, !viewer.shown[what]) : actions[event.key];
  if (!action || (what && byId(`show-${what}`).closest("label").hidden)) return;
  event.preventDefault();
  action();
  viewer.dirty = true;
}
