/** Targets: answers that shall have a value, and names that may change to give it. */
import { button, byId, choices, h, keep, say, set, watch } from "./dom.js";

import { isNumber } from "./model.js";
import { progress } from "./jobs.js";

export function target(store) {
  const root = byId("target");
  let wants = [];
  let number = 0;
  const unticked = new Set();
  const rows = h("div");
  const ticks = h("div", { class: "ticks", role: "group", "aria-label": "Names that may change" });
  const none = h(
    "p",
    { class: "note" },
    "Give a number a name first, in Names or in a field. A target changes only names.",
  );
  const fault = h("p", { class: "problem", role: "alert", hidden: true });
  const go = button("Find it", find, { class: "main", id: "find" });
  const add = button("+ Another", () => more());
  const running = h("div");
  root.append(
    h("h2", {}, "Targets"),
    rows,
    h("div", { class: "acts" }, add),
    h("h2", {}, "Names that may change"),
    ticks,
    none,
    h("div", { class: "acts" }, go),
    fault,
    running,
  );

  function more(answer = null) {
    number += 1;
    const offered = Object.entries(store.state.answers?.values ?? {});
    const [key, own] = offered.find(([one]) => one === answer) ?? offered[0] ?? ["frequency 1", {}];
    const value = Number.isFinite(own.value) ? String(Number(own.value.toPrecision(3))) : "";
    wants.push({ id: number, answer: key, kind: "equal", value });
    update();
  }

  function row(want) {
    const answer = h("select", { "aria-label": "Answer" });
    const kind = h(
      "select",
      { "aria-label": "Kind" },
      new Option("equal", "equal"),
      new Option("at least", "least"),
      new Option("at most", "most"),
    );
    const note = h("p", { class: "problem", hidden: true });
    const value = h("input", { type: "text", "aria-label": "Value", value: want.value, autocomplete: "off" });
    answer.addEventListener("change", () => ((want.answer = answer.value), update()));
    kind.addEventListener("change", () => (want.kind = kind.value));
    value.addEventListener("input", () => {
      want.value = value.value;
      const bad = !want.value.trim();
      say(note, bad ? "Give a number, such as 20, 300 MPa or 2*f." : "");
      note.hidden = !bad;
      set(value, "aria-invalid", bad ? "true" : null);
    });
    value.addEventListener("keydown", (event) => event.key === "Enter" && find());
    const drop = button("×", () => ((wants = wants.filter((one) => one !== want)), update()), {
      class: "plain",
      "aria-label": "Remove this target",
    });
    return h("div", { class: "want" }, answer, kind, value, drop, note);
  }

  function find() {
    fault.hidden = true;
    const free = Object.keys(freeNames()).filter((name) => !unticked.has(name));
    const own = wants.map(({ answer, kind, value }) => ({ answer, kind, value: value.trim() }));
    store.ask("target", { wants: own, free }).then(update, (problem) => {
      say(fault, problem.message);
      fault.hidden = false;
    });
  }

  const freeNames = () =>
    Object.fromEntries(Object.entries(store.state.document?.names ?? {}).filter(([, { value }]) => isNumber(value)));

  function update() {
    if (!wants.length && Object.keys(store.state.answers?.values ?? {}).length) return more();
    keep(
      rows,
      wants,
      ({ id }) => id,
      row,
      (element, want) => {
        const offered = Object.entries(store.state.answers?.values ?? {}).map(([key, { label, unit }]) => ({
          value: key,
          text: `${label ?? key}${unit ? ` [${unit}]` : ""}`,
        }));
        choices(element.querySelector("select"), offered, want.answer);
      },
    );
    const free = Object.keys(freeNames());
    none.hidden = free.length > 0;
    keep(
      ticks,
      free,
      (name) => name,
      (name) => {
        const tick = h("input", { type: "checkbox", checked: true });
        tick.addEventListener("change", () => (tick.checked ? unticked.delete(name) : unticked.add(name)));
        return h("label", { title: name }, tick, h("span", {}, name));
      },
    );
    go.disabled = !free.length || !wants.length;
    progress(
      store,
      running,
      Object.values(store.state.jobs)
        .filter(({ kind }) => kind === "target")
        .slice(-1),
    );
    return undefined;
  }
  watch(store, ["document", "answers", "jobs"], update, root);
  update();
}
