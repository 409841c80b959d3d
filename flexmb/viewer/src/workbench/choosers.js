/** Fields in which something is chosen: names of things, words, coordinates and deformations. */
import { box, remark } from "./box.js";
import { button, choices, h, keep } from "./dom.js";
import { countOf, namesOf, words } from "./model.js";
import { filled, list, mark, row } from "./rows.js";

// Lists to choose from: what things of it make.
export const FROM = {
  node: ["node"],
  section: ["section"],
  material: ["material"],
  damping: ["damping"],
  element: ["element"],
  of: ["node", "element"],
};

/** Sends what is chosen, and keeps what is said against it. */
function sender(own, field, note) {
  let refused = null;
  return {
    fault: () => refused ?? own.problem(field.name),
    send(value) {
      refused = null;
      Promise.resolve(own.send(field.name, value)).catch((fault) => {
        refused = fault.message;
        note.tell(refused);
      });
    },
  };
}

export function reference(store, field, own) {
  const select = h("select");
  const note = remark(select);
  const { element } = row(field, [select], h("div", { class: "boxes" }, select), note);
  const sent = sender(own, field, note);
  select.addEventListener("change", () => sent.send(select.value));
  function update() {
    const offered = namesOf(store, FROM[field.kind]).map((name) => ({ value: name, text: name }));
    const held = String(own.get(field.name) ?? "");
    if (field.optional || !held) offered.unshift({ value: "", text: field.optional ? "–" : "choose …" });
    if (document.activeElement !== select || select.value !== held) choices(select, offered, held);
    note.tell(sent.fault());
  }
  update();
  return { element, update };
}

export function nodes(store, field, own) {
  const body = h("div", { class: "boxes" });
  const note = remark();
  const { element } = row(field, [], body, note);
  const sent = sender(own, field, note);
  const held = () => list(own.get(field.name));
  const read = () => [...body.querySelectorAll("select")].map((select) => select.value);
  function update() {
    const offered = namesOf(store, ["node"]).map((name) => ({ value: name, text: name }));
    const count = Math.max(countOf(store, field) ?? held().length + 1, held().length, 1);
    const all = Array.from({ length: count }, (_, k) => k);
    keep(
      body,
      all,
      (k) => k,
      (k) =>
        h(
          "div",
          { class: "box" },
          h("select", {
            "aria-label": `${words(field.name)} ${k + 1}`,
            onchange: () => sent.send(read().filter(Boolean)),
          }),
        ),
      (child, k) => {
        const now = held()[k] ?? "";
        choices(child.firstChild, now ? offered : [{ value: "", text: "choose …" }, ...offered], now);
      },
    );
    const fault = sent.fault();
    note.tell(fault);
    for (const select of body.querySelectorAll("select")) mark(select, fault, note);
  }
  update();
  return { element, update };
}

export function flag(store, field, own) {
  const tick = h("input", { type: "checkbox" });
  const note = remark(tick);
  const { element } = row(field, [tick], h("div", { class: "boxes" }, tick), note);
  const sent = sender(own, field, note);
  tick.addEventListener("change", () => sent.send(tick.checked ? "true" : "false"));
  function update() {
    const held = own.get(field.name);
    tick.checked = (filled(held) ? String(held) : String(field.default ?? "")).toLowerCase() === "true";
    note.tell(sent.fault());
  }
  update();
  return { element, update };
}

export function choice(store, field, own) {
  const select = h("select");
  const note = remark(select);
  const { element } = row(field, [select], h("div", { class: "boxes" }, select), note);
  const sent = sender(own, field, note);
  select.addEventListener("change", () => sent.send(select.value));
  function update() {
    const held = String(own.get(field.name) ?? "");
    const offered = (field.choices ?? []).map((one) => ({ value: String(one), text: String(one) }));
    if (field.optional || !held)
      offered.unshift({ value: "", text: filled(field.default) ? `${field.default} (default)` : "–" });
    choices(select, offered, held);
    note.tell(sent.fault());
  }
  update();
  return { element, update };
}

