/** What can be added: tools in groups, with a search; and the fields of the tool that is in hand. */
import { byId, button, h, keep, say } from "./dom.js";
import { form } from "./forms.js";
import { icon } from "./icons.js";
import { addSection } from "./sections.js";
import { entry, fieldsOf, fits, namesOf, title } from "./model.js";

const GROUPS = [
  ["element", "Elements"],
  ["node", "Rotations and warpings"],
  ["support", "Supports"],
  ["mass", "Masses"],
  ["load", "Loads"],
  ["freedom", "Degrees of freedom"],
  ["signal", "Inputs and outputs"],
  ["block", "Building blocks"],
];
const PLAIN = [
  { kind: "select", text: "Select and move", key: "S", icon: "select" },
  { kind: "node", text: "Node", key: "N", icon: "node" },
  { kind: "measure", text: "Measure", key: "M", icon: "measure" },
];
// Letters that the drawing takes for tools.
const LETTERS = {
  beam: "B",
  rigid_body: "R",
  truss: "T",
  leaf_spring: "P",
  fix: "H",
  force: "L",
  mass: "W",
  input: "I",
  output: "O",
  dof: "Q",
};
// What most mechanisms are made of stands first.
const FIRST = [
  "beam",
  "rigid_body",
  "rigid_beam",
  "truss",
  "leaf_spring",
  "hinge",
  "fix",
  "force",
  "moment",
  "gravity",
  "mass",
  "dof",
  "input",
  "output",
];

/** What the tool of a call is for a document: elements are drawn from node to node, all else is placed. */
function toolOf(store, call, args = {}) {
  const joins = entry(store, call)?.fields.some(({ kind }) => kind === "nodes");
  return joins ? { kind: "element", call, args } : { kind: "place", call, args };
}

function rank(call) {
  const at = FIRST.indexOf(call.split(".").at(-1));
  return at < 0 ? FIRST.length : at;
}

export function toolbox(store, { open }) {
  const root = byId("tools");
  const search = h("input", {
    type: "search",
    class: "tool-search",
    placeholder: "Search: beam, force, pivot …",
    "aria-label": "Search what can be added",
  });
  const plain = h("div", { role: "group", "aria-label": "Tools" });
  const groups = h("div", { class: "tools" });
  const none = h("p", { class: "soft", hidden: true }, "Nothing has this name.");
  root.append(search, plain, groups, none);
  search.addEventListener("input", list);
  search.addEventListener("keydown", (event) => {
    const first = groups.querySelector(".tool");
    if (event.key === "Enter" && first) first.click();
    if (event.key === "Escape" && search.value) {
      event.stopPropagation();
      search.value = "";
      list();
    }
  });

  plain.append(
    ...PLAIN.map((own) => {
      const made = button("", () => take({ kind: own.kind }), { class: "tool", "data-tool": own.kind });
      made.append(icon(own.icon), h("span", {}, own.text), h("kbd", { "aria-hidden": "true" }, own.key));
      return made;
    }),
  );

  async function take(tool) {
    if (tool.call) await takeTool(store, tool.call);
    else store.setTool(tool);
    if (tool.call) open("inspector");
    byId("scene").focus();
  }

  function matching() {
    const wanted = search.value.trim().toLowerCase();
    return Object.entries(store.state.catalogue ?? {})
      .filter(
        ([call, own]) =>
          call !== "node" &&
          fits(store, call) &&
          (!wanted ||
            `${call} ${own.title} ${own.group} ${own.doc ?? ""}`.toLowerCase().replaceAll("_", " ").includes(wanted)),
      )
      .map(([call, own]) => ({ call, ...own }));
  }

  function list() {
    const all = matching();
    const searched = Boolean(search.value.trim());
    const filled = GROUPS.map(([group, text]) => {
      const own = all.filter((one) => one.group === group).sort((a, b) => rank(a.call) - rank(b.call));
      return { group, text, own };
    }).filter(({ own }) => own.length);
    keep(
      groups,
      filled,
      ({ group }) => group,
      ({ group, text }) =>
        h(
          "details",
          { open: !["signal", "node"].includes(group), "data-group": group },
          h("summary", {}, text),
          h("div"),
        ),
      (details, { own }) => {
        if (searched) details.open = true;
        // Of two that are called the same, the element is the one that few ask for.
        for (const one of own)
          one.twin = one.call.includes(".") && own.some((other) => other !== one && other.title === one.title);
        keep(details.lastChild, searched ? own : own.filter(({ twin }) => !twin), ({ call }) => call, toolButton);
      },
    );
    none.hidden = filled.length > 0;
    press();
  }

  function toolButton({ call, group, doc, twin }) {
    const made = button("", () => take({ call }), { class: "tool", "data-call": call, title: doc ?? "" });
    const letter = twin ? null : LETTERS[call.split(".").at(-1)];
    made.append(icon(call, group), h("span", {}, `${title(store, call)}${twin ? " (element)" : ""}`));
    if (letter) made.append(h("kbd", { "aria-hidden": "true" }, letter));
    return made;
  }

  function press() {
    const { tool } = store.state;
    for (const one of root.querySelectorAll(".tool")) {
      const on = tool.call ? one.dataset.call === tool.call : one.dataset.tool === tool.kind;
      one.setAttribute("aria-pressed", String(on));
    }
  }

  store.on("catalogue", list);
  store.on("tool", press);
  let dimension = null;
  store.on("document", () => {
    if (store.state.document.dimension === dimension) return;
    dimension = store.state.document.dimension;
    list();
  });
  list();
}

