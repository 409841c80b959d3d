/** Files: new, open, save, export; what comes back from the server is handed to the browser. */
import { button, byId, h, say, set, watch } from "./dom.js";
import { ask, plainly, toast } from "./dialogs.js";

const EXPORTS = [
  ["py", "Python script (.py)"],
  ["dat", "SPACAR input (.dat)"],
  ["json", "Workbench document (.json)"],
  ["html", "One page to send (.html)"],
  ["png", "Picture (.png)"],
  ["step", "CAD solids (.step)"],
  ["dxf", "CAD drawing (.dxf)"],
];
const SHAPED = new Set(["step", "dxf"]);

/** Leave a text or bytes in base64 as a file of the reader's. */
export function leave({ name, text, base64 }) {
  const content = base64 === undefined ? text : Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const link = h("a", { href: URL.createObjectURL(new Blob([content])), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export function files(store, canvas) {
  const told = (fault) => toast(fault.message);
  const menu = byId("file-menu");
  const list = (reply) => [].concat(reply?.left_out ?? reply?.cannot_hold ?? reply?.cannot ?? []);

  async function fetched(kind, more = {}) {
    const reply = await store.ask("export", { kind, ...more });
    if (reply.name) leave(reply);
    const lost = [...list(reply), ...[].concat(reply.notes ?? [])];
    if (lost.length) ask(`${reply.name}: not contained`, plainly(lost), "", null);
    else if (reply.name) toast(`${reply.name} is among your downloads.`);
  }

  function exported(kind) {
    menu.hidePopover();
    if (kind === "png") return picture();
    if (!SHAPED.has(kind)) return fetched(kind).catch(told);
    const tick = h("input", { type: "checkbox" });
    const content = h("label", {}, tick, " deformed by its loads");
    return ask(`Export ${kind.toUpperCase()}`, content, "Export", () => fetched(kind, { deformed: tick.checked }));
  }

  function picture() {
    const made = canvas?.picture?.();
    if (!made) return toast("There is no picture yet.");
    return made.toBlob((blob) => {
      const link = h("a", {
        href: URL.createObjectURL(blob),
        download: `${store.state.document.title || "mechanism"}.png`,
      });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  /** Save, after what the file cannot hold was read and agreed to. */
  async function save(path, more = {}) {
    const reply = await store.ask("save", { ...(path ? { path } : {}), ...more });
    const lost = list(reply);
    if (lost.length && reply.saved === false) {
      const content = h(
        "div",
        {},
        h("p", {}, "This kind of file cannot contain everything. These would be left out:"),
        plainly(lost),
        h("p", {}, "A Python script contains everything."),
      );
      const own = ask("Not contained in a .dat file", content, "Save without them", () =>
        save(path, { ...more, anyway: true }),
      );
      own.querySelector(".buttons").prepend(
        button("Save Python instead", () => {
          own.close();
          const name = (path ?? store.state.file ?? "mechanism.dat").replace(/\.\w+$/, "") + ".py";
          save(name).catch(told);
        }),
      );
      return;
    }
    if (reply.over && reply.saved === false) {
      ask(
        `${reply.over} is there already`,
        h("p", {}, "Overwrite it?"),
        "Write over it",
        () => save(path, { ...more, over: true }),
        { danger: true },
      );
      return;
    }
    toast(`Saved as ${reply.file ?? path ?? store.state.file}.`);
  }

  function saveAs() {
    if (menu.matches(":popover-open")) menu.hidePopover();
    const name = h("input", {
      type: "text",
      value: store.state.file ?? `${store.state.document.title || "mechanism"}.dat`,
      "aria-label": "File",
      autocomplete: "off",
    });
    const content = h(
      "div",
      { class: "form" },
      name,
      h(
        "p",
        { class: "note" },
        "The ending sets the kind of file: .dat, .py or .json. A name without a folder goes to the folder where the workbench was started.",
      ),
    );
    name.style.width = "100%";
    ask("Save as", content, "Save", () => save(name.value.trim()));
  }

  function open() {
    const path = h("input", {
      type: "text",
      "aria-label": "Path of the file",
      placeholder: "guide.dat",
      autocomplete: "off",
    });
    const upload = h("input", {
      type: "file",
      accept: ".dat,.json,.toml,.txt",
      "aria-label": "A file of this computer",
    });
    path.style.width = upload.style.width = "100%";
    const content = h(
      "div",
      { class: "form" },
      h("p", { class: "note" }, "Path of a file where the workbench runs:"),
      path,
      h("p", { class: "note" }, "Or a file that this browser sends:"),
      upload,
      store.state.saved
        ? null
        : h("p", { class: "problem" }, "The open mechanism is not saved. Undo restores it after opening."),
    );
    ask("Open a mechanism", content, "Open", async () => {
      const [file] = upload.files;
      if (!file && !path.value.trim()) throw new Error("Write a path or choose a file.");
      const reply = await store.ask(
        "open",
        file ? { text: await file.text(), name: file.name } : { path: path.value.trim() },
      );
      const notes = [].concat(reply.notes ?? [], reply.left_out ?? []);
      if (notes.length) ask("Opened, with notes", plainly(notes), "", null);
    });
  }

  /** Begin anew; what was there comes back by undo. */
  async function begin(dimension) {
    byId("new-menu").hidePopover();
    const { document: own } = store.state;
    const ops = own.things.length ? [{ op: "delete", ids: own.things.map(({ id }) => id) }] : [];
    for (const name of Object.keys(own.names)) ops.push({ op: "name", name, to: null });
    if (own.dimension !== dimension) ops.push({ op: "dimension", to: dimension });
    if (ops.length)
      await store.edit(ops, { label: dimension === 2 ? "New planar mechanism" : "New spatial mechanism" });
    byId("scene").focus();
  }

  menu.append(
    button("Save as …", saveAs, { role: "menuitem", id: "save-as" }),
    h("hr"),
    ...EXPORTS.map(([kind, text]) => button(text, () => exported(kind), { role: "menuitem", "data-export": kind })),
  );
  const saveNow = () => (store.state.file ? save().catch(told) : saveAs());
  byId("open").addEventListener("click", open);
  byId("save").addEventListener("click", saveNow);
  byId("new-2").addEventListener("click", () => begin(2).catch(told));
  byId("new-3").addEventListener("click", () => begin(3).catch(told));
  for (const [own, by] of [
    ["new-menu", "new"],
    ["file-menu", "file-more"],
  ])
    popover(byId(own), byId(by));

  function update() {
    const { file, saved, document: own } = store.state;
    const name = file ? file.split(/[/\\]/).at(-1) : "";
    say(byId("file-state"), [name, saved ? "" : "● not saved"].filter(Boolean).join(" "));
    byId("file-state").title = file ?? "";
    document.title = `${saved ? "" : "● "}${own?.title || name || "flexmb"}`;
    set(byId("save"), "title", `Save ${file ?? "…"} (Ctrl+S)`);
  }
  watch(store, ["document", "file", "saved"], update);
  return { open, save: saveNow, saveAs };
}

/** A menu opens under its button; arrows walk through it. */
function popover(menu, by) {
  menu.addEventListener("toggle", ({ newState }) => {
    if (newState !== "open") return;
    const { left, bottom } = by.getBoundingClientRect();
    menu.style.left = `${left}px`;
    menu.style.top = `${bottom + 4}px`;
    menu.querySelector("button")?.focus();
  });
  menu.addEventListener("keydown", (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const all = [...menu.querySelectorAll("button")];
    all[(all.indexOf(document.activeElement) + by + all.length) % all.length].focus();
  });
}
