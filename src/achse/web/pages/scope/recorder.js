import { decode } from "./blocks.js";
import { derive, parse, sources, unitOf } from "./derive.js";
import { Ring } from "./ring.js";

const MOST_VALUES = 8_000_000; // of one ring: 64 MB
const KEPT = 120; // seconds that can be looked back, if they fit

/**
 * The samples of the page: starts and stops its scope at the server, keeps what comes in a ring.
 *
 * `notify(what, value)` hears "samples", "state", "trigger" (its time) and "error".
 */
export class Recorder {
  constructor(session, notify) {
    this._session = session;
    this._notify = notify;
    this._scope = null;
    this._loading = null;
    this._early = null;
    this._newest = 0;
    this._zero = undefined;
    this.texts = []; // the traces
    this.columns = []; // names of the ring's columns behind that of time
    this.units = new Map();
    this.ring = null;
    this.cycle = 0.001;
    this.step = null; // seconds between rows, as the server gives it
    this.lookBack = KEPT;
    this.trigger = null;
    this.record = false;
    this.wanted = false; // should it run
    this.state = "idle";
    this.dropped = 0;
    session.on("block", (buffer) => this._take(buffer));
    session.on("scope", ({ scope, text }) => {
      if (scope === this._scope) notify("error", new Error(text));
    });
    session.on("state", ({ state }) => {
      if (state === "lost") this._gone();
      else if (state === "open" && this.wanted) this.start();
    });
    session.on("connection", ({ state }) => {
      if (state === "back" && this.wanted && this._scope === null) this.start();
    });
  }

  get scope() {
    return this._scope;
  }

  get running() {
    return this.state === "running" || this.state === "starting";
  }

  /** Other traces: what is kept of those that stay is shown on. */
  choose(texts) {
    const before = sources(this.texts).join(" ");
    this.texts = [...texts];
    this._layout();
    if (this.wanted && sources(texts).join(" ") !== before) this.start();
  }

  /** Run with what is chosen now; what was run before ends. */
  async start() {
    this.wanted = true;
    const request = ++this._newest;
    await this._end();
    const channels = sources(this.texts);
    if (channels.length === 0) {
      this._become("idle");
      return;
    }
    this._become("starting");
    try {
      const answer = await this._session.call("scope.start", {
        channels, cycle: this.cycle, record: this.record,
        ...(this.trigger ? { trigger: this.trigger } : {}),
      });
      if (request !== this._newest) {
        this._session.call("scope.stop", { scope: answer.scope }).catch(() => {});
        return;
      }
      this._scope = answer.scope;
      this.step = answer.cycle;
      if (answer.time_zero !== this._zero) this.ring = null; // another server: times begin again
      this._zero = answer.time_zero;
      this._learn(answer.channels);
      this._layout();
      this.ring?.gap();
      this._become("running");
    } catch (error) {
      if (request !== this._newest) return;
      this.wanted = false;
      this._become("idle");
      this._notify("error", error);
    }
  }

  async stop() {
    this.wanted = false;
    this._newest += 1;
    await this._end();
    this._become("idle");
  }

  /** A recording of the server in place of what is kept. Gives {ring, columns, trigger}. */
  async load(name) {
    this._early = [];
    const answer = await this._session.call("scope.load", { name }).catch((error) => {
      this._early = null;
      throw error;
    });
    const columns = answer.channels.map((channel) => channel.name);
    const ring = new Ring(columns.length + 1,
      Math.floor(MOST_VALUES / 2 / (columns.length + 1)));
    return new Promise((resolve) => {
      this._loading = { scope: answer.scope, ring, resolve: () => {
        this._learn(answer.channels);
        resolve({ ring, columns, trigger: answer.trigger ?? null, step: answer.cycle });
      } };
      const early = this._early;
      this._early = null;
      for (const block of early) this._sort(block);
    });
  }

  /** Show these samples as they are: a recording. */
  show({ ring, columns, step }) {
    this.texts = [...columns];
    this.columns = [...columns];
    this.step = step;
    this.ring = ring;
    this._notify("samples");
  }

  /** Which column of the ring a trace has; -1 without one. */
  column(text) {
    const found = this.columns.indexOf(text);
    return found < 0 ? -1 : found + 1;
  }

  unit(text) {
    return unitOf(text, this.units);
  }

  _learn(channels) {
    for (const { name, unit } of channels) this.units.set(name, unit ?? "");
  }

  /** The ring for these traces: its columns are the channels, then what is derived of them. */
  _layout() {
    const names = sources(this.texts);
    const columns = [...names, ...this.texts.filter((text) => parse(text).kind !== "channel")];
    const step = this.step ?? this.cycle;
    const rows = Math.max(Math.min(
      Math.ceil(this.lookBack / step), Math.floor(MOST_VALUES / 2 / (columns.length + 1)),
    ), 1000);
    if (this.ring === null) this.ring = new Ring(columns.length + 1, rows);
    else if (columns.join("\n") !== this.columns.join("\n") || rows > this.ring.capacity) {
      const from = columns.map((name) => this.column(name));
      this.ring = this.ring.rebuilt([0, ...from], rows);
      this._fillDerived(columns, names.length);
    }
    this.columns = columns;
  }

  /** Columns that are derived of what was there already. */
  _fillDerived(columns, first) {
    const { ring } = this;
    const part = (n) => ring.part(n, ring.start, ring.end);
    for (let n = first; n < columns.length; n += 1) {
      part(n + 1).set(derive(columns[n], part(0), (name) => part(columns.indexOf(name) + 1)));
    }
  }

  _take(buffer) {
    const block = decode(buffer);
    if (block !== null) this._sort(block);
  }

  _sort(block) {
    if (this._loading && block.scope === this._loading.scope) {
      const { ring, resolve } = this._loading;
      if (block.rows) ring.append(block.columns);
      if (block.end) {
        this._loading = null;
        resolve();
      }
      return;
    }
    if (this._scope === null || block.scope !== this._scope) {
      this._early?.push(block); // of a recording whose answer is on its way
      return;
    }
    this.dropped = block.dropped;
    if (block.gap) this.ring.gap();
    if (block.rows) this._append(block.columns);
    if (block.trigger) this._notify("trigger", block.columns[0][0]);
    if (block.end) this._gone();
    this._notify("samples");
  }

  _append(columns) {
    const names = this.columns;
    const first = columns.length - 1;
    if (first > names.length) return;
    const of = (name) => columns[names.indexOf(name) + 1];
    const { ring } = this;
    for (let n = first; n < names.length; n += 1) {
      const source = names.indexOf(parse(names[n]).names[0]) + 1;
      const before = ring.size
        ? [ring.last, ring.columns[source][ring.end - 1]] : null;
      columns.push(derive(names[n], columns[0], of, before));
    }
    ring.append(columns);
  }

  async _end() {
    const scope = this._scope;
    this._scope = null;
    if (scope !== null) await this._session.call("scope.stop", { scope }).catch(() => {});
  }

  _gone() {
    this._scope = null;
    this._become("idle");
  }

  _become(state) {
    this.state = state;
    this._notify("state");
  }
}
