/** The answers beside the drawing: degrees of freedom, advice, and numbers with the way they went over the last edits. */
import { button, byId, h, keep, say, set, shown, signed, watch } from "./dom.js";
import { toast } from "./dialogs.js";
import { redraw, sparkline } from "./icons.js";

// Edits over which a line is drawn.
const KEPT = 60;
// Coordinates that are told by name.
const MOST_LABELS = 6;

/** What the counts say, as a state to colour by and a sentence. */
export function mobility(count, problems = []) {
  if (problems.length) {
    const more = problems.length > 1 ? ` And ${problems.length - 1} more.` : "";
    return { state: "failed", text: `Left out until it is corrected: ${problems[0].message}${more}` };
  }
  if (!count) return { state: "waiting", text: "Counting …" };
  const { ndof, over, under, status, message } = count;
  const freedom = `${ndof ?? "–"} degree${ndof === 1 ? "" : "s"} of freedom`;
  const fault = over ? "over" : under ? "under" : null;
  if (fault)
    return { state: fault, text: message || `${freedom}, ${over ?? 0} over- and ${under ?? 0} under-constraints` };
  const states = { ok: ndof > 0 ? "good" : "waiting", counting: "waiting", empty: "waiting", loose: "under" };
  const state = states[status ?? "ok"] ?? "failed";
  return { state, text: message || freedom };
}

/** Whether what is shown belongs to an older document. */
export function isStale({ answers, revision, connected }) {
  if (!answers) return false;
  return !connected || answers.stale || answers.status === "failed" || (answers.of_revision ?? revision) < revision;
}

