/** Long work: how far it is, a button to stop it, and what it found. */
import { button, h, keep, say, set, shown } from "./dom.js";
import { ask } from "./dialogs.js";

/** Cards of jobs, the newest as given. */
export function progress(store, parent, jobs, play = null) {
  keep(
    parent,
    jobs,
    ({ job }) => job,
    (own) => card(store, own, play),
    fill,
  );
}

function card(store, { job, kind }, play) {
  const stop = button("Stop", () => store.ask("stop", { job }).catch(() => {}));
  const shows = button("Play in the drawing", () => play?.(store.state.jobs[job]));
  shows.hidden = true;
  stop.dataset.act = "stop";
  shows.dataset.act = "play";
  const bar = h("progress", { max: 1, "aria-label": `Progress of ${kind}` });
  const image = h("img", { alt: `Plot of ${kind}`, hidden: true, tabindex: 0 });
  const larger = () => {
    const content = h("img", { src: image.src, alt: image.alt });
    const own = ask(image.alt.replace("Plot: ", ""), content, "", null, { wide: true });
    own
      .querySelector(".buttons")
      .prepend(
        button("Save the picture", () =>
          h("a", { href: image.src, download: `${kind}.${image.dataset.ending}` }).click(),
        ),
      );
  };
  image.addEventListener("click", larger);
  image.addEventListener("keydown", (event) => event.key === "Enter" && larger());
  return h(
    "section",
    { class: "job", "aria-label": kind, "data-job": job },
    h("div", { class: "head" }, h("h2"), h("span", { class: "soft" }), shows, stop),
    bar,
    image,
    h("pre"),
    h("div", { class: "rows" }),
  );
}

const STATES = { running: "running …", done: "done", failed: "failed", stopped: "stopped" };

function fill(own, { kind, title, status, fraction, text, design, picture, view, rows }) {
  const [head, bar, image, told, table] = own.children;
  const [name, state, shows, stop] = head.children;
  say(name, title ?? ({ target: "Target", fit: "Fit" }[kind] ?? kind));
  image.alt = `Plot: ${name.textContent}`;
  say(state, STATES[status] ?? status);
  own.dataset.status = status;
  stop.hidden = status !== "running";
  shows.hidden = !view || status === "running";
  bar.hidden = status !== "running";
  if (fraction === undefined || fraction === null) bar.removeAttribute("value");
  else bar.value = fraction;
  const designed = Object.entries(design ?? {}).map(
    ([key, value]) => `${key} = ${typeof value === "number" ? shown(value) : value}`,
  );
  say(told, [text, ...designed].filter(Boolean).join("\n"));
  told.className = status === "failed" ? "problem" : "";
  told.hidden = !told.textContent;
  if (rows && table.dataset.count !== String(rows.length)) {
    table.dataset.count = String(rows.length);
    table.replaceChildren(rowTable(rows));
  }
  if (picture) {
    const address = addressOf(picture);
    if (image.src !== address) image.src = address;
    image.dataset.ending = address.startsWith("data:image/svg") ? "svg" : "png";
  }
  image.hidden = !picture;
  set(own, "aria-busy", status === "running");
}

/** A picture as the server gives it: an address, the text of an SVG, or a PNG in base64. */
function addressOf(picture) {
  if (picture.startsWith("data:")) return picture;
  if (picture.trimStart().startsWith("<")) return `data:image/svg+xml;charset=utf-8,${encodeURIComponent(picture)}`;
  return `data:image/png;base64,${picture}`;
}

function rowTable(rows) {
  const cell = (value) => (typeof value === "number" ? shown(value) : String(value ?? "–"));
  const named = !Array.isArray(rows[0]) && typeof rows[0] === "object";
  const columns = named ? Object.keys(rows[0]) : [];
  return h(
    "table",
    {},
    ...(named ? [h("thead", {}, h("tr", {}, ...columns.map((one) => h("th", { scope: "col" }, one))))] : []),
    h(
      "tbody",
      {},
      ...rows
        .slice(0, 200)
        .map((one) =>
          h(
            "tr",
            {},
            ...(named ? columns.map((key) => one[key]) : [].concat(one)).map((value) =>
              h("td", { class: "number" }, cell(value)),
            ),
          ),
        ),
    ),
  );
}