/** What the last thing of the same call was given, without what is its own: the next one is mostly like it. */
function lastArgs(store, call) {
  const fields = fieldsOf(store, call);
  const last = store.state.document?.things.findLast((one) => one.call === call);
  const args = {};
  for (const { name, kind, optional, default: usual } of fields) {
    if (["node", "nodes", "of", "element"].includes(kind)) continue;
    if (last?.args?.[name] !== undefined) args[name] = last.args[name];
    else if (["section", "material"].includes(kind) && !optional) args[name] = namesOf(store, [kind]).at(-1) ?? "";
    else if (!optional && usual !== null && usual !== undefined)
      args[name] = Array.isArray(usual) ? usual.map(String) : String(usual);
  }
  return args;
}

/** Take the tool of a call in hand, with what the last thing of it was given. */
export async function takeTool(store, call) {
  store.setTool(await withSection(store, toolOf(store, call, lastArgs(store, call))));
}

/** A first section comes along with the first element that takes one. */
async function withSection(store, tool) {
  const field = fieldsOf(store, tool.call).find(({ kind }) => kind === "section");
  const needs = field && !tool.call.includes("rigid") && !tool.args[field.name];
  if (!needs) return tool;
  if (!namesOf(store, ["section"]).length) await addSection(store, "Rectangle", "leaf");
  return { ...tool, args: { ...tool.args, [field.name]: namesOf(store, ["section"]).at(-1) ?? "" } };
}

/** The fields of the tool in hand: what the next thing is given. */
export function toolForm(store) {
  const { tool } = store.state;
  const own = entry(store, tool.call);
  const placed = new Set(["node", "nodes", "of", "element"]);
  const fields = fieldsOf(store, tool.call).filter(({ kind }) => !placed.has(kind));
  const head = h(
    "div",
    { class: "head" },
    icon(tool.call, own?.group),
    h("h2", {}, `Next: ${title(store, tool.call)}`),
  );
  const done = button("Done", () => store.setTool({ kind: "select" }));
  head.append(h("span", { class: "spring" }), done);
  const doc = h("p", { class: "soft" });
  say(doc, own?.doc ?? "");
  const send = (name, to) => store.setTool({ ...store.state.tool, args: { ...store.state.tool.args, [name]: to } });
  // What placing.js gives where nothing is chosen is said before the click.
  const starts = ["dof", "input", "output", "prescribe"].includes(tool.call);
  const drawn = fields.map((field) => {
    if (own?.group === "block" && ["length", "along"].includes(field.name)) return { ...field, hint: "as drawn" };
    return starts && field.kind === "components" ? { ...field, hint: "x at a node, 1 of an element" } : field;
  });
  const made = form(store, drawn, {
    get: (name) => store.state.tool.args?.[name],
    send,
    sendPart: (name, k, text, whole) => send(name, whole),
    problem: () => null,
  });
  return { element: h("div", {}, head, doc, made.element), update: made.update };
}
