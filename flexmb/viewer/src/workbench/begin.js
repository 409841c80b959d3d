/** The empty page helps one begin. */
import { button, byId, h, watch } from "./dom.js";
import { icon } from "./icons.js";
import { entry, fits, title } from "./model.js";
import { takeTool } from "./toolbox.js";

const HINTS = {
  select:
    "Click to select, drag to move, Shift adds to the selection. Drag over the ground: a rectangle; right button: the view.",
  node: "Click to place a node; it snaps to the grid and to the axes of other nodes. Esc ends.",
  measure: "Click two points to see their distance. Esc ends.",
  element: "Click the first node, then the next ones; empty ground makes a new node. Esc ends.",
  block: "Click the base, then the far end; its numbers are in Properties. Esc ends.",
  place: "Click the node or element it belongs to. Esc ends.",
};

export function hint(store) {
  const line = byId("hint");
  const update = () => {
    const { tool } = store.state;
    const name = tool.call ? `${title(store, tool.call)}: ` : "";
    const kind = tool.call?.startsWith("blocks.") ? "block" : tool.kind;
    line.textContent = name + (HINTS[kind] ?? "");
    line.title = line.textContent;
  };
  store.on("tool", update);
  store.on("catalogue", update);
  update();
}

export function begin(store, { files }) {
  const root = byId("begin");
  let closed = false;
  const node = button("Draw the first node", () => start({ kind: "node" }), { class: "main" });
  const open = button("Open a file …", () => files.open());
  const blocks = h("div", { class: "chips" });
  const space = button("", () => {
    const to = store.state.document.dimension === 2 ? 3 : 2;
    store.edit([{ op: "dimension", to }], { label: to === 3 ? "In space" : "In the plane" }).catch(() => {});
  });
  root.append(
    h(
      "div",
      { role: "region", "aria-label": "How to begin" },
      h("h2", {}, "Build a mechanism"),
      h(
        "ol",
        {},
        h(
          "li",
          {},
          "Draw nodes with N, and elements from node to node: a beam bends, a rigid body does not, and the far end of a rigid beam turns freely.",
        ),
        h("li", {}, "Fix nodes that do not move, and add masses and forces."),
        h(
          "li",
          {},
          "Drag a node, or write a name (t, 2*w) into a field to get a slider: frequencies, buckling and stress follow.",
        ),
      ),
      h("div", { class: "acts" }, node, open, space),
      h("p", { class: "soft" }, "Or begin with a building block:"),
      blocks,
    ),
  );

  async function start(tool) {
    closed = true;
    if (tool.call) await takeTool(store, tool.call);
    else store.setTool(tool);
    update();
    byId("scene").focus();
  }

  function update() {
    const { document: own, tool } = store.state;
    if (own?.things.length) closed = false;
    root.hidden = !own || own.things.length > 0 || closed || tool.kind !== "select";
    if (root.hidden) return;
    space.textContent = own.dimension === 2 ? "Draw in space (3D)" : "Draw in the plane (2D)";
    const all = Object.keys(store.state.catalogue ?? {}).filter(
      (call) => entry(store, call).group === "block" && fits(store, call),
    );
    blocks.replaceChildren(
      ...all.map((call) => {
        const made = button("", () => start({ call }), { title: entry(store, call).doc ?? "" });
        made.append(icon(call, "block"), title(store, call));
        return made;
      }),
    );
  }
  store.on("tool", () => {
    if (store.state.tool.kind === "select") closed = false;
    update();
  });
  watch(store, ["document", "catalogue"], update);
  update();
}