/** Some of a few: components of a node, deformations of an element; as buttons that stay down, and as a text. */
export function chips(store, field, own) {
  const get = () => String(list(own.get(field.name)).join(" "));
  const own_ = box(store, {
    get,
    send: (text, visit) => own.send(field.name, text, visit),
    problem: () => own.problem(field.name),
    changed: () => update(),
    rest: {
      placeholder:
        field.hint ??
        (filled(field.default) ? String(field.default) : field.kind === "components" ? "all" : "as usual"),
    },
  });
  const row_ = h("div", { class: "chips" });
  const { element, note } = row(field, [own_.element], h("div", { class: "boxes" }, own_.element));
  element.insertBefore(h("div", { class: "note" }, row_), note.element);
  const offered = () => (field.choices ?? parts(store, field, own)).map(String);
  const single = field.count === 1;
  function update() {
    own_.update();
    const on = list(own_.text());
    const all = on[0] === "all";
    keep(
      row_,
      offered(),
      (one) => one,
      (one) => button(one, () => flip(one), { "aria-label": `${words(field.name)}: ${one}` }),
      (child, one) => child.setAttribute("aria-pressed", String(on.includes(one) || all)),
    );
    note.tell(own_.fault());
  }
  function flip(one) {
    const all = offered();
    const text = single ? [] : list(own_.text());
    const now = text[0] === "all" ? all : text.filter((other) => all.includes(other));
    const then = now.includes(one)
      ? now.filter((other) => other !== one)
      : all.filter((other) => other === one || now.includes(other));
    // An empty text means what is usual, which is not: none.
    const none = field.kind === "deformations" ? "none" : "";
    own.send(field.name, then.join(" ") || none)?.catch?.(() => {});
  }
  update();
  return { element, update };
}

/** Numbers of deformations, or names of coordinates, of what the form is about. */
function parts(store, field, own) {
  const planar = store.state.document?.dimension === 2;
  const of = own.get("of") ?? own.get("element");
  const isElement =
    field.kind === "deformations" || (own.get("kind") !== "node" && of && namesOf(store, ["element"]).includes(of));
  if (isElement) return planar ? [1, 2, 3] : [1, 2, 3, 4, 5, 6];
  return planar ? ["x", "y", "phi"] : ["x", "y", "z", "rotation"];
}

/** Several names in a text: sections along a beam. */
export function many(store, field, own) {
  const get = () => list(own.get(field.name)).join(", ");
  const send = (text) =>
    own.send(
      field.name,
      text
        .split(",")
        .map((one) => one.trim())
        .filter(Boolean),
    );
  return textRow(store, field, own, { get, send, rest: { placeholder: "names, separated by commas" }, lazy: true });
}

/** Parts with their factors: "A.x 0.5, B.x 0.5". */
export function weights(store, field, own) {
  const get = () => (own.get(field.name) || []).map((pair) => [].concat(pair).join(" ")).join(", ");
  const pair = (text) => {
    const at = text.trim().lastIndexOf(" ");
    return at < 0 ? [text.trim(), "1"] : [text.trim().slice(0, at).trim(), text.trim().slice(at + 1)];
  };
  const send = (text) =>
    own.send(
      field.name,
      text
        .split(",")
        .filter((one) => one.trim())
        .map(pair),
    );
  return textRow(store, field, own, { get, send, rest: { placeholder: "A.x 0.5, B.x 0.5" }, lazy: true });
}

function textRow(store, field, own, given) {
  const made = box(store, { ...given, problem: () => own.problem(field.name), changed: () => update() });
  const { element, note } = row(field, [made.element], h("div", { class: "boxes" }, made.element));
  function update() {
    made.update();
    note.tell(made.fault());
  }
  update();
  return { element, update };
}
