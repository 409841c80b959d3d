/** Questions before something is done: copy, mirror, repeat, split, join; and messages. */
import { byId, button, h, say } from "./dom.js";

import { form, ofObject } from "./forms.js";
import { spoken, thing, things } from "./model.js";
import { freeName } from "./sections.js";

/** A dialog with its buttons; the answer of `act` closes it, what it throws is told in it. */
export function ask(title, content, actText, act, { wide = false, danger = false } = {}) {
  const fault = h("p", { class: "problem", role: "alert", hidden: true });
  const cancel = button(act ? "Cancel" : "Close", () => own.close());
  const go = act ? h("button", { type: "submit", class: danger ? "danger" : "main" }, actText) : null;
  const body = h(
    "form",
    { method: "dialog" },
    h("h2", {}, title),
    content,
    fault,
    h("div", { class: "buttons" }, cancel, go),
  );
  const own = h("dialog", { class: wide ? "wide" : "", "aria-label": title }, body);
  body.addEventListener("submit", (event) => {
    event.preventDefault();
    if (!act || go.disabled) return;
    go.disabled = true;
    Promise.resolve()
      .then(act)
      .then(() => own.close())
      .catch((problem) => {
        say(fault, problem.message);
        fault.hidden = false;
      })
      .finally(() => (go.disabled = false));
  });
  own.addEventListener("close", () => own.remove());
  document.body.append(own);
  own.showModal();
  (content.querySelector?.("input, select, textarea") ?? go ?? cancel).focus();
  return own;
}

let fading = null;
/** A message that goes away by itself. */
export function toast(message) {
  const place = byId("toast");
  say(place, message);
  place.hidden = false;
  clearTimeout(fading);
  fading = setTimeout(() => (place.hidden = true), 6000);
}

const numberField = (name, unit, more = {}) => ({ name, kind: "number", unit, optional: false, ...more });

export function dialogs(store) {
  const told = (fault) => toast(fault.message);
  const called = (ids) => {
    const first = spoken(store, thing(store, ids[0]) ?? { call: "" });
    return ids.length === 1 ? first : `${ids.length} things`;
  };
  const edit = (ops, label) => store.edit(ops, { label });
  const choose = (reply) => reply?.ids?.length && store.select(reply.ids);

  /** A form about a few texts, and what is done with them. */
  function asked(title, fields, args, actText, act) {
    const made = form(
      store,
      fields,
      ofObject(args, () => made.update()),
    );
    return ask(title, made.element, actText, () => act(args));
  }
  const byField = () => ({ name: "by", kind: "vector", unit: "m", count: store.state.document.dimension });
  const step = () => ({ by: store.state.document.dimension === 2 ? ["0.1", "0"] : ["0.1", "0", "0"] });
  const whole = (ids) => {
    // Elements are copied with their nodes.
    const names = new Set(ids.flatMap((id) => [thing(store, id)?.args?.nodes ?? []].flat()));
    const nodes = things(store).filter(({ call, name }) => call === "node" && names.has(name));
    return [...new Set([...nodes.map(({ id }) => id), ...ids])];
  };

  return {
    told,
    copy(ids) {
      asked(`Copy ${called(ids)}`, [byField()], step(), "Copy", async ({ by }) =>
        choose(await edit([{ op: "copy", ids: whole(ids), by, count: 1 }], `Copy ${called(ids)}`)),
      );
    },
    repeat(ids) {
      const fields = [byField(), numberField("count", "copies")];
      asked(`Repeat ${called(ids)}`, fields, { ...step(), count: "3" }, "Repeat", async ({ by, count }) => {
        const number = Number(count);
        if (!Number.isInteger(number) || number < 1 || number > 1000)
          throw new Error("The number of copies must be a whole number from 1 to 1000.");
        choose(await edit([{ op: "copy", ids: whole(ids), by, count: number }], `Repeat ${called(ids)}`));
      });
    },
    mirror(ids) {
      const axes = store.state.document.dimension === 2 ? ["x", "y"] : ["x", "y", "z"];
      const fields = [
        { name: "axis", kind: "choice", choices: axes, doc: "Axis along which to mirror" },
        numberField("at", "m", { doc: "Position of the mirror on this axis" }),
      ];
      asked(`Mirror ${called(ids)}`, fields, { axis: "x", at: "0" }, "Mirror", async ({ axis, at }) =>
        choose(await edit([{ op: "mirror", ids: whole(ids), axis, at }], `Mirror ${called(ids)}`)),
      );
    },
    split(own) {
      const fields = [
        numberField("at", "of its length", { doc: "Share of the length from the first node, between 0 and 1" }),
      ];
      asked(`Split ${own.name}`, fields, { at: "0.5" }, "Split", async ({ at }) =>
        choose(await edit([{ op: "split", element: own.name, at }], `Split ${own.name}`)),
      );
    },
    join(own) {
      const others = things(store).filter(({ call, id }) => call === "node" && id !== own.id);
      const fields = [{ name: "into", kind: "choice", choices: others.map(({ name }) => name) }];
      asked(`Join ${own.name} into another node`, fields, { into: others[0]?.name ?? "" }, "Join", ({ into }) =>
        edit([{ op: "join", from: own.name, into }], `Join ${own.name} into ${into}`),
      );
    },
    explode(own) {
      edit([{ op: "explode", id: own.id }], `Explode ${spoken(store, own)}`).then(choose, told);
    },
    duplicate(ids) {
      const own = thing(store, ids[0]);
      const name = freeName(store, own.name);
      edit([{ op: "add", thing: { call: own.call, name, args: own.args } }], `Copy ${own.name}`).then(choose, told);
    },
    remove(ids) {
      const what = called(ids);
      edit([{ op: "delete", ids: [...ids] }], `Delete ${what}`).then((reply) => {
        const along = (reply?.also ?? []).length;
        if (along)
          toast(
            `Deleted ${what}, and ${along} that needed ${ids.length === 1 ? "it" : "them"}. Ctrl+Z brings all back.`,
          );
      }, told);
    },
  };
}

/** One question about a node's name and the like, a list with marks. */
export function plainly(lines) {
  return h("ul", { class: "plainly" }, ...lines.map((one) => h("li", {}, String(one))));
}
