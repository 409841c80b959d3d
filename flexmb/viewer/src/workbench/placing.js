/** Making things by clicks: nodes, elements between nodes, and what stands on a node or element. */
import { fieldsOf, groupOf } from "./plan.js";
import { textOf } from "./arithmetic.js";
import { thingAt } from "./snap.js";
import { hinged, isHinge, SLOTS } from "./hinges.js";
import { drawDimension, words } from "./measure.js";
import { freeName, freshName } from "./naming.js";
import * as symbols from "./symbols.js";

const SLACK = 6;
// What is put where nothing was chosen, and is meant to be changed.
const STARTS = {
  mass: () => ({ mass: "0.1" }),
  inertia: () => ({ inertia: "1e-5" }),
  moment: (planar) => ({ moment: planar ? ["0.1"] : ["0", "0", "0.1"] }),
  force: (planar) => ({ force: planar ? ["0", "-1"] : ["0", "0", "-1"] }),
  gravity: (planar) => ({ acceleration: planar ? ["0", "-9.81"] : ["0", "0", "-9.81"] }),
  dof: (_, node) => ({ components: node ? "x" : "1" }),
  input: (_, node) => ({ component: node ? "x" : "1" }),
  output: (_, node) => ({ component: node ? "x" : "1" }),
  prescribe: (_, node) => ({ component: node ? "x" : "1" }),
};

/** What must be clicked, in order: {field, what: "node" | "of" | "element" | "place" | "direction"}. */
function slotsOf(catalogue, call, kind) {
  if (kind === "node") return [{ field: "position", what: "place" }];
  if (isHinge(call)) return SLOTS;
  const slots = [];
  for (const { name, kind: what, count, optional } of catalogue?.[call]?.fields ? fieldsOf(catalogue, call) : guessed(call)) {
    // What may be left out is filled in elsewhere; the stage of a block is a node of its own making.
    if (optional || (name === "stage" && call.startsWith("blocks."))) continue;
    for (let i = 0; i < (what === "nodes" ? count ?? 2 : 1); i += 1) {
      slots.push({ field: name, what: what === "nodes" ? "node" : what, list: what === "nodes" });
    }
  }
  if (call.startsWith("blocks.")) slots.push({ field: "along", what: "direction" });
  return slots;
}

/** What is clicked while the catalogue is not there. */
function guessed(call) {
  const group = groupOf(null, call);
  if (group === "element") return [{ name: "nodes", kind: "nodes" }];
  return [{ name: { block: "base", input: "of", output: "of", dof: "of" }[group] ?? "node", kind: group === "block" ? "node" : "of" }];
}

export class Placing {
  constructor(canvas, call, args, kind) {
    const { catalogue } = canvas.store.state;
    Object.assign(this, { canvas, call, args, kind });
    this.slots = slotsOf(catalogue, call, kind);
    const title = catalogue?.[call]?.title ?? call.split(".").pop().replaceAll("_", " ");
    this.title = title[0].toUpperCase() + title.slice(1);
    this.given = [];
    this.waiting = [];
    this.making = false;
  }

  get slot() {
    return this.slots[this.given.length];
  }

  get prompt() {
    if (this.kind === "node") return "Click where the node shall be";
    const { slot, given, title, call } = this;
    if (!slot) return `${title}: click anywhere to add it`;
    if (slot.what === "direction") return `${title}: click its direction`;
    if (isHinge(call)) return `${title}: click ${given.length ? "the element that turns there" : "the node"}`;
    if (call.startsWith("blocks.")) return `${title}: click its position`;
    if (slot.list) return `${title}: click ${given.length ? "the next" : "its first"} end`;
    const what = { of: "the node or element", element: "the element" }[slot.what] ?? "the node";
    return `${title}: click ${what}${this.slots.length > 1 ? ` (${slot.field})` : ""}`;
  }

  /** Elements may end in empty space, and blocks stand there: a node is made. */
  get makes() {
    return this.kind === "node" || Boolean(this.slot?.list) || this.call.startsWith("blocks.");
  }

  get options() {
    const from = this.given.at(-1)?.place ?? null;
    return { from, through: from?.point ?? null, lines: this.makes && this.slot?.what !== "direction" };
  }

