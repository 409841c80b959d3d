/** Forms made from the catalogue: a field for every argument of a call. */
import { box, remark } from "./box.js";
import { button, choices, h, keep, newId, say, shown } from "./dom.js";
import { countOf, evaluate, isNumber, namesOf, problemAt, thing, unknown, words } from "./model.js";

const AXES = ["x", "y", "z"];
// Lists to choose from: what things of it make.
const FROM = { node: ["node"], section: ["section"], material: ["material"], damping: ["damping"], element: ["element"], of: ["node", "element"] };
// Fields that are seen at once, even where they may be left out.
const SEEN = new Set(["deformations", "components", "section", "material"]);

/**
 * A form for the fields of a call.
 *
 * @param store The store.
 * @param fields The catalogue's.
 * @param own Where the texts live: `get(name)`, `send(name, value)`, `address(name)` or null, `take(name, k)` for one
 *   entry of a list.
 */
export function form(store, fields, own) {
  const made = fields.map((field) => ({ field, ...entryOf(store, field, own) }));
  const isMain = ({ field }) => !field.optional || SEEN.has(field.kind) || filled(own.get(field.name));
  const main = made.filter(isMain);
  const others = made.filter((one) => !main.includes(one));
  const element = h("div", { class: "form" }, ...main.map((one) => one.element));
  if (others.length) {
    element.append(
      h("details", {}, h("summary", {}, `More (${others.length})`), h("div", { class: "form" }, ...others.map((one) => one.element))),
    );
  }
  return { element, update: () => made.forEach((one) => one.update()) };
}

const filled = (value) => value !== undefined && value !== null && String(value) !== "";

function entryOf(store, field, own) {
  const makers = { vector, nodes, flag, choice, components: chips, deformations: chips, sections: many, weights };
  const maker = makers[field.kind] ?? (FROM[field.kind] ? reference : scalar);
  return maker(store, field, own);
}

/** A label, what is beside it, and the place for what is wrong. */
function row(field, inputs, body, note = remark(...inputs)) {
  const text = words(field.name);
  const single = inputs.length === 1;
  const label = single ? h("label", {}, text) : h("span", { class: "label", id: newId() }, text);
  if (field.doc) label.title = field.doc;
  if (single) {
    inputs[0].id ||= newId();
    label.htmlFor = inputs[0].id;
  } else {
    body.setAttribute("role", "group");
    body.setAttribute("aria-labelledby", label.id);
  }
  return { element: h("div", { class: "field" }, label, body, note.element), note };
}

/** A number: its text, what it comes to, its unit. */
function numberBox(store, { get, send, problem, rest }) {
  const own = box(store, { get, send, problem, rest: { list: "known-names", inputmode: "text", ...rest }, changed: () => update() });
  const value = h("output", { class: "note number" });
  function update() {
    own.update();
    const text = own.text();
    const found = text.trim() && !isNumber(text) ? evaluate(store, text) : null;
    say(value, found === null ? "" : `= ${shown(found)}`);
    value.hidden = found === null;
  }
  return { ...own, value, update };
}

/** Buttons that make names of those that are not known yet. */
function makeNames(store, texts, guess) {
  const names = [...new Set(texts.flatMap((text) => unknown(store, text)))];
  return names.slice(0, 3).map((name) =>
    button(`Make “${name.length > 24 ? `${name.slice(0, 24)}…` : name}” a name`, () => {
      const value = String(guess() || 1);
      store.edit([{ op: "name", name, to: { value } }], { label: `Name ${name}` }).catch(() => {});
    }),
  );
}

function scalar(store, field, own) {
  const numeric = field.kind === "number";
  const rest = { placeholder: placeholder(field) };
  const send = (text, visit) => own.send(field.name, text, visit);
  const get = () => own.get(field.name) ?? "";
  const problem = () => own.problem(field.name);
  let good = Number(field.default) || null;
  const made = numeric ? numberBox(store, { get, send, problem, rest }) : box(store, { get, send, problem, rest, changed: () => update() });
  const unit = field.unit ? h("span", { class: "unit" }, field.unit) : null;
  const body = h("div", { class: "boxes" }, made.element, unit, numeric ? made.value : null);
  const { element, note } = row(field, [made.element], body);
  made.element.addEventListener("input", () => update());
  function update() {
    made.update();
    const fault = made.fault();
    if (numeric && !fault) good = evaluate(store, made.text()) ?? good;
    note.tell(fault, ...(numeric && fault ? makeNames(store, [made.text()], () => good) : []));
  }
  update();
  return { element, update };
}

function placeholder(field) {
  if (filled(field.default)) return String(field.default);
  return field.optional ? "–" : "";
}

