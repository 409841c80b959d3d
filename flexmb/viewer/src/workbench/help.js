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
    ["Esc", "end the tool, restore the text of a field"],
  ],
  "In the drawing": [
    ["S N M", "select, node, measure"],
    ["B R T P", "beam, rigid body, truss, spring"],
    ["H L W", "support (hold), load, mass"],
    ["I O Q", "input, output, degree of freedom"],
    ["← → ↑ ↓", "move the cursor or the selection by one grid step; with Shift by ten"],
    ["Enter", "place or choose at the cursor"],
    ["0.1, 20 mm", "type a position; @ relative to the last one; 0.1 < 45 for length and angle; = for names"],
    ["Tab", "next thing; after the last one, or after Esc, next part of the page"],
    ["Delete", "delete the selection"],
    ["D J A", "duplicate, mirror, repeat"],
    ["E", "properties of the selection"],
    ["Ctrl+A", "select everything"],
    ["F, Page ↑ ↓", "fit, zoom; Ctrl and arrows move the view, in space turn it"],
    ["G", "grid on or off"],
    ["X Y Z, [ ]", "in space: choose the drawing plane; move it down, up"],
    ["Space", "play or pause"],
  ],
  Mouse: [
    ["click", "select; with Shift add to it"],
    ["drag a node", "move it; the answers follow; onto another node: join"],
    ["drag the ground", "select things in the rectangle; drawn to the left, also things that it touches"],
    ["right button", "move the view, in space turn it; the middle one moves it"],
    ["Alt", "without grid and lines"],
    ["wheel", "zoom"],
  ],
  Fields: [
    ["0.5e-3", "a number, in SI units"],
    ["t, 2*w, (a+b)/2", "names and arithmetic; a new name can be added at once"],
    ["↑ ↓ in Parts", "walk; Shift adds, Delete deletes, Enter goes to the properties"],
    ["↑ ↓ on a slider", "a small step; Page ↑ ↓ a larger one"],
  ],
};

export function help() {
  const list = h(
    "div",
    { id: "help-list" },
    ...Object.entries(HELP).map(([title, rows]) =>
      h(
        "section",
        {},
        h("h2", {}, title),
        h("dl", {}, ...rows.flatMap(([keys, text]) => [h("dt", {}, h("kbd", {}, keys)), h("dd", {}, text)])),
      ),
    ),
  );
  const own = ask("Keys and mouse", list, "", null, { wide: true });
  own.id = "help-dialog";
  own.style.width = "min(1060px, 94vw)";
}