  press(place, { x, y, reach }) {
    this.start = [x, y];
    this.give(place, x, y, reach);
  }

  /** Two ends may be drawn in one stroke, and a load by pulling. */
  drag(place, { x, y }) {
    if (!this.start || Math.hypot(x - this.start[0], y - this.start[1]) < SLACK) return;
    this.stroke = this.given.length > 0;
  }

  release(place, { x, y, reach }) {
    const far = this.start && Math.hypot(x - this.start[0], y - this.start[1]) >= 3 * SLACK;
    this.start = null;
    if (far && this.stroke && this.slot) this.give(place, x, y, reach);
    this.stroke = false;
  }

  give(place, x, y, reach) {
    const { canvas, slot } = this;
    if (this.making) {
      // A quick hand: this click belongs to the next thing.
      this.waiting.push([place, x, y, reach]);
      return;
    }
    if (!slot) {
      this.finish();
      return;
    }
    const own = this.taken(place, x, y, reach);
    if (!own) {
      const what = { of: "a node or an element", element: "an element" }[slot.what] ?? "a node";
      canvas.say(`Nothing here: click ${what}.`);
      return;
    }
    const last = this.given.at(-1);
    const same = slot.list && last && last.place.point.every((value, k) => Math.abs(value - own.place.point[k]) < 1e-12);
    if (same) {
      canvas.say("Both ends would be in one place: click another.");
      return;
    }
    this.given.push(own);
    if (this.slot) canvas.say(`${place.word}. ${this.prompt}.`);
    else this.finish();
    canvas.told();
  }

  taken(place, x, y, reach) {
    const { slot, canvas } = this;
    if (slot.what === "element" || (slot.what === "of" && place.kind !== "node")) {
      const id = thingAt(canvas, x, y, reach);
      const line = canvas.plan.lines.find((own) => own.id === id);
      return line ? { slot, place, name: line.name } : null;
    }
    if (slot.what === "direction" || slot.what === "place") return { slot, place };
    if (place.kind === "node") return { slot, place, name: place.node.turns ?? place.node.name };
    return this.makes ? { slot, place } : null;
  }

  async finish() {
    const { canvas, given, waiting } = this;
    this.given = [];
    this.making = true;
    try {
      await this.make(given);
    } catch (problem) {
      canvas.say(problem.message, true);
    }
    this.making = false;
    canvas.told();
    for (const [place, ...rest] of waiting.splice(0)) this.give(this.renewed(place), ...rest);
  }

  /** A place in empty space, where by now a node may be. */
  renewed(place) {
    const node = place.kind === "node" ? null : this.canvas.nodeOn(place.point);
    return node ? { ...place, kind: "node", node, word: `node ${node.name}` } : place;
  }

  /** One step of the history for all that is made. */
  async make(given) {
    const { canvas, call, title } = this;
    const merge = given.some(({ place }) => place.kind === "line") ? `make ${Date.now()}` : null;
    const ops = [];
    const taken = new Set();
    for (const own of given) {
      if (own.name || own.slot.what === "direction") continue;
      own.name = await this.nodeAt(own.place, ops, taken, merge);
    }
    if (this.kind === "node") {
      if (ops.length) await this.send(ops, `Add node ${given[0].name}`, merge);
      canvas.say(`Node ${given[0].name} at ${given[0].place.word}.`);
      return;
    }
    const thing = { call, args: this.arguments(given, taken) };
    if (isHinge(call)) {
      const { ops: first, nodes } = hinged(canvas, given[0].name, given[1].name, taken);
      ops.push(...first);
      thing.args.nodes = nodes;
      if (call === "spatial.hinge") thing.args.axis ??= [0, 1, 2].map((k) => String(Number(k === canvas.eye.normal())));
    }
    const name = this.name(taken);
    if (name) thing.name = name;
    ops.push({ op: "add", thing });
    await this.send(ops, `Add ${name ?? title}`, merge, true);
    const ends = given.map((own) => own.name).filter(Boolean).join(" and ");
    canvas.say(`${name ?? title}${ends ? ` on ${ends}` : ""}.`);
  }

