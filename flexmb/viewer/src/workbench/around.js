/** Elements that the stage of the page has beside its two canvases. */

function make(tag, attributes, style) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  Object.assign(element.style, style);
  return element;
}

const WHOLE = { position: "absolute", inset: "0", width: "100%", height: "100%", display: "block", pointerEvents: "none" };
const BOX = { position: "absolute", padding: "3px 8px", borderRadius: "4px", font: "12px system-ui, sans-serif" };
const MIDDLE = { left: "50%", transform: "translateX(-50%)" };
const UNSEEN = { position: "absolute", width: "1px", height: "1px", overflow: "hidden", clipPath: "inset(50%)", whiteSpace: "nowrap" };

/** What lies under the drawing, a tip, what a tool waits for, a field for coordinates, and spoken words. */
export function around(stage, scene) {
  const under = make("canvas", { "aria-hidden": "true", id: "ground" }, WHOLE);
  stage.insertBefore(under, stage.firstChild);
  const tipBox = make("div", { id: "canvas-tip" }, { ...BOX, pointerEvents: "none", maxWidth: "24rem", zIndex: "3" });
  const promptBox = make("div", { id: "prompt" }, { ...BOX, ...MIDDLE, pointerEvents: "none", top: "10px" });
  const entry = make(
    "input",
    { id: "entry", type: "text", "aria-label": "Coordinates", autocomplete: "off", spellcheck: "false" },
    { ...BOX, ...MIDDLE, bottom: "34px", width: "16rem", font: "14px ui-monospace, monospace", zIndex: "4" },
  );
  entry.placeholder = "x, y   or   @dx, dy   or   length < angle";
  const spoken = make("div", { id: "spoken", role: "status", "aria-live": "polite" }, UNSEEN);
  entry.hidden = tipBox.hidden = promptBox.hidden = true;
  stage.append(tipBox, promptBox, entry, spoken);
  scene.setAttribute("role", "application");
  scene.setAttribute("aria-label", "Drawing of the mechanism");
  scene.style.touchAction = "none";
  return { host: stage, under, tipBox, promptBox, entry, spoken };
}
