/** Properties of what is selected, of the tool in hand, or of the whole. */
import { box, remark } from "./box.js";
import { button, byId, h, keep, say, watch } from "./dom.js";
import { form, ofThing } from "./forms.js";
import { icon } from "./icons.js";
import { fieldsOf, group, problemAt, spoken, thing, things, title } from "./model.js";
import { takeTool, toolForm } from "./toolbox.js";

export function inspector(store, dialogs) {
  const root = byId("inspector");
  let key = null;
  let made = null;

  function wanted() {
    const { selection, tool, document: own } = store.state;
    if (!own) return "nothing";
    if (tool.call) return `tool ${tool.call}`;
    const there = selection.filter((id) => thing(store, id));
    if (there.length === 1) return `thing ${there[0]} ${thing(store, there[0]).call}`;
    return there.length ? "several" : "whole";
  }

  function update() {
    const now = store.state.catalogue ? wanted() : "nothing";
    if (now !== key) {
      key = now;
      const kind = now.split(" ")[0];
      const makers = {
        nothing: empty,
        tool: () => toolForm(store),
        thing: () => one(store, now.split(" ")[1], dialogs),
        several: () => several(store, dialogs),
        whole: () => whole(store),
      };
      made = makers[kind]();
      root.replaceChildren(made.element);
    } else made.update();
  }
  watch(store, ["document", "selection", "tool", "catalogue", "positions", "ways"], update);
  update();
}

function empty() {
  return { element: h("p", { class: "soft" }, "…"), update() {} };
}

/** A name that is changed everywhere at once. */
function nameRow(store, id) {
  const find = () => thing(store, id);
  const own = box(store, {
    lazy: true,
    get: () => find()?.name ?? "",
    send: (to) => store.edit([{ op: "rename", id, to }], { label: `Rename ${find()?.name ?? ""}` }),
    problem: () => problemAt(store, `${id}/name`),
    rest: { "aria-label": "Name" },
    changed: () => note.tell(own.fault()),
  });
  const note = remark(own.element);
  const element = h(
    "div",
    { class: "field" },
    h("span", { class: "label" }, "name"),
    h("div", { class: "boxes" }, own.element),
    note.element,
  );
  return { element, update: () => (own.update(), note.tell(own.fault())) };
}

function one(store, id, dialogs) {
  const own = thing(store, id);
  const { call } = own;
  const heading = h("h2");
  const kind = h("span", { class: "soft" }, own.name ? title(store, call) : "");
  const fault = h("p", { class: "problem", hidden: true });
  const parts = [];
  if (own.name !== undefined && own.name !== null) parts.push(nameRow(store, id));
  parts.push(
    form(
      store,
      fieldsOf(store, call),
      ofThing(store, id, () => spoken(store, thing(store, id) ?? own)),
    ),
  );
  const where = call === "node" ? attached(store, id) : null;
  const element = h(
    "div",
    {},
    h("div", { class: "head" }, icon(call, group(store, call)), heading, kind),
    acts(store, dialogs, [id]),
    fault,
    h("div", { class: "form" }, ...parts.map((part) => part.element)),
    where?.element ?? null,
  );
  function update() {
    const now = thing(store, id);
    if (!now) return;
    say(heading, spoken(store, now));
    heading.title = heading.textContent;
    const told = problemAt(store, id) ?? problemAt(store, null);
    say(fault, told ?? "");
    fault.hidden = !told;
    parts.forEach((part) => part.update());
    where?.update();
  }
  update();
  return { element, update };
}

/** What is attached to a node, to go there with a click. */
function attached(store, id) {
  const list = h("div", { class: "chips" });
  const element = h("div", {}, h("h2", { class: "soft" }, "Attached"), list);
  element.style.marginTop = "12px";
  function update() {
    const { name } = thing(store, id) ?? {};
    const found = things(store).filter(({ args }) =>
      Object.values(args ?? {}).some((value) => value === name || (Array.isArray(value) && value.includes(name))),
    );
    element.hidden = !found.length;
    const texts = found.map((other) => spoken(store, other));
    if ([...list.children].map((child) => child.textContent).join("\n") === texts.join("\n")) return;
    list.replaceChildren(...found.map((other, i) => button(texts[i], () => store.select([other.id]))));
  }
  update();
  return { element, update };
}

