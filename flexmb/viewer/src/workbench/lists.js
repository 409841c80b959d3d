/** Lists of what there is: everything, and sections with their materials. */
import { button, byId, h, say, watch } from "./dom.js";
import { icon } from "./icons.js";
import { fits, group, spoken, summary, thing, things, title } from "./model.js";
import { addSection } from "./sections.js";

const HEADS = {
  node: "Nodes",
  element: "Elements",
  block: "Building blocks",
  support: "Supports",
  mass: "Masses",
  load: "Loads",
  freedom: "Degrees of freedom",
  signal: "Inputs and outputs",
  section: "Sections",
  material: "Materials",
};

/** A list of things by group: arrows walk, Shift adds, Delete deletes, Enter goes to the properties. */
function thingList(store, label, groups, { remove, open }) {
  const root = h("div", { role: "listbox", tabindex: 0, "aria-label": label, "aria-multiselectable": "true" });
  let active = null;
  let rows = [];
  const made = new Map();

  function rowOf(own) {
    const row = h("div", { role: "option", id: `row-${label.split(" ")[0]}-${own.id}`, "data-id": own.id });
    row.append(icon(own.call, group(store, own.call)), h("span", { class: "what" }), h("span", { class: "soft" }));
    row.addEventListener("click", (event) => {
      active = own.id;
      store.select([own.id], { add: event.shiftKey || event.ctrlKey || event.metaKey });
    });
    row.addEventListener("dblclick", () => open("inspector"));
    return row;
  }

  function update(filter = "") {
    const wanted = filter.trim().toLowerCase();
    const children = [];
    rows = [];
    const faulty = new Set((store.state.problems ?? []).map(({ address }) => String(address).split("/")[0]));
    for (const kind of groups) {
      const own = things(store).filter(
        (one) =>
          group(store, one.call) === kind &&
          (!wanted || `${spoken(store, one)} ${one.call} ${summary(one)}`.toLowerCase().includes(wanted)),
      );
      if (!own.length) continue;
      children.push(h("div", { class: "list-group", role: "presentation" }, `${HEADS[kind]} (${own.length})`));
      for (const one of own) {
        const row = made.get(one.id) ?? rowOf(one);
        made.set(one.id, row);
        const [, what, rest] = row.children;
        say(what, spoken(store, one));
        say(
          rest,
          faulty.has(one.id)
            ? "⚠"
            : one.name
              ? `${one.call === "node" ? "" : title(store, one.call)} ${one.call === "node" ? summary(one) : ""}`
              : summary(one),
        );
        row.title = `${spoken(store, one)}: ${title(store, one.call)} ${summary(one)}`;
        rows.push(one.id);
        children.push(row);
      }
    }
    for (const id of made.keys()) if (!thing(store, id)) made.delete(id);
    const same =
      children.length === root.children.length &&
      children.every((child, i) =>
        child.role === "option" ? child === root.children[i] : child.textContent === root.children[i].textContent,
      );
    if (!same) root.replaceChildren(...children);
    select();
  }

  function select() {
    const { selection } = store.state;
    if (selection.length && !selection.includes(active)) active = selection.at(-1);
    for (const id of rows) {
      const row = made.get(id);
      row.setAttribute("aria-selected", String(selection.includes(id)));
      row.classList.toggle("active", id === active);
    }
    const row = made.get(active);
    if (row && rows.includes(active)) root.setAttribute("aria-activedescendant", row.id);
    else root.removeAttribute("aria-activedescendant");
  }

  root.addEventListener("keydown", (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (by) {
      event.preventDefault();
      const next = rows[Math.min(rows.length - 1, Math.max(0, rows.indexOf(active) + by))];
      if (next === undefined) return;
      active = next;
      made.get(active).scrollIntoView({ block: "nearest" });
      store.select([active], { add: event.shiftKey });
    } else if (event.key === "Delete" && store.state.selection.length) {
      event.preventDefault();
      remove(store.state.selection);
    } else if (event.key === "Enter") {
      // Or it would press the button that gets the focus.
      event.preventDefault();
      open("inspector");
      byId("inspector").querySelector("input, select")?.focus();
    } else if (event.key === "a" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      store.select(rows);
    }
  });
  store.on("selection", select);
  return { element: root, update };
}

/** Everything there is. */
export function everything(store, dialogs, { open }) {
  const root = byId("things");
  const search = h("input", {
    type: "search",
    class: "tool-search",
    placeholder: "Search parts",
    "aria-label": "Search parts",
  });
  const list = thingList(store, "Parts of the mechanism", Object.keys(HEADS), { remove: dialogs.remove, open });
  const none = h("p", { class: "soft" }, "Nothing yet. Add a node first.");
  root.append(search, list.element, none);
  const update = () => {
    list.update(search.value);
    none.hidden = things(store).length > 0;
  };
  search.addEventListener("input", update);
  watch(store, ["document", "catalogue", "problems"], update, root);
}

/** Sections and materials, with what can be added. */
export function sections(store, dialogs, { open }) {
  const root = byId("sections");
  const list = thingList(store, "Sections and materials", ["section", "material"], { remove: dialogs.remove, open });
  const adds = h("div", { class: "acts" });
  const none = h(
    "p",
    { class: "soft" },
    "A section is the shape and material of an element. The first element adds one, or add it here.",
  );
  root.append(adds, none, list.element);
  const chooser = (kind, text) => {
    const select = h("select", { "aria-label": text });
    select.addEventListener("change", () => {
      const call = select.value;
      select.value = "";
      if (call) addSection(store, call).then((id) => (store.select([id]), open("inspector")), dialogs.told);
    });
    adds.append(select);
    return () => {
      const own = Object.entries(store.state.catalogue ?? {}).filter(
        ([call, one]) => one.group === kind && fits(store, call),
      );
      select.replaceChildren(new Option(text, ""), ...own.map(([call, one]) => new Option(one.title ?? call, call)));
    };
  };
  const fillers = [chooser("section", "+ Section …"), chooser("material", "+ Material …")];
  const remove = button("Delete", () => dialogs.remove(store.state.selection), { class: "danger" });
  adds.append(remove);
  const update = () => {
    list.update();
    none.hidden = things(store).some(({ call }) => ["section", "material"].includes(group(store, call)));
  };
  const chosen = () => {
    remove.hidden = !store.state.selection.some((id) =>
      ["section", "material"].includes(group(store, thing(store, id)?.call ?? "")),
    );
  };
  store.on("catalogue", () => fillers.forEach((fill) => fill()));
  store.on("selection", chosen);
  watch(store, ["document", "catalogue", "problems"], update, root);
  chosen();
}
