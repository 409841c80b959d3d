/** What every field of a form has: a label, what is beside it, and a place for what is wrong. */
import { remark } from "./box.js";
import { h, newId } from "./dom.js";
import { words } from "./model.js";

export const filled = (value) => value !== undefined && value !== null && String(value) !== "";

export const list = (value) => (Array.isArray(value) ? value : filled(value) ? String(value).split(/[\s,]+/) : []);

/** A label, what is beside it, and the place for what is wrong. */
export function row(field, inputs, body, note = remark(...inputs)) {
  const text = words(field.name);
  const single = inputs.length === 1;
  const label = single ? h("label", {}, text) : h("span", { class: "label", id: newId() }, text);
  if (field.doc) label.title = field.doc;
  if (single) {
    inputs[0].id ||= newId();
    label.htmlFor = inputs[0].id;
  } else {
    body.setAttribute("role", "group");
    body.setAttribute("aria-labelledby", label.id);
  }
  return { element: h("div", { class: "field" }, label, body, note.element), note };
}

/** Mark an input of several as the one that is wrong. */
export function mark(input, on, note) {
  if (on) {
    input.setAttribute("aria-invalid", "true");
    input.setAttribute("aria-describedby", note.element.id);
  } else {
    input.removeAttribute("aria-invalid");
    input.removeAttribute("aria-describedby");
  }
}
