/** A pinned design beside the present one. */
import { button, byId, h, say, shown, signed, watch } from "./dom.js";
import { isStale } from "./answers.js";

export function compare(store) {
  const root = byId("compare");
  const pin = button("Pin this design", () => store.ask("pin").catch((fault) => say(text, fault.message)), {
    class: "main",
    id: "pin",
  });
  const unpin = button("Unpin", () => store.ask("unpin").catch((fault) => say(text, fault.message)));
  const text = h("p", { class: "soft" });
  const table = h("table", { "aria-label": "The pinned design and this one" });
  root.append(h("div", { class: "acts" }, pin, unpin), text, table);

  function update() {
    const { pinned } = store.state;
    const there = Boolean(pinned?.differences);
    unpin.hidden = !there;
    say(pin, there ? "Pin this one instead" : "Pin this design");
    say(text, there ? "" : "Pin a design, then change it: this table shows the differences in numbers and answers.");
    text.hidden = there;
    table.hidden = !there;
    root.classList.toggle("stale", isStale(store.state));
    if (!there) return;
    const own = pinned.differences;
    const answered = (own.answers ?? []).map(
      ({ label, unit, before, now, before_text: old, now_text: text, percent }) => ({
        label,
        before: old ?? withUnit(before, unit),
        now: text ?? withUnit(now, unit),
        percent,
        same: before === now,
      }),
    );
    const changed = [...(own.names ?? []), ...(own.fields ?? [])].map((one) => ({ ...one, same: false }));
    const others = [
      ...(own.added ?? []).map((one) => `only in this one: ${one}`),
      ...(own.removed ?? []).map((one) => `only in the pinned one: ${one}`),
    ];
    table.replaceChildren(
      h("thead", {}, h("tr", {}, ...["", "pinned", "now", "change"].map((one) => h("th", { scope: "col" }, one)))),
      h("tbody", {}, ...answered.map(line)),
      h("tbody", {}, ...changed.map(line)),
      h("tfoot", {}, ...others.map((one) => h("tr", {}, h("td", { colspan: 4 }, one)))),
    );
  }
  watch(store, ["pinned", "answers", "document", "connected"], update, root);
  update();
}

const withUnit = (value, unit) =>
  value === null || value === undefined ? null : `${shown(value)} ${unit ?? ""}`.trim();

/** Without where it is: "3 MPa in 'left' at 1". */
const short = (text) => String(text ?? "–").replace(/ (of|in) '.*$/s, "");

function line({ label, before, now, percent, same }) {
  const none = percent === null || percent === undefined;
  const text = same || percent === 0 ? "same" : none ? "" : signed(percent);
  const way = none || signed(percent).startsWith("≈") ? "" : percent > 0 ? "more" : "less";
  return h(
    "tr",
    {},
    h("td", {}, label),
    h("td", { class: "number", title: before ?? "" }, short(before)),
    h("td", { class: "number", title: now ?? "" }, short(now)),
    h("td", { class: `number ${way}` }, text),
  );
}
