/** Elements of the page, made and kept. Texts enter as texts alone, never as HTML. */

export const byId = (id) => document.getElementById(id);

const PROPERTIES = new Set(["value", "textContent", "className"]);

/** An element with attributes, properties (true, false and what has no attribute) and listeners ("onclick"). */
export function h(tag, given = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(given)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (typeof value === "boolean" && key in element) element[key] = value;
    else if (PROPERTIES.has(key)) element[key] = value;
    else if (value !== null && value !== undefined) element.setAttribute(key, String(value));
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

export function button(text, action, given = {}) {
  return h("button", { type: "button", onclick: action, ...given }, text);
}

let count = 0;
export function newId() {
  count += 1;
  return `own-${count}`;
}

/** Let the children of a list be those of the items, each made once and then kept, so that none loses the focus. */
export function keep(parent, items, keyOf, make, update = () => {}) {
  const keys = items.map((item) => String(keyOf(item)));
  const wanted = new Set(keys);
  const there = new Map();
  for (const child of [...parent.children]) {
    if (wanted.has(child.dataset.key)) there.set(child.dataset.key, child);
    else child.remove();
  }
  let at = parent.firstElementChild;
  items.forEach((item, i) => {
    let child = there.get(keys[i]);
    if (!child) {
      child = make(item);
      child.dataset.key = keys[i];
    }
    if (child === at) at = at.nextElementSibling;
    else parent.insertBefore(child, at);
    update(child, item);
  });
}

/** Set a text only where it changes, so that a selection in it and what reads it out are left alone. */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function set(element, attribute, value) {
  if (value === null) element.removeAttribute(attribute);
  else if (element.getAttribute(attribute) !== String(value)) element.setAttribute(attribute, String(value));
}

/** A number with the digits that a reader needs. */
export function shown(value, digits = 5) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits)))
    .replace("e+", "e")
    .replace("-", "−");
}

/** Percent with as many digits as matter. */
export function signed(percent) {
  const size = Math.abs(percent);
  const text = size.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : 2);
  return Number(text) ? `${percent > 0 ? "+" : "−"}${text} %` : "≈ same";
}

/** A list of choices; what is chosen stays, even where it is no longer offered. */
export function choices(select, offered, chosen) {
  const all = offered.some(({ value }) => value === chosen)
    ? offered
    : [...offered, { value: chosen, text: chosen || "–" }];
  const same =
    select.options.length === all.length &&
    all.every(({ value, text }, i) => select.options[i].value === value && select.options[i].text === text);
  if (!same) select.replaceChildren(...all.map(({ value, text }) => new Option(text, value)));
  if (select.value !== chosen) select.value = chosen;
}

/**
 * Call a function once after any of some parts of the state changed; what a panel shows that is not seen waits until it is.
 */
export function watch(store, parts, update, panel = null) {
  let stale = false;
  store.on("*", (_, changed) => {
    if (!parts.some((part) => changed.has(part))) return;
    stale = Boolean(panel?.hidden);
    if (!stale) update();
  });
  panel?.addEventListener("opened", () => {
    if (!stale) return;
    stale = false;
    update();
  });
}

/** Tabs: one panel of a row is seen; arrows go from one to the next. */
export function tabs(row) {
  const all = [...row.querySelectorAll("[role=tab]")];
  const open = (tab, focus = false) => {
    for (const other of all) {
      const on = other === tab;
      other.setAttribute("aria-selected", String(on));
      other.tabIndex = on ? 0 : -1;
      byId(other.getAttribute("aria-controls")).hidden = !on;
    }
    if (focus) tab.focus();
    byId(tab.getAttribute("aria-controls")).dispatchEvent(new Event("opened"));
  };
  all.forEach((tab, i) => {
    tab.addEventListener("click", () => open(tab));
    tab.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      const to =
        event.key === "Home" ? 0 : event.key === "End" ? all.length - 1 : by && (i + by + all.length) % all.length;
      if (to === undefined) return;
      event.preventDefault();
      open(all[to], true);
    });
  });
  open(all[0]);
  return (id) => open(byId(`tab-${id}`));
}