/** What can be done with the things that are selected. */
export function acts(store, dialogs, ids) {
  const chosen = ids.map((id) => thing(store, id)).filter(Boolean);
  const groups = new Set(chosen.map(({ call }) => group(store, call)));
  const drawn = chosen.some(({ call }) => ["node", "element", "block"].includes(group(store, call)));
  const single = chosen.length === 1 ? chosen[0] : null;
  const row = h("div", { class: "acts", role: "group", "aria-label": "What to do with the selection" });
  const act = (text, action, rest) => row.append(button(text, action, rest));
  if (drawn) {
    act("Copy …", () => dialogs.copy(ids));
    act("Mirror …", () => dialogs.mirror(ids));
    act("Repeat …", () => dialogs.repeat(ids));
  } else if (groups.has("section") || groups.has("material")) act("Copy", () => dialogs.duplicate(ids));
  if (single && groups.has("element")) act("Split …", () => dialogs.split(single));
  if (single && groups.has("node")) act("Join …", () => dialogs.join(single));
  if (single && groups.has("block")) act("Explode", () => dialogs.explode(single));
  act("Delete", () => dialogs.remove(ids), { class: "danger" });
  return row;
}

function several(store, dialogs) {
  const heading = h("h2");
  const box_ = h("div");
  let last = "";
  function update() {
    const ids = store.state.selection.filter((id) => thing(store, id));
    say(heading, `${ids.length} selected`);
    if (ids.join() === last) return;
    last = ids.join();
    const counts = new Map();
    for (const id of ids) {
      const name = title(store, thing(store, id).call);
      counts.set(name, (counts.get(name) ?? 0) + 1);
    }
    box_.replaceChildren(
      acts(store, dialogs, ids),
      h("p", { class: "soft" }, [...counts].map(([name, number]) => `${number} × ${name}`).join(", ")),
    );
  }
  update();
  return { element: h("div", {}, h("div", { class: "head" }, heading), box_), update };
}

/** What a beginner does next, each with the call of the tool for it. */
function nextSteps(store) {
  const all = things(store);
  const has = (...wanted) => all.some(({ call }) => wanted.includes(group(store, call)) || wanted.includes(call));
  const inPlane = store.state.document.dimension === 2 ? "planar" : "spatial";
  if (!all.length) return [];
  const steps = [];
  if (!has("element", "block")) steps.push(["Put elements between nodes", `${inPlane}.beam`]);
  if (!has("support")) steps.push(["Fix a node", "fix"]);
  if (!has("mass") && has("element", "block")) steps.push(["Add a mass", "mass"]);
  if (!has("load") && has("support")) steps.push(["A force shows displacement, stress and buckling", "force"]);
  return steps;
}

/** The whole, where nothing is selected: what there is, and what is wrong where. */
function whole(store) {
  const heading = h("h2", {}, "Mechanism");
  const text = h("p", { class: "soft" });
  const faults = h("div", { class: "advice" });
  const next = h("div", { class: "advice", role: "group", "aria-label": "Next steps" });
  let last = "";
  function update() {
    const all = things(store);
    const counted = (wanted, word) => {
      const number = all.filter(({ call }) => wanted.includes(group(store, call))).length;
      return `${number} ${word}${number === 1 ? "" : "s"}`;
    };
    const { dimension } = store.state.document;
    say(
      text,
      `${dimension === 2 ? "In the plane" : "In space"}: ${counted(["node"], "node")}, ${counted(["element"], "element")}, ${counted(["block"], "building block")}. Click something in the drawing to see and change its numbers.`,
    );
    keep(
      next,
      nextSteps(store),
      ([words]) => words,
      ([words, call]) => button(words, () => takeTool(store, call).then(() => byId("scene").focus())),
    );
    const now = JSON.stringify(store.state.problems ?? []);
    if (now === last) return;
    last = now;
    faults.replaceChildren(
      ...(store.state.problems ?? []).map(({ address, message }) => {
        const id = String(address ?? "").split("/")[0];
        return button(message, () => (thing(store, id) ? store.select([id]) : byId("tab-names").click()), {
          class: "danger",
        });
      }),
    );
  }
  update();
  return { element: h("div", {}, h("div", { class: "head" }, heading), text, faults, next), update };
}
