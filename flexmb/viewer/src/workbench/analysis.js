/** All analyses at a click, with their options, pictures, progress and stop. */
import { button, byId, choices, h, say, watch } from "./dom.js";
import { form, ofObject } from "./forms.js";
import { progress } from "./jobs.js";
import { toast } from "./dialogs.js";

export function analysis(store, canvas) {
  const root = byId("analysis");
  const select = h("select", { id: "analysis-kind", "aria-label": "Analysis" });
  const doc = h("p", { class: "soft" });
  const lacks = h("p", { class: "note", id: "analysis-lacks" });
  const place = h("div");
  const go = button("Run", run, { class: "main", id: "run" });
  const jobs = h("div");
  const given = {};
  let made = null;
  let last = null;
  root.append(
    h(
      "div",
      { class: "field" },
      h("label", { for: "analysis-kind" }, "Analysis"),
      h("div", { class: "boxes" }, select),
    ),
    doc,
    place,
    lacks,
    h("div", { class: "acts" }, go),
    jobs,
  );
  place.style.margin = "6px 0 8px";
  select.addEventListener("change", update);

  const all = () => store.state.analyses ?? {};

  function run() {
    const own = select.value;
    const options = Object.fromEntries(
      Object.entries(given[own] ?? {}).filter(([, value]) => value !== "" && value !== null),
    );
    store.ask("run", { analysis: own, options }).catch((fault) => toast(fault.message));
  }

  function update() {
    const offered = Object.entries(all()).map(([key, { title }]) => ({ value: key, text: title ?? key }));
    if (offered.length) choices(select, offered, all()[select.value] ? select.value : offered[0].value);
    const own = all()[select.value];
    say(doc, own?.doc ?? "");
    go.disabled = !own || Boolean(own.missing);
    say(lacks, own?.missing ?? "");
    lacks.hidden = !own?.missing;
    const now = JSON.stringify([select.value, own?.fields]);
    if (own && last !== now) {
      last = now;
      given[select.value] ??= {};
      made = form(
        store,
        own.fields ?? [],
        ofObject(given[select.value], () => made.update()),
      );
      place.replaceChildren(made.element);
    }
    made?.update();
    const runs = Object.values(store.state.jobs)
      .filter(({ kind }) => kind !== "target" && kind !== "fit")
      .reverse();
    progress(store, jobs, runs, (job) => canvas?.playView?.(job.view));
  }
  watch(store, ["analyses", "jobs", "document"], update, root);
  update();
}