export function answers(store, { open }) {
  const root = byId("answers");
  const status = h("div", { class: "status", id: "mobility" }, h("p"), h("p", { class: "note" }));
  const advice = h("div", { class: "advice", role: "group", "aria-label": "Advice" });
  const stamp = h("span", { class: "stamp", role: "status", hidden: true });
  const head = h("div", { class: "head" }, h("h2", {}, "Answers"), stamp);
  const message = h("p", { class: "problem", hidden: true });
  const rows = h("div", { id: "answer-rows" });
  const none = h("p", { class: "soft" });
  const notes = h("details", { hidden: true }, h("summary"), h("div", { class: "notes" }));
  const support = supportChoice(store);
  root.append(status, advice, head, message, rows, none, support.element, notes);
  const history = new Map();
  let counted = 0;

  function counts() {
    const { count } = store.state;
    const { state, text } = mobility(count, store.state.problems);
    status.dataset.state = state;
    say(status.firstChild, text);
    const labels = (count?.dofs ?? []).map((one) =>
      typeof one === "string" ? one : (one.text ?? JSON.stringify(one)),
    );
    const more = labels.length > MOST_LABELS ? ` and ${labels.length - MOST_LABELS} more` : "";
    say(status.lastChild, labels.length ? `Coordinates: ${labels.slice(0, MOST_LABELS).join(", ")}${more}` : "");
    status.lastChild.title = labels.join(", ");
    status.lastChild.hidden = !status.lastChild.textContent;
    advice.replaceChildren(
      ...(count?.advice ?? []).map(({ text: words }, index) =>
        button(words, () => store.ask("advise", { index }).catch((fault) => toast(fault.message)), {
          "data-advice": index,
        }),
      ),
    );
    // What is said about the rest is no advice while a part of it is left out.
    advice.hidden = !advice.childElementCount || store.state.problems.length > 0;
    const dof = byId("dof");
    dof.dataset.state = state;
    const faults = [count?.over ? `${count.over} over` : "", count?.under ? `${count.under} under` : ""].filter(
      Boolean,
    );
    say(dof, [`DOF ${count?.ndof ?? "–"}`, ...faults].join(" · "));
    dof.title = text;
    set(dof, "aria-label", `${dof.textContent}. ${text}`);
  }

  function remember() {
    const { answers: own } = store.state;
    if (!own || own.status !== "ok" || own.stale || own.of_revision === counted) return;
    counted = own.of_revision;
    for (const [key, { value }] of Object.entries(own.values ?? {})) {
      if (!Number.isFinite(value)) continue;
      const line = history.get(key) ?? [];
      line.push(value);
      history.set(key, line.slice(-KEPT));
    }
  }

  function update() {
    remember();
    const { answers: own, count } = store.state;
    const stale = isStale(store.state);
    root.classList.toggle("stale", stale);
    rows.setAttribute("aria-busy", String(own?.status === "computing"));
    const computing = own?.status === "computing";
    say(stamp, computing ? "computing …" : "stale");
    stamp.hidden = !computing && !(stale && Object.keys(own.values ?? {}).length);
    stamp.title = stale ? "These answers belong to the previous drawing." : "";
    // What the count says already is not said twice.
    const told = own?.message || (own?.status === "failed" ? "No answer." : "");
    say(
      message,
      told === count?.message || store.state.problems.some((one) => told?.startsWith(one.message)) ? "" : told,
    );
    message.hidden = !message.textContent;
    const words = [...new Set([...(own?.words ?? []), ...(own?.warnings ?? []), ...(count?.warnings ?? [])])].filter(
      (one) => one !== told,
    );
    notes.hidden = !words.length;
    say(notes.firstChild, `Notes (${words.length})`);
    keep(
      notes.lastChild,
      words,
      (one) => one,
      (one) => h("p", { class: "note" }, one),
    );
    const all = Object.entries(own?.values ?? {});
    none.hidden = all.length > 0;
    say(
      none,
      store.state.document?.things.length
        ? "No answers yet: see above what is missing."
        : "Answers appear here as soon as there is a mechanism.",
    );
    keep(
      rows,
      all,
      ([key]) => key,
      ([key]) => answerRow(store, key, open),
      (row, [key, value]) => fill(row, key, value),
    );
  }

  function fill(row, key, { label, value, unit, text }) {
    const [what, line, number] = row.children;
    // Where it is found stands under what it is.
    const whole = text ?? `${shown(value)} ${unit ?? ""}`.trim();
    const [, short, place] = /^(.*?)((?: of| in) '.*)?$/s.exec(whole);
    say(what.firstChild, capital(label ?? key));
    say(what.lastChild, place ?? "");
    what.title = `${label ?? key}${place ?? ""}`;
    const last = history.get(key) ?? [];
    redraw(line, last);
    set(number, "value", value ?? "");
    say(number.firstChild, short);
    number.title = Number.isFinite(value) ? `${value} ${unit ?? ""}` : "";
    const pinned = store.state.pinned?.differences?.answers?.find((one) => one.key === key)?.before;
    const change = pinned && Number.isFinite(value) ? (value - pinned) / Math.abs(pinned) : null;
    say(number.lastChild, change === null ? "" : signed(100 * change));
    number.lastChild.title = "Compared with the pinned design";
  }

  watch(store, ["count", "problems"], counts);
  watch(store, ["answers", "count", "document", "connected", "pinned"], update);
  store.on("document", support.update);
  counts();
  update();
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function answerRow(store, key, open) {
  const number = h("data", { class: "number" }, h("span"), h("span", { class: "delta" }));
  const row = h(
    "button",
    { type: "button", class: "answer plain", "data-answer": key, title: "Show sensitivities" },
    h("span", { class: "what" }, h("span"), h("span", { class: "delta" })),
    sparkline([]),
    number,
  );
  row.addEventListener("click", () => {
    store.want({ sensitivity_of: key });
    open("ways");
  });
  return row;
}

/** The node whose support stiffness is told. */
function supportChoice(store) {
  const select = h("select", { id: "support-node" });
  select.addEventListener("change", () => store.want({ support_node: select.value || null }).catch(() => {}));
  const element = h(
    "div",
    { class: "field" },
    h("label", { for: "support-node" }, "Stiffness at"),
    h("div", { class: "boxes" }, select),
  );
  element.style.marginTop = "10px";
  function update() {
    const nodes = store.state.document.things.filter(({ call }) => call === "node").map(({ name }) => name);
    element.hidden = !nodes.length;
    const now = store.state.want.support_node ?? "";
    const wanted = ["", ...nodes];
    if ([...select.options].map((one) => one.value).join("\n") !== wanted.join("\n")) {
      select.replaceChildren(...wanted.map((name) => new Option(name || "no node", name)));
    }
    select.value = now;
  }
  return { element, update };
}
