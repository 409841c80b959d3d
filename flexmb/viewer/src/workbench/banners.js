/** What is told above the drawing: no connection, a file that another program changed. */
import { byId, button, h } from "./dom.js";
import { toast } from "./dialogs.js";

export function banners(store) {
  const root = byId("banners");
  let last = "";
  // A connection that is lost for a moment only is not worth a word.
  let quiet = true;
  setTimeout(() => ((quiet = false), update()), 1500);

  function update() {
    const { connected, disk, reason } = store.state;
    const now = JSON.stringify([connected || quiet, disk, reason]);
    if (now === last) return;
    last = now;
    root.replaceChildren();
    if (!connected && !quiet) {
      const text = reason || "No connection to flexmb. It is tried again all the time; what you change meanwhile is sent then.";
      root.append(h("div", { class: "bad", id: "disconnected" }, h("p", {}, text)));
    }
    const answer = (verb) => () => store.ask(verb).then(() => store.put({ disk: null }), (fault) => toast(fault.message));
    if (disk?.recovered) {
      root.append(
        h(
          "div",
          { id: "recovered" },
          h("p", {}, `${disk.name ?? "This mechanism"}: ${disk.summary ?? "what nobody saved came back."}`),
          button("Go on with it", answer("keep_disk"), { class: "main" }),
          button(store.state.file ? "Take the file instead" : "Begin anew", answer("take_disk")),
        ),
      );
    }
    if (disk?.changed) {
      root.append(
        h(
          "div",
          { id: "file-changed" },
          h("p", {}, `Another program changed ${disk.name ?? "the file"}. ${disk.summary ?? ""}`),
          button("Take it", answer("take_disk"), { class: "main" }),
          button("Keep what is here", answer("keep_disk")),
        ),
      );
    }
  }
  for (const part of ["connected", "disk", "reason"]) store.on(part, update);
}
