/** A pinned design beside the present one. */
import { byId, button, h, say, shown } from "./dom.js";
import { isStale } from "./answers.js";

export function compare(store) {
  const root = byId("compare");
  const pin = button("Pin this design", () => store.ask("pin").catch((fault) => say(text, fault.message)), { class: "main", id: "pin" });
  const unpin = button("Unpin", () => store.ask("unpin").catch((fault) => say(text, fault.message)));
  const text = h("p", { class: "soft" });
  const table = h("table", { "aria-label": "The pinned design and this one" });
  root.append(h("div", { class: "acts" }, pin, unpin), text, table);

  function update() {
    const { pinned, answers, values, document: doc } = store.state;
    const there = Boolean(pinned && (pinned.answers || pinned.names));
    unpin.hidden = !there;
    say(pin, there ? "Pin this one instead" : "Pin this design");
    say(text, there ? "" : "Pin a design, change it, and see here what became of its numbers and answers.");
    text.hidden = there;
    table.hidden = !there;
    root.classList.toggle("stale", isStale(store.state));
    if (!there) return;
    const number = (one) => (typeof one === "number" ? one : (one?.value ?? (one === undefined ? null : Number(one))));
    const lines = [];
    const names = { ...pinned.names };
    for (const name of Object.keys(doc?.names ?? {})) names[name] ??= null;
    for (const [name, old] of Object.entries(names)) lines.push([name, number(old ?? undefined), values?.[name] ?? null]);
    const answered = [];
    for (const [key, old] of Object.entries(pinned.answers ?? {})) {
      const now = answers?.values?.[key];
      answered.push([now?.label ?? old?.label ?? key, number(old), now?.value ?? null, now?.unit ?? old?.unit ?? ""]);
    }
    const others = (pinned.differences ?? []).map((one) => (typeof one === "string" ? one : (one.text ?? `${one.address ?? one.what ?? ""}: ${one.before ?? one.old ?? ""} → ${one.after ?? one.new ?? ""}`)));
    table.replaceChildren(
      h("thead", {}, h("tr", {}, ...["", "pinned", "now", "change"].map((one) => h("th", { scope: "col" }, one)))),
      h("tbody", {}, ...answered.map(line), ...lines.map(line)),
      h("tfoot", {}, ...others.map((one) => h("tr", {}, h("td", { colspan: 4 }, one)))),
    );
  }
  for (const part of ["pinned", "answers", "values", "document", "connected"]) store.on(part, update);
  update();
}

function line([label, old, now, unit = ""]) {
  const change = Number.isFinite(old) && Number.isFinite(now) && old !== 0 ? 100 * (now / old - 1) : null;
  const same = change !== null && Math.abs(change) < 1e-9;
  const text = change === null ? "–" : same ? "same" : `${change > 0 ? "+" : "−"}${Math.abs(change).toPrecision(3)} %`;
  return h(
    "tr",
    {},
    h("td", {}, unit ? `${label} [${unit}]` : label),
    h("td", { class: "number" }, shown(old, 5)),
    h("td", { class: "number" }, shown(now, 5)),
    h("td", { class: `number ${change === null || same ? "" : change > 0 ? "more" : "less"}` }, text),
  );
}
