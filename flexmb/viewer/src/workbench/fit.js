/** Fit: names that may change so that the answers meet measurements in a CSV file. */
import { button, byId, h, keep, say, watch } from "./dom.js";
import { isNumber } from "./model.js";
import { progress } from "./jobs.js";
import { toast } from "./dialogs.js";

export function fit(store) {
  const root = byId("measured");
  const unticked = new Set();
  const file = h("input", { type: "file", accept: ".csv,.txt", "aria-label": "Measurements (CSV)", id: "fit-file" });
  const ticks = h("div", { class: "ticks", role: "group", "aria-label": "Names that may change to fit" });
  const fault = h("p", { class: "problem", role: "alert", hidden: true });
  const go = button("Fit", run, { class: "main", id: "fit-run" });
  const take = button("Take the fitted values", taken, { id: "fit-take" });
  const running = h("div");
  root.append(
    h("h2", {}, "Measurements"),
    file,
    h(
      "p",
      { class: "note" },
      "A CSV file. Each line has an answer, its value and its standard deviation, under the head " +
        "“answer,value,deviation”: frequency 1, 10.9, 0.05. Or a frequency response under the head " +
        "“hertz,real,imaginary,deviation”. All in SI units.",
    ),
    h("h2", {}, "What may change"),
    ticks,
    h("div", { class: "acts" }, go, take),
    fault,
    running,
  );
  file.addEventListener("change", update);

  const free = () =>
    Object.entries(store.state.document?.names ?? {})
      .filter(([, { value }]) => isNumber(value))
      .map(([name]) => name);
  const last = () =>
    Object.values(store.state.jobs)
      .filter(({ kind }) => kind === "fit")
      .at(-1);

  async function run() {
    fault.hidden = true;
    try {
      const [own] = file.files;
      const names = free().filter((name) => !unticked.has(name));
      await store.ask("fit", { text: await own.text(), name: own.name, free: names });
    } catch (problem) {
      say(fault, problem.message);
      fault.hidden = false;
    }
  }

  function taken() {
    const { ops, title } = last();
    store.edit(ops, { label: title }).catch((problem) => toast(problem.message));
  }

  function update() {
    keep(
      ticks,
      free(),
      (name) => name,
      (name) => {
        const tick = h("input", { type: "checkbox", checked: true });
        tick.addEventListener("change", () => {
          if (tick.checked) unticked.delete(name);
          else unticked.add(name);
          update();
        });
        return h("label", { title: name }, tick, h("span", {}, name));
      },
    );
    go.disabled = !file.files.length || free().every((name) => unticked.has(name));
    const own = last();
    take.hidden = !own?.ops?.length;
    progress(store, running, own ? [own] : []);
  }
  watch(store, ["document", "jobs"], update, root);
  update();
}
