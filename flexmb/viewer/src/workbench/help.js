/** All keys, and the mouse. */
import { h } from "./dom.js";
import { ask } from "./dialogs.js";

const HELP = {
  Everywhere: [
    ["Ctrl+Z", "undo"],
    ["Ctrl+Y, Ctrl+Shift+Z", "do it again"],
    ["Ctrl+S", "save"],
    ["Ctrl+O", "open"],
    ["F1, ?", "this help"],
    ["F6, Shift+F6", "next, last part of the page"],
    ["/", "search what can be added"],
    ["Esc", "end the tool, give a field its text back"],
  ],
  "In the drawing": [
    ["S N M", "select, node, measure"],
    ["← → ↑ ↓", "move the cursor or what is selected by the grid"],
    ["Enter", "place or choose at the cursor"],
    ["Tab", "next thing"],
    ["Delete", "delete what is selected"],
    ["Ctrl+A", "select everything"],
    ["+ − F", "zoom, fit"],
  ],
  Mouse: [
    ["click", "select; with Shift add to it"],
    ["drag a node", "move it; the answers follow"],
    ["drag the ground", "move the view, in space turn it"],
    ["wheel", "zoom"],
  ],
  Fields: [
    ["0.5e-3", "a number, in SI units"],
    ["t, 2*w, (a+b)/2", "names and arithmetic; a new name can be made at once"],
    ["Enter", "next field"],
    ["↑ ↓ in Parts", "walk; Shift adds, Delete deletes, Enter goes to the properties"],
    ["↑ ↓ on a slider", "a small step; Page ↑ ↓ a larger one"],
  ],
};

export function help() {
  const list = h(
    "div",
    { id: "help-list" },
    ...Object.entries(HELP).map(([title, rows]) =>
      h("section", {}, h("h2", {}, title), h("dl", {}, ...rows.flatMap(([keys, text]) => [h("dt", {}, h("kbd", {}, keys)), h("dd", {}, text)]))),
    ),
  );
  const own = ask("Keys and mouse", list, "", null, { wide: true });
  own.id = "help-dialog";
  own.style.width = "min(760px, 94vw)";
}
