/** What the page knows, and how it asks for changes. The document itself is the server's; nothing is computed here. */
import { Connection } from "./connection.js";

// Letters of one message [-], as the server has it.
const LONGEST_MESSAGE = 4_000_000;

const fresh = () => ({
  connected: false,
  document: null,
  revision: null,
  positions: {},
  values: {},
  problems: [],
  undo: [],
  redo: [],
  saved: true,
  file: null,
  count: null,
  answers: null,
  scene: null,
  ways: null,
  disk: null,
  jobs: {},
  pinned: null,
  catalogue: null,
  analyses: null,
  notes: [],
  version: null,
  selection: [],
  tool: { kind: "select" },
  want: { mode: 0, state: "modes", colour: null, support_node: null, sensitivity_of: null },
});

/** What cannot be done, and the address of the field where one is meant. */
export class Problem extends Error {
  constructor({ message, address }) {
    super(message);
    this.name = "Problem";
    this.address = address;
  }
}

/** A place that an operation sets as a whole, or null: of two that set the same, the newer alone counts. */
function place(op) {
  if (op.op === "set") return `set ${op.address}`;
  if (op.op === "name" && op.to) return `name ${op.name}`;
  return null;
}

/** Operations after one another, those that are overtaken left out; null where that cannot be said. */
function joined(older, newer) {
  if (![...older, ...newer].every(place)) return null;
  const last = new Map();
  for (const op of [...older, ...newer]) last.set(place(op), op);
  return [...last.values()];
}

export class Store {
  constructor() {
    this.state = fresh();
    this.listeners = [];
    this.changed = new Set();
    // Requests without a reply by number, in order; those that may be sent again after the connection was lost.
    this.asked = new Map();
    // By merge key: the edit under way, and the one that waits for it.
    this.merging = new Map();
    // Not randomUUID, which a page in a frame of an insecure one does not have.
    this.page = Array.from(crypto.getRandomValues(new Uint32Array(4)), (part) => part.toString(36)).join("-");
    this.run = null;
    this.number = 0;
  }

  /** Connect to the server that this page came from. */
  connect(address = new URL("socket", location.href.replace(/^http/, "ws")).href) {
    this.connection = new Connection(address, {
      opened: () => this.greet(),
      // What the server said when it ended stays; tries that follow have nothing to say.
      closed: (reason) => this.put({ connected: false, reason: reason || this.state.reason || "" }),
      heard: (message) => this.hear(message),
    });
  }

  // Listening.

  /** Call a function after a part of the state changed ("*": any), once a frame; the answer ends it. */
  on(key, listener) {
    const own = { key, listener };
    this.listeners.push(own);
    return () => {
      this.listeners = this.listeners.filter((other) => other !== own);
    };
  }

