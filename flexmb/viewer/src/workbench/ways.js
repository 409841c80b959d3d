/** Which way to go: how much a chosen answer changes with every number and every name. */
import { byId, choices, h, keep, say, set, shown, watch } from "./dom.js";
import { spoken, thing, words } from "./model.js";

// Numbers that are shown at most.
const MOST = 60;

/** "5/position/0" in words. */
export function spokenAddress(store, address) {
  const [first, second, third] = address.split("/");
  if (first === "names") return second;
  const own = thing(store, first);
  if (!own) return address;
  const axis = third === undefined ? "" : ` ${["x", "y", "z"][third] ?? Number(third) + 1}`;
  return `${spoken(store, own)}: ${words(second)}${axis}`;
}

export function ways(store) {
  const root = byId("ways");
  const select = h("select", { id: "ways-of" });
  select.addEventListener("change", () => store.want({ sensitivity_of: select.value || null }).catch(() => {}));
  const kind = h(
    "select",
    { "aria-label": "Names or all numbers" },
    new Option("by name", "by_name"),
    new Option("by every number", "by_field"),
  );
  kind.addEventListener("change", update);
  const text = h("p", { class: "soft" });
  const rows = h("div");
  root.append(
    h("div", { class: "field" }, h("label", { for: "ways-of" }, "Answer"), h("div", { class: "boxes" }, select)),
    h("div", { class: "field" }, h("span", { class: "label" }, "Show"), h("div", { class: "boxes" }, kind)),
    text,
    rows,
  );
  root.querySelectorAll(".field").forEach((one) => (one.style.marginBottom = "6px"));

  function update() {
    const { answers, ways: own, want, document: doc } = store.state;
    const offered = [{ value: "", text: "choose an answer …" }];
    for (const [key, { label }] of Object.entries(answers?.values ?? {}))
      offered.push({ value: key, text: label ?? key });
    choices(select, offered, want.sensitivity_of ?? "");
    const ready = want.sensitivity_of && own && own.answer === want.sensitivity_of;
    if (ready && kind.value === "by_name" && !Object.keys(doc?.names ?? {}).length && !kind.dataset.asked)
      kind.value = "by_field";
    const slopes = ready ? (own[kind.value] ?? {}) : {};
    const shares = own?.relative?.[kind.value] ?? own?.relative ?? {};
    const all = Object.entries(slopes)
      .map(([key, slope]) => ({ key, slope, share: shares[key] ?? shares[`names/${key}/value`] ?? null }))
      .filter(({ slope }) => Number.isFinite(slope) && slope !== 0)
      .sort((a, b) => Math.abs(b.share ?? 0) - Math.abs(a.share ?? 0))
      .slice(0, MOST);
    say(text, told(want, ready, own, all));
    const most = Math.max(...all.map(({ share }) => Math.abs(share ?? 0)), 1e-300);
    keep(
      rows,
      all,
      ({ key }) => key,
      ({ key }) => wayRow(store, key),
      (row, one) => fill(row, one, most),
    );
  }

  function told(want, ready, own, all) {
    if (!want.sensitivity_of) return "Choose an answer to see its sensitivity to each number.";
    if (!ready || own.status === "computing") return "Computing …";
    if (own.message) return own.message;
    if (!all.length)
      return kind.value === "by_name" ? "It depends on no name. Look at every number, or add names." : "It depends on no number.";
    return [...(own.words ?? []), "Change of the answer if a number grows by 1 %."].join(" ");
  }

  function fill(row, { key, slope, share }, most) {
    const [label, bar, number] = row.children;
    const name = kind.value === "by_name" ? key : spokenAddress(store, key);
    say(label, name);
    label.title = name;
    const width = (50 * Math.abs(share ?? 0)) / most;
    const own = bar.firstChild;
    own.className = share < 0 ? "down" : "";
    own.style.width = `${width}%`;
    own.style.left = share < 0 ? `${50 - width}%` : "50%";
    set(number, "value", slope);
    say(number, share === null ? shown(slope, 3) : `${share > 0 ? "+" : ""}${shown(share, 3)} %`);
    number.title = `slope ${slope}`;
  }
  kind.addEventListener("change", () => (kind.dataset.asked = "yes"));
  watch(store, ["ways", "answers", "want", "document"], update, root);
  update();
}

function wayRow(store, key) {
  const row = h(
    "div",
    { class: "way", "data-way": key },
    h("span"),
    h("div", { class: "bar" }, h("i")),
    h("data", { class: "number" }),
  );
  row.addEventListener("click", () => {
    const id = key.split("/")[0];
    if (thing(store, id)) store.select([id]);
  });
  return row;
}