/** Several numbers: as many as the field says, as the document has, or as there are axes. */
function vector(store, field, own) {
  const body = h("div", { class: "boxes" });
  const unit = field.unit ? h("span", { class: "unit" }, field.unit) : null;
  const note = remark();
  const { element } = row(field, [], body, note);
  let boxes = [];
  const texts = () => list(own.get(field.name));
  // Of any number there is room for one more.
  const size = () => countOf(store, field) ?? texts().length + 1;
  function build() {
    boxes = Array.from({ length: size() }, (_, k) => {
      const label = `${words(field.name)} ${AXES[k] && size() <= 3 ? AXES[k] : k + 1}`;
      return numberBox(store, {
        get: () => texts()[k] ?? "",
        send: (text, visit) => own.sendPart(field.name, k, text, whole(k, text), visit),
        problem: () => own.problem(field.name, k),
        rest: { "aria-label": label, placeholder: list(field.default)[k] ?? "" },
      });
    });
    body.replaceChildren(
      ...boxes.map((one, k) =>
        h("div", { class: "box" }, boxes.length <= 3 ? h("span", { "aria-hidden": "true" }, AXES[k]) : null, one.element),
      ),
      ...(unit ? [unit] : []),
      ...boxes.map((one) => one.value),
    );
    boxes.forEach((one) => one.element.addEventListener("input", () => update()));
  }
  /** The whole list after an entry has changed; none where all are empty. */
  function whole(k, text) {
    const all = Array.from({ length: size() }, (_, i) => (i === k ? text : (boxes[i]?.text() ?? "")));
    while (!countOf(store, field) && all.length && all.at(-1) === "") all.pop();
    return all.every((one) => one === "") ? "" : all;
  }
  function update() {
    if (boxes.length !== size()) build();
    boxes.forEach((one) => one.update());
    const bad = boxes.filter((one) => one.fault());
    const own_ = own.problem(field.name);
    const fault = bad[0]?.fault() ?? own_;
    note.tell(fault, ...(fault ? makeNames(store, boxes.map((one) => one.text()), () => null) : []));
    boxes.forEach((one) => mark(one.element, one.fault() || (!bad.length && own_), note));
  }
  update();
  return { element, update };
}

function mark(input, on, note) {
  if (on) {
    input.setAttribute("aria-invalid", "true");
    input.setAttribute("aria-describedby", note.element.id);
  } else {
    input.removeAttribute("aria-invalid");
    input.removeAttribute("aria-describedby");
  }
}

const list = (value) => (Array.isArray(value) ? value : filled(value) ? String(value).split(/[\s,]+/) : []);

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

function reference(store, field, own) {
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

function nodes(store, field, own) {
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
      (k) => h("div", { class: "box" }, h("select", { "aria-label": `${words(field.name)} ${k + 1}`, onchange: () => sent.send(read().filter(Boolean)) })),
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

function flag(store, field, own) {
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

function choice(store, field, own) {
  const select = h("select");
  const note = remark(select);
  const { element } = row(field, [select], h("div", { class: "boxes" }, select), note);
  const sent = sender(own, field, note);
  select.addEventListener("change", () => sent.send(select.value));
  function update() {
    const held = String(own.get(field.name) ?? "");
    const offered = (field.choices ?? []).map((one) => ({ value: String(one), text: String(one) }));
    if (field.optional || !held) offered.unshift({ value: "", text: filled(field.default) ? `${field.default} (as usual)` : "–" });
    choices(select, offered, held);
    note.tell(sent.fault());
  }
  update();
  return { element, update };
}

/** Some of a few: components of a node, deformations of an element; as buttons that stay down, and as a text. */
function chips(store, field, own) {
  const get = () => String(list(own.get(field.name)).join(" "));
  const own_ = box(store, { get, send: (text, visit) => own.send(field.name, text, visit), problem: () => own.problem(field.name), changed: () => update(),
    rest: { placeholder: filled(field.default) ? String(field.default) : field.kind === "components" ? "all" : "as usual" } });
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
    const then = now.includes(one) ? now.filter((other) => other !== one) : all.filter((other) => other === one || now.includes(other));
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
  const isElement = field.kind === "deformations" || (own.get("kind") !== "node" && of && namesOf(store, ["element"]).includes(of));
  if (isElement) return planar ? [1, 2, 3] : [1, 2, 3, 4, 5, 6];
  return planar ? ["x", "y", "phi"] : ["x", "y", "z", "rotation"];
}

/** Several names in a text: sections along a beam. */
function many(store, field, own) {
  const get = () => list(own.get(field.name)).join(", ");
  const send = (text) => own.send(field.name, text.split(",").map((one) => one.trim()).filter(Boolean));
  return textRow(store, field, own, { get, send, rest: { placeholder: "names, with commas between" }, lazy: true });
}

/** Parts with their factors: "A.x 0.5, B.x 0.5". */
function weights(store, field, own) {
  const get = () => (own.get(field.name) || []).map((pair) => [].concat(pair).join(" ")).join(", ");
  const pair = (text) => {
    const at = text.trim().lastIndexOf(" ");
    return at < 0 ? [text.trim(), "1"] : [text.trim().slice(0, at).trim(), text.trim().slice(at + 1)];
  };
  const send = (text) => own.send(field.name, text.split(",").filter((one) => one.trim()).map(pair));
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

/** Where the texts of a thing in the document live. */
export function ofThing(store, id, spokenAs) {
  const find = () => thing(store, id);
  const edit = (address, to, name, visit) =>
    store.edit([{ op: "set", address, to }], { label: `${words(name)} of ${spokenAs()}`, ...(visit ? { merge: `${address} ${visit}` } : {}) });
  return {
    get: (name) => find()?.args?.[name],
    send: (name, to, visit) => edit(`${id}/${name}`, to, name, visit),
    sendPart(name, k, text, whole, visit) {
      const held = find()?.args?.[name];
      const same = Array.isArray(held) && held.length === whole.length;
      return same && whole !== "" ? edit(`${id}/${name}/${k}`, text, name, visit) : edit(`${id}/${name}`, whole, name, visit);
    },
    problem: (name, k) => problemAt(store, k === undefined ? `${id}/${name}` : `${id}/${name}/${k}`),
  };
}

/** Where the texts of a tool, a dialog or an analysis live: an object that a function is told of. */
export function ofObject(args, changed = () => {}) {
  const send = (name, to) => {
    args[name] = to;
    return Promise.resolve(changed(args));
  };
  return { get: (name) => args[name], send, sendPart: (name, k, text, whole) => send(name, whole), problem: () => null };
}