  async send(ops, label, merge, last = false) {
    const { store } = this.canvas;
    this.canvas.drawn = true;
    const { ids, revision } = await store.edit(ops, { label, merge });
    await this.canvas.reached(revision);
    if (ids?.length) store.select(last ? ids.slice(-1) : ids);
  }

  async nodeAt(place, ops, taken, merge) {
    const { canvas } = this;
    if (place.kind === "node") return place.node.name;
    if (place.kind === "line") {
      const { revision } = await canvas.store.edit([{ op: "split", element: place.line.name, at: textOf(place.share) }], {
        label: `split ${place.line.name}`, merge,
      });
      await canvas.reached(revision);
      const found = canvas.nodeOn(place.point);
      if (!found) throw new Error(`Element ${place.line.name}was divided, but its new node was not found.`);
      return found.name;
    }
    const name = freshName(canvas, taken);
    taken.add(name);
    ops.push({ op: "add", thing: { call: "node", name, args: { position: place.texts } } });
    return name;
  }

  arguments(given, taken) {
    const { canvas, call, args } = this;
    const { catalogue, document: own } = canvas.store.state;
    const planar = own.dimension === 2;
    const all = STARTS[call]?.(planar, given[0]?.place.kind === "node") ?? {};
    const fields = catalogue?.[call]?.fields;
    for (const [name, value] of Object.entries(args)) if (value !== "" && value !== null) all[name] = value;
    for (const { slot, name, place } of given) {
      if (slot.what === "direction") this.stand(all, given[0].place, place, planar, fields);
      else if (slot.list) all[slot.field] = given.filter((one) => one.slot.field === slot.field).map((one) => one.name);
      else all[slot.field] = name;
    }
    for (const field of fields ?? []) {
      if (field.optional || all[field.name] !== undefined) continue;
      if (field.kind === "section" || field.kind === "material") {
        const last = own.things.filter((thing) => groupOf(catalogue, thing.call) === field.kind).at(-1);
        if (last) all[field.name] = last.name;
      }
      if (field.name === "stage") {
        all.stage = freshName(canvas, taken);
        taken.add(all.stage);
      }
    }
    if (fields?.some(({ name }) => name === "section") && !("section" in args) && call.endsWith(".beam")) {
      const last = own.things.filter((thing) => groupOf(catalogue, thing.call) === "section").at(-1);
      if (last) all.section = last.name;
    }
    return all;
  }

  /** Direction and length of a block, from its first node to the second click. */
  stand(all, from, to, planar, fields) {
    const delta = to.point.map((value, k) => value - from.point[k]);
    const size = Math.hypot(...delta);
    if (size < 1e-12) return;
    const known = (name) => !fields || fields.some((field) => field.name === name);
    if (all.along === undefined && known("along")) {
      all.along = delta.slice(0, planar ? 2 : 3).map((value) => textOf(Number((value / size).toPrecision(9))));
    }
    if (all.length === undefined && known("length")) all.length = textOf(Number(size.toPrecision(6)));
  }

  name(taken) {
    const { canvas, call } = this;
    const prefix = canvas.store.state.catalogue?.[call]?.name;
    if (!prefix) return null;
    return freeName(canvas, prefix, taken);
  }

  cancel() {
    const some = this.given.length > 0;
    this.given = [];
    this.start = null;
    return some;
  }

  draw(drawing) {
    const { pen, colours, eye } = drawing;
    const { canvas, given } = this;
    const last = given.at(-1);
    if (!last || !canvas.place) return;
    const [from, to] = [eye.project(last.place.point), eye.project(canvas.place.point)];
    pen.strokeStyle = colours.beam;
    pen.lineWidth = 3;
    pen.setLineDash([7, 5]);
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...to);
    pen.stroke();
    pen.setLineDash([]);
    for (const own of given) {
      symbols.circle(pen, eye.project(own.place.point), 4);
      pen.fillStyle = colours.chosen;
      pen.fill();
    }
    drawDimension(drawing, last.place.point, canvas.place.point, words(last.place, canvas.place, eye.planar));
  }
}