  put(changes) {
    Object.assign(this.state, changes);
    for (const key of Object.keys(changes)) this.changed.add(key);
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => this.notify());
  }

  notify() {
    this.waiting = false;
    const { changed } = this;
    this.changed = new Set();
    for (const { key, listener } of this.listeners) {
      if (key !== "*" && !changed.has(key)) continue;
      try {
        listener(this.state, changed);
      } catch (fault) {
        // One part of the page that fails takes no other with it.
        console.error(fault);
      }
    }
  }

  // What the page itself decides.

  select(ids, { add = false } = {}) {
    const old = this.state.selection;
    const selection = add ? [...old.filter((id) => !ids.includes(id)), ...ids.filter((id) => !old.includes(id))] : [...ids];
    this.put({ selection });
  }

  setTool(tool) {
    this.put({ tool });
  }

  want(changes) {
    const want = { ...this.state.want, ...changes };
    this.put({ want });
    return this.merged("want", "want", want, (older, newer) => newer);
  }

  // Asking.

  /** Change the document. Edits of one merge key make one step of undo; while one is under way the newest waits. */
  edit(ops, { label = "", merge = null } = {}) {
    const own = { ops, label, ...(merge === null ? {} : { merge }) };
    if (merge === null) return this.ask("edit", own);
    return this.merged(merge, "edit", own, (older, newer) => {
      const all = joined(older.ops, newer.ops);
      return all && { ...newer, ops: all };
    });
  }

  /** Ask for something; rejects with a Problem. What waits by a merge key goes first. */
  ask(verb, own = {}) {
    for (const key of this.merging.keys()) this.flush(key);
    return this.request(verb, own);
  }

  merged(key, verb, own, join) {
    const under = this.merging.get(key);
    if (!under) {
      const entry = { waiting: null };
      this.merging.set(key, entry);
      return this.request(verb, own).finally(() => this.next(key, entry));
    }
    const old = under.waiting;
    const both = old && join(old.own, own);
    if (old && !both) this.flush(key);
    if (both) {
      old.own = both;
      return old.promise;
    }
    const entry = { verb, own };
    entry.promise = new Promise((resolve, reject) => Object.assign(entry, { resolve, reject }));
    under.waiting = entry;
    return entry.promise;
  }

  /** Send what waits behind an edit that has been answered. */
  next(key, entry) {
    const { waiting } = entry;
    entry.waiting = null;
    if (!waiting) {
      this.merging.delete(key);
      return;
    }
    this.request(waiting.verb, waiting.own)
      .finally(() => this.next(key, entry))
      .then(waiting.resolve, waiting.reject);
  }

  /** Send what waits at once. */
  flush(key) {
    const entry = this.merging.get(key);
    const { waiting } = entry;
    if (!waiting) return;
    entry.waiting = null;
    this.request(waiting.verb, waiting.own).then(waiting.resolve, waiting.reject);
  }

  request(verb, own) {
    this.number += 1;
    const id = this.number;
    const text = JSON.stringify({ id, do: verb, ...own });
    if (text.length > LONGEST_MESSAGE) {
      const message = `This is too much for one message: ${text.length} letters, but at most ${LONGEST_MESSAGE} are allowed.`;
      return Promise.reject(new Problem({ message }));
    }
    return new Promise((resolve, reject) => {
      this.asked.set(id, { verb, text, resolve, reject });
      if (this.state.connected) this.connection.send(text);
    });
  }

  // What the server says.

  /** Begin, or begin again: what has no reply yet is sent once more, and the server knows what it has done already. */
  greet() {
    this.number += 1;
    const id = this.number;
    for (const [old, { verb }] of this.asked) if (verb === "hello") this.asked.delete(old);
    const hello = { verb: "hello", resolve: (reply) => this.welcomed(reply), reject: (fault) => console.error(fault) };
    this.asked.set(id, hello);
    this.connection.send(JSON.stringify({ id, do: "hello", page: this.page, run: this.run }));
  }

  welcomed({ catalogue, notes, version, run, want }) {
    const restarted = this.run !== null && run !== this.run;
    if (restarted) this.restarted();
    this.run = run;
    this.put({ connected: true, reason: "", catalogue, notes, version });
    for (const { verb, text } of this.asked.values()) if (verb !== "hello") this.connection.send(text);
    // All pages show one state of one mode: a new page takes it, and one whose server is new brings it.
    if (restarted) this.want({}).catch(() => {});
    else if (want) this.put({ want: { ...this.state.want, ...want } });
  }

  /** Another process answers now: what it never computed is gone. */
  restarted() {
    const jobs = {};
    for (const [id, job] of Object.entries(this.state.jobs)) {
      jobs[id] = job.status === "running" ? { ...job, status: "failed", text: "The workbench was restarted." } : job;
    }
    this.put({ jobs, answers: null, count: null, ways: null, disk: null });
    this.asked.forEach(({ verb, reject }, id) => {
      if (!["target", "fit", "run", "stop"].includes(verb)) return;
      this.asked.delete(id);
      reject(new Problem({ message: "The workbench was restarted: ask again." }));
    });
  }

  hear(message) {
    if ("tell" in message) this.told(message);
    else this.replied(message);
  }

  replied({ re, ok, problem, ...reply }) {
    const own = this.asked.get(re);
    if (!own) return;
    this.asked.delete(re);
    if (ok) own.resolve(reply);
    else own.reject(new Problem(problem));
  }

  told({ tell, ...content }) {
    if (tell === "document") {
      const there = new Set(content.document.things.map(({ id }) => id));
      const selection = this.state.selection.filter((id) => there.has(id));
      this.put(selection.length === this.state.selection.length ? content : { ...content, selection });
    } else if (tell === "job") {
      this.put({ jobs: { ...this.state.jobs, [content.job]: content } });
    } else if (tell === "file") {
      this.put({ disk: content });
    } else if (tell === "want") {
      // While this page's own waits or is under way, that is the newer one.
      if (!this.merging.has("want")) this.put({ want: { ...this.state.want, ...content } });
    } else if (tell === "analyses") {
      this.put(content);
    } else if (tell in this.state) {
      this.put({ [tell]: content });
    }
  }
}
