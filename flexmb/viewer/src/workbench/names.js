/** Names: numbers that fields share, each a slider, or arithmetic of others. */
import { box, remark } from "./box.js";
import { button, byId, h, keep, newId, say, set, shown, watch } from "./dom.js";
import { evaluate, isNumber, problemAt } from "./model.js";

const STEPS = 1000;

/** Bounds of a slider: those given, or around the value. */
export function bounds({ value, low, high }, evaluated) {
  const now = evaluated ?? Number(value) ?? 0;
  const span = Math.abs(now) || 1;
  const given = (text) =>
    text !== undefined && text !== null && String(text).trim() !== "" && Number.isFinite(Number(text))
      ? Number(text)
      : null;
  return [given(low) ?? (now > 0 ? span / 4 : now - 3 * span), given(high) ?? (now >= 0 ? span * 4 : now + 3 * span)];
}

/** Over decades a slider goes by ratios. */
const isWide = ([low, high]) => low > 0 && high / low > 10;

export function toValue(at, [low, high]) {
  return isWide([low, high]) ? low * (high / low) ** at : low + at * (high - low);
}

export function toPlace(value, [low, high]) {
  if (high <= low) return 0.5;
  return Math.min(
    1,
    Math.max(0, isWide([low, high]) ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low)),
  );
}

/** The text of a slider's number: no more digits than a step of it tells. */
export function written(value, [low, high]) {
  const digits = Math.max(3, Math.ceil(Math.log10(Math.abs(value) / ((high - low) / STEPS) || 1)) + 1);
  return String(Number(value.toPrecision(Math.min(digits, 6))));
}

export function names(store) {
  const root = byId("names");
  const rows = h("div");
  const none = h(
    "p",
    { class: "soft" },
    "A name is a number that several fields share. Write one into any field (t, 2*w), or add it here; each becomes a slider.",
  );
  root.append(none, rows, adding(store));
  const known = byId("known-names");
  const made = new Map();

  function update() {
    const own = store.state.document?.names ?? {};
    const all = Object.keys(own);
    none.hidden = all.length > 0;
    keep(
      rows,
      all,
      (name) => name,
      (name) => {
        const row = nameRow(store, name);
        made.set(name, row);
        return row.element;
      },
      (_, name) => made.get(name).update(),
    );
    for (const name of made.keys()) if (!Object.hasOwn(own, name)) made.delete(name);
    keep(
      known,
      all,
      (name) => name,
      (name) => h("option", { value: name }),
    );
  }
  watch(store, ["document", "values", "ways", "problems"], update);
  if (store.state.document) update();
}

function adding(store) {
  const name = h("input", {
    type: "text",
    "aria-label": "New name",
    placeholder: "name",
    autocomplete: "off",
    spellcheck: "false",
  });
  const value = h("input", {
    type: "text",
    "aria-label": "Value of the new name",
    placeholder: "value, arithmetic",
    autocomplete: "off",
    list: "known-names",
  });
  const note = remark(name, value);
  const element = h("form", { class: "add-row" }, name, value, h("button", { type: "submit" }, "Add"));
  element.addEventListener("submit", (event) => {
    event.preventDefault();
    const own = name.value.trim();
    if (Object.hasOwn(store.state.document.names, own)) {
      note.tell(`There is a name ${own} already.`);
      return;
    }
    store.edit([{ op: "name", name: own, to: { value: value.value.trim() || "1" } }], { label: `Name ${own}` }).then(
      () => {
        note.tell(null);
        name.value = value.value = "";
        name.focus();
      },
      (fault) => note.tell(fault.message),
    );
  });
  return h("div", {}, element, note.element);
}

