/** A text box that sends what is typed and shows what the document holds, and never takes the words out of a mouth. */
import { h, newId, say, set } from "./dom.js";

// Typing has paused after this long [ms]: a number that is half typed is no design.
const PAUSE = 400;

/**
 * @param store The store.
 * @param own `get()` gives the text that the document holds; `send(text, visit)` sends another one and gives the reply's
 *   promise, rejected where it is refused; `problem()` gives what the document has against it; `rest` are attributes.
 * @returns The input as `element`, `update()` after every change of the state, and `fault()`: what is wrong with it.
 */
export function box(store, { get, send, problem = () => null, rest = {}, lazy = false, changed = () => {} }) {
  const input = h("input", { type: "text", autocomplete: "off", spellcheck: "false", ...rest });
  let last = null; // What the document held when this was last looked at.
  let turn = 0; // The newest text that was sent, and whether its reply has come.
  let waiting = false;
  let awaited = 0; // The revision that holds it.
  let refused = null;
  // Each time that the field is gone into makes a step of undo of its own.
  let visit = newId();
  input.addEventListener("focus", () => (visit = newId()));

  let timer = null; // Runs while a text is typed and not sent yet.
  function go() {
    clearTimeout(timer);
    timer = null;
    const text = input.value;
    turn += 1;
    const mine = turn;
    waiting = true;
    refused = null;
    Promise.resolve(send(text, visit)).then(
      (reply) => settle(mine, reply?.revision ?? 0, null),
      (fault) => settle(mine, 0, fault?.message ?? String(fault)),
    );
    changed();
  }

  function settle(mine, revision, fault) {
    awaited = Math.max(awaited, revision);
    if (mine !== turn) return;
    waiting = false;
    refused = fault;
    update();
    changed();
  }

  function update() {
    const held = String(get() ?? "");
    if (timer || waiting || (store.state.revision ?? 0) < awaited) return;
    const moved = held !== last;
    last = held;
    if (moved) refused = null;
    if (lazy && document.activeElement === input && !moved) return;
    if (!refused && input.value !== held) input.value = held;
    set(input, "aria-invalid", fault() ? "true" : null);
  }

  function reset() {
    clearTimeout(timer);
    timer = null;
    refused = null;
    waiting = false;
    turn += 1;
    input.value = String(get() ?? "");
    update();
    changed();
  }

  if (lazy) input.addEventListener("change", go);
  else {
    input.addEventListener("input", () => {
      clearTimeout(timer);
      timer = setTimeout(go, PAUSE);
    });
    input.addEventListener("blur", () => timer && go());
  }
  input.addEventListener("keydown", (event) => {
    // Also what a shortcut does, such as to save, is done to the text that stands here.
    if (timer && (event.key === "Enter" || event.ctrlKey || event.metaKey)) go();
    if (event.key === "Enter" && lazy && input.value !== String(get() ?? "")) go();
    if (event.key === "Escape" && (timer || refused || lazy)) {
      event.stopPropagation();
      reset();
    }
  });
  const fault = () => refused ?? problem();
  update();
  return { element: input, update, fault, text: () => input.value, reset };
}

/** The place under a field where it is told what is wrong, or what else there is to say. */
export function remark(...inputs) {
  const id = newId();
  const element = h("p", { class: "problem", id, hidden: true });
  const texts = h("span");
  element.append(texts);
  return {
    element,
    tell(message, ...actions) {
      say(texts, message ?? "");
      element.hidden = !message;
      const there = [...element.querySelectorAll("button")];
      if (there.map((one) => one.textContent).join() !== actions.map((one) => one.textContent).join()) {
        there.forEach((one) => one.remove());
        element.append(...actions.flatMap((one) => [" ", one]));
      }
      for (const input of inputs) {
        set(input, "aria-describedby", message ? id : null);
        set(input, "aria-invalid", message ? "true" : null);
      }
    },
  };
}
