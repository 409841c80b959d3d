/** Forms made from the catalogue: a field for every argument of a call. */
import { box, remark } from "./box.js";
import { chips, choice, flag, FROM, many, nodes, reference, weights } from "./choosers.js";
import { button, h, say, shown } from "./dom.js";
import { countOf, evaluate, isNumber, problemAt, thing, unitAdvice, unknown, words } from "./model.js";
import { filled, list, mark, row } from "./rows.js";

const AXES = ["x", "y", "z"];
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
      h(
        "details",
        {},
        h("summary", {}, `More (${others.length})`),
        h("div", { class: "form" }, ...others.map((one) => one.element)),
      ),
    );
  }
  return { element, update: () => made.forEach((one) => one.update()) };
}

function entryOf(store, field, own) {
  const makers = { vector, nodes, flag, choice, components: chips, deformations: chips, sections: many, weights };
  const maker = makers[field.kind] ?? (FROM[field.kind] ? reference : scalar);
  return maker(store, field, own);
}

/** A number: its text, what it comes to, its unit. */
function numberBox(store, { get, send, problem, rest }) {
  const own = box(store, {
    get,
    send,
    problem,
    rest: { list: "known-names", inputmode: "text", ...rest },
    changed: () => update(),
  });
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
  const names = [...new Set(texts.flatMap((text) => (unitAdvice(text) ? [] : unknown(store, text))))];
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
  const made = numeric
    ? numberBox(store, { get, send, problem, rest })
    : box(store, { get, send, problem, rest, changed: () => update() });
  const unit = field.unit ? h("span", { class: "unit" }, field.unit) : null;
  const body = h("div", { class: "boxes" }, made.element, numeric ? made.value : null, unit);
  const { element, note } = row(field, [made.element], body);
  made.element.addEventListener("input", () => update());
  function update() {
    made.update();
    const fault = made.fault();
    if (numeric && !fault) good = evaluate(store, made.text()) ?? good;
    const advice = numeric && fault ? unitAdvice(made.text()) : null;
    note.tell(advice ?? fault, ...(numeric && fault ? makeNames(store, [made.text()], () => good) : []));
  }
  update();
  return { element, update };
}

function placeholder(field) {
  if (field.hint) return field.hint;
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
        rest: { "aria-label": label, placeholder: list(field.default)[k] ?? field.hint ?? "" },
      });
    });
    body.replaceChildren(
      ...boxes.map((one, k) =>
        h(
          "div",
          { class: "box" },
          boxes.length <= 3 ? h("span", { "aria-hidden": "true" }, AXES[k]) : null,
          one.element,
        ),
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
    note.tell(
      (bad[0] && unitAdvice(bad[0].text())) ?? fault,
      ...(fault
        ? makeNames(
            store,
            boxes.map((one) => one.text()),
            () => null,
          )
        : []),
    );
    boxes.forEach((one) => mark(one.element, one.fault() || (!bad.length && own_), note));
  }
  update();
  return { element, update };
}

/** Where the texts of a thing in the document live. */
export function ofThing(store, id, spokenAs) {
  const find = () => thing(store, id);
  const edit = (address, to, name, visit) =>
    store.edit([{ op: "set", address, to }], {
      label: `${words(name)} of ${spokenAs()}`,
      ...(visit ? { merge: `${address} ${visit}` } : {}),
    });
  return {
    get: (name) => find()?.args?.[name],
    send: (name, to, visit) => edit(`${id}/${name}`, to, name, visit),
    sendPart(name, k, text, whole, visit) {
      const held = find()?.args?.[name];
      const same = Array.isArray(held) && held.length === whole.length;
      return same && whole !== ""
        ? edit(`${id}/${name}/${k}`, text, name, visit)
        : edit(`${id}/${name}`, whole, name, visit);
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
  return {
    get: (name) => args[name],
    send,
    sendPart: (name, k, text, whole) => send(name, whole),
    problem: () => null,
  };
}