function nameRow(store, name) {
  const get = () => store.state.document.names[name] ?? {};
  const change = (to, merge) =>
    store.edit([{ op: "name", name, to: { ...get(), ...to } }], { label: `${name}`, merge });
  const part = (key, rest) =>
    box(store, {
      get: () => get()[key] ?? "",
      send: (text, visit) => change({ [key]: text }, `names/${name}/${key} ${visit}`),
      problem: () =>
        problemAt(store, `names/${name}/${key}`) ?? (key === "value" ? problemAt(store, `names/${name}`) : null),
      rest,
      changed: () => update(),
    });
  const title = box(store, {
    lazy: true,
    get: () => name,
    send: (to) => store.edit([{ op: "rename", name, to }], { label: `Rename ${name}` }),
    rest: { class: "title", "aria-label": `Name ${name}`, title: name },
    changed: () => update(),
  });
  const value = part("value", { "aria-label": `Value of ${name}`, list: "known-names" });
  const low = part("low", { "aria-label": `Lower bound of ${name}`, placeholder: "low" });
  const high = part("high", { "aria-label": `Upper bound of ${name}`, placeholder: "high" });
  const slider = h("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": `${name}`, "data-name": name });
  const range = h("div", { class: "range" }, low.element, slider, high.element);
  const note = h("p", { class: "note number", hidden: true });
  const fault = remark(value.element);
  const drop = button(
    "×",
    () =>
      store
        .edit([{ op: "name", name, to: null }], { label: `Remove ${name}` })
        .catch((problem) => fault.tell(problem.message)),
    {
      class: "plain",
      "aria-label": `Remove the name ${name}`,
    },
  );
  const slope = h("div", { class: "slope", hidden: true }, h("i"));
  const element = h("div", { class: "name" }, title.element, value.element, drop, range, note, slope, fault.element);

  // While a slider is held its bounds stand still, and what it last said is what it shows.
  let held = null;
  let sent = null;
  let visit = newId();
  const limits = () => held ?? bounds(get(), store.state.values?.[name]);
  slider.addEventListener("focus", () => (visit = newId()));
  slider.addEventListener("pointerdown", () => {
    held = limits();
    visit = newId();
  });
  for (const end of ["pointerup", "pointercancel", "change"]) slider.addEventListener(end, () => (held = null));
  slider.addEventListener("input", () => {
    const within = limits();
    const text = written(toValue(slider.value / STEPS, within), within);
    const { low: least, high: most } = get();
    const to = { value: text, low: least || String(within[0]), high: most || String(within[1]) };
    sent = text;
    value.element.value = text;
    change(to, `names/${name}/value ${visit}`)
      .catch(() => {})
      .finally(() => {
        if (sent === text) sent = null;
        update();
      });
  });

  function update() {
    if (!Object.hasOwn(store.state.document.names, name)) return;
    for (const one of [title, low, high]) one.update();
    if (sent === null) value.update();
    const { value: text } = get();
    const free = isNumber(text);
    range.hidden = !free;
    if (free && sent === null && held === null) {
      const within = limits();
      const place = String(Math.round(STEPS * toPlace(Number(text), within)));
      if (slider.value !== place) slider.value = place;
      for (const [one, bound] of [
        [low, within[0]],
        [high, within[1]],
      ])
        one.element.placeholder = shown(bound, 3);
    }
    set(slider, "aria-valuetext", text);
    const found = free ? null : (store.state.values?.[name] ?? evaluate(store, text ?? ""));
    say(note, found === null ? "" : `= ${shown(found)}`);
    note.hidden = found === null;
    fault.tell([title, value, low, high].map((one) => one.fault()).find(Boolean) ?? null);
    showSlope();
  }

  /** How much the chosen answer goes along with this name, among all names. */
  function showSlope() {
    const own = store.state.ways;
    const share = own && relative(own, name);
    slope.hidden = !Number.isFinite(share);
    if (slope.hidden) return;
    const most = Math.max(
      ...Object.keys(store.state.document.names).map((other) => Math.abs(relative(own, other) || 0)),
      1e-300,
    );
    const bar = slope.firstChild;
    const width = (50 * Math.abs(share)) / most;
    bar.className = share < 0 ? "down" : "";
    bar.style.width = `${width}%`;
    bar.style.left = share < 0 ? `${50 - width}%` : "50%";
    slope.title = `${own.answer}: ${shown(share, 3)} % for 1 % of ${name}`;
  }
  update();
  return { element, update };
}

/** d ln answer / d ln name. */
export function relative(ways, name) {
  const own = ways.relative ?? {};
  return own.by_name?.[name] ?? own[`names/${name}/value`] ?? own[name] ?? NaN;
}
