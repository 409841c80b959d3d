/** Moving nodes: by hand, by the arrow keys, or to coordinates that are typed. */
import { isPlain, nameIn, textOf } from "./arithmetic.js";
import { listOf } from "./plan.js";

const LETTERS = "xyz";
let count = 0;

/** Ids of the nodes that go along with what is selected. */
export function nodesOf(canvas, ids) {
  const found = new Set();
  for (const id of ids) {
    const thing = canvas.thing(id);
    if (thing?.call === "node") found.add(id);
    const line = canvas.plan.lines.find((own) => own.id === id);
    for (const node of line?.nodes ?? []) if (node.id && canvas.thing(node.id)?.call === "node") found.add(node.id);
  }
  return [...found];
}

export class Dragging {
  /** One step of the history, however often `to` is called. */
  constructor(canvas, ids, label) {
    this.canvas = canvas;
    this.merge = `drag ${Date.now()} ${(count += 1)}`;
    this.nodes = ids.map((id) => this.begin(canvas.thing(id))).filter(Boolean);
    this.names = new Set(this.nodes.map(({ name }) => name));
    this.label = label ?? `Move ${this.nodes.map(({ name }) => name).slice(0, 3).join(", ")}`;
    this.told = new Set();
    this.sent = 0;
    this.last = null;
  }

  begin(thing) {
    const node = this.canvas.plan.byName.get(thing?.name);
    if (!node) return null;
    const texts = listOf(thing.args.position);
    const names = this.canvas.store.state.document.names ?? {};
    const held = texts.map((text) => {
      if (isPlain(text)) return { kind: "number" };
      const name = nameIn(text);
      const own = name && names[name];
      return own && isPlain(own.value) ? { kind: "name", name, value: Number(own.value), own } : { kind: "held", text };
    });
    return { id: thing.id, name: thing.name, at: node.at.slice(), texts, held };
  }

  /** Go to where the first node, or `anchor`, is moved by so much. */
  by(delta) {
    const { canvas } = this;
    const ops = [];
    const named = new Map();
    for (const node of this.nodes) {
      const texts = node.texts.slice();
      const at = node.at.slice();
      node.held.forEach((own, k) => {
        if (Math.abs(delta[k]) < 1e-15) return;
        if (own.kind === "held") {
          this.told.add(`${LETTERS[k]} of ${node.name} follows from ${own.text}`);
          return;
        }
        at[k] = node.at[k] + delta[k];
        if (own.kind === "number") texts[k] = textOf(at[k]);
        else named.set(own.name, this.inBounds(own, own.value + delta[k]));
      });
      canvas.moved[node.name] = at;
      if (texts.some((text, k) => text !== node.texts[k]) || this.sent) {
        ops.push({ op: "set", address: `${node.id}/position`, to: texts });
      }
    }
    for (const [name, value] of named) ops.push({ op: "set", address: `names/${name}/value`, to: textOf(value) });
    // What hangs on a name is placed by the server.
    if (named.size) for (const node of this.nodes) delete canvas.moved[node.name];
    this.named = named;
    this.next = ops;
    canvas.replan();
  }

  inBounds({ own }, value) {
    const [low, high] = [own.low, own.high].map((text) => (isPlain(String(text ?? "")) ? Number(text) : NaN));
    return Math.min(Math.max(value, Number.isFinite(low) ? low : value), Number.isFinite(high) ? high : value);
  }

  /** Words on what could not be moved. */
  get words() {
    const names = [...(this.named ?? [])].map(([name, value]) => `${name} = ${textOf(value)}`);
    return [...names, ...this.told].join("; ");
  }

  /** Send where things are now: at most once a frame. */
  send() {
    if (!this.next?.length) return;
    const ops = this.next;
    this.next = null;
    this.sent += 1;
    this.last = this.canvas.edit(ops, this.label, this.merge);
  }

  /** Let go; `joined` is the node that the one moved becomes part of. */
  async end(joined = null) {
    this.send();
    const { canvas } = this;
    if (joined) {
      await this.last;
      this.last = canvas.edit([{ op: "join", from: this.nodes[0].name, into: joined }], `Join ${this.nodes[0].name} to ${joined}`, this.merge);
    }
    await this.last;
    this.release();
  }

  /** Back to where everything was. */
  async cancel() {
    this.next = null;
    const { canvas } = this;
    this.release();
    if (!this.sent) return;
    await this.last;
    await canvas.store.ask("undo").catch((problem) => canvas.say(problem.message));
  }

  release() {
    for (const name of this.names) delete this.canvas.moved[name];
    this.canvas.replan();
  }
}
