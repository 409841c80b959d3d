/** The workbench: a drawing with everything around it. */
import * as theme from "../theme.js";
import { analysis } from "./analysis.js";
import { answers } from "./answers.js";
import { banners } from "./banners.js";
import { begin, hint } from "./begin.js";
import { box } from "./box.js";
import { compare } from "./compare.js";
import { ask, dialogs as makeDialogs, plainly, toast } from "./dialogs.js";
import { Canvas } from "./canvas.js";
import { byId, set, tabs } from "./dom.js";
import { fit } from "./fit.js";
import { files as makeFiles } from "./files.js";
import { help } from "./help.js";
import { icon } from "./icons.js";
import { inspector } from "./inspector.js";
import { everything, sections } from "./lists.js";
import { names } from "./names.js";
import { toolbox } from "./toolbox.js";
import { show } from "./show.js";
import { split } from "./split.js";
import { Store } from "./store.js";
import { target } from "./target.js";
import { ways } from "./ways.js";

const store = new Store();
const canvas = drawing();
window.workbench = { store, canvas };

const opens = [...document.querySelectorAll("[role=tablist]")].map((row) => [row, tabs(row)]);
/** Show a panel. */
function open(id) {
  for (const [row, show_] of opens) if (row.querySelector(`#tab-${id}`)) show_(id);
}

const dialogs = makeDialogs(store);
const files = makeFiles(store, canvas);
split();
toolbox(store, { open });
inspector(store, dialogs);
names(store);
sections(store, dialogs, { open });
everything(store, dialogs, { open });
answers(store, { open });
ways(store);
target(store);
fit(store);
analysis(store, canvas);
compare(store);
banners(store);
hint(store);
begin(store, { files });
show(store, canvas);
history();
head();
keys();
requests();
selected();
notes();
store.connect();

/** The drawing, or nothing but a word where the browser has no WebGL. */
function drawing() {
  try {
    return new Canvas({ scene: byId("scene"), overlay: byId("overlay"), store });
  } catch (fault) {
    toast(`The mechanism cannot be drawn: ${fault.message}. It needs a browser with WebGL 2.`);
    return null;
  }
}

/** Undo and redo, by their labels. */
function history() {
  for (const [verb, key] of [
    ["undo", "Ctrl+Z"],
    ["redo", "Ctrl+Y"],
  ]) {
    const own = byId(verb);
    own.append(icon(verb));
    own.addEventListener("click", () => step(verb));
    const update = () => {
      const labels = store.state[verb] ?? [];
      const word = verb === "undo" ? "Undo" : "Redo";
      const text = labels.length ? `${word}: ${labels[0]}` : `Nothing to ${verb}`;
      own.disabled = !labels.length;
      own.title = `${text} (${key})`;
      set(own, "aria-label", text);
    };
    store.on(verb, update);
    update();
  }
}

function step(verb) {
  store.ask(verb).catch((fault) => toast(fault.message));
}

/** Title, theme, help, degrees of freedom. */
function head() {
  const own = byId("title");
  const made = box(store, {
    get: () => store.state.document?.title ?? "",
    send: (to, visit) => store.edit([{ op: "title", to }], { label: "Title", merge: `title ${visit}` }),
    rest: { id: "title", "aria-label": "Title", placeholder: "untitled" },
  });
  own.replaceWith(made.element);
  store.on("document", () => {
    made.update();
    made.element.title = made.element.value;
  });
  byId("theme").append(icon("theme"));
  const themed = () => {
    set(byId("theme"), "aria-pressed", theme.isDark());
    set(byId("theme"), "aria-label", theme.isDark() ? "Dark, click for light" : "Light, click for dark");
  };
  byId("theme").addEventListener("click", () => {
    theme.toggle();
    themed();
    canvas?.recolour?.();
  });
  themed();
  byId("help").append(icon("help"));
  byId("help").addEventListener("click", help);
  byId("dof").addEventListener("click", () => open("answers"));
}

/** What is to be said about how this began. */
function notes() {
  const off = store.on("notes", () => {
    const own = store.state.notes ?? [];
    off();
    if (own.length) ask("Opened, with notes", plainly(own), "", null);
  });
}

/** What is chosen in the drawing or among the parts shows its properties. */
function selected() {
  store.on("selection", () => {
    const elsewhere = byId("upper").contains(document.activeElement);
    if (store.state.selection.length && byId("inspector").hidden && !elsewhere) open("inspector");
  });
}

/** What the drawing asks for: a dialog, or the properties. */
function requests() {
  byId("stage").addEventListener("request", ({ detail: { what, ids } }) => {
    if (what === "keys") help();
    else if (what === "edit") {
      open("inspector");
      byId("inspector").querySelector("input, select, button")?.focus();
    } else if (ids.length && dialogs[what]) dialogs[what](ids);
    else toast("Select something first.");
  });
}

/** Keys that hold everywhere. */
function keys() {
  const parts = () => [byId("tools"), byId("scene"), byId("upper"), byId("lower")];
  document.addEventListener("keydown", (event) => {
    const { key, target: at } = event;
    const control = event.ctrlKey || event.metaKey;
    const typing = at.matches?.("input:not([type=range], [type=checkbox]), textarea, select");
    if (document.querySelector("dialog[open]")) return;
    const lower = key.toLowerCase();
    const actions = {
      z: () => step(event.shiftKey ? "redo" : "undo"),
      y: () => step("redo"),
      s: () => (event.shiftKey ? files.saveAs() : files.save()),
      o: () => files.open(),
    };
    if (control && !event.altKey && actions[lower]) {
      event.preventDefault();
      actions[lower]();
    } else if (key === "F1" || (key === "?" && !typing)) {
      event.preventDefault();
      help();
    } else if (key === "/" && !typing) {
      event.preventDefault();
      open("tools");
      byId("tools").querySelector("input").focus();
    } else if (key === "F6") {
      event.preventDefault();
      const all = parts();
      const now = all.findIndex((part) => part.contains(document.activeElement));
      const next = all[(now + (event.shiftKey ? -1 : 1) + all.length) % all.length];
      (next.matches("canvas") ? next : (next.querySelector("[aria-selected=true], input, button") ?? next)).focus();
    } else if (key === "Escape" && store.state.tool.kind !== "select" && at.id !== "scene" && !typing) {
      store.setTool({ kind: "select" });
    }
  });
}
