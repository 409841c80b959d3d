/** What is told above the drawing: no connection, a file that another program changed. */
import { button, byId, h, watch } from "./dom.js";
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
      const text =
        reason || "No connection to flexmb. The page keeps trying, and then sends your changes.";
      root.append(h("div", { class: "bad", id: "disconnected" }, h("p", {}, text)));
    }
    const offer = (id, text, take, keep) => {
      const answer = (verb) => () => store.ask(verb).catch((fault) => toast(fault.message));
      const both = [button(take, answer("take_disk"), { class: "main" }), button(keep, answer("keep_disk"))];
      root.append(h("div", { id }, h("p", {}, text), ...(id === "recovered" ? both.reverse() : both)));
    };
    if (disk?.changed) {
      const text = `Another program changed ${disk.name ?? "the file"}. ${disk.summary ?? ""}`;
      offer("file-changed", text, "Take it", "Keep the changes here");
    } else if (disk?.recovered) {
      const text = `flexmb ended before ${disk.name} was saved: ${disk.summary}`;
      offer("recovered", text, store.state.file ? "Use the file on disk" : "Begin anew", "Continue with the changes");
    }
  }
  watch(store, ["connected", "disk", "reason"], update);
}
