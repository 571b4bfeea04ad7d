/** What several tests of the pages need: the folder of the modules, a socket and a clock by hand. */

export const PAGES = new URL("../../../src/achse/web/pages/", import.meta.url);

/** `await load("format.js")`: a module of the pages, which import each other as the browser does. */
export function load(name) {
  return import(new URL(name, PAGES));
}

/** A WebSocket whose other end is the test. */
export class Socket {
  constructor(url) {
    this.url = url;
    this.sent = [];
    this.closed = null;
  }

  send(text) {
    this.sent.push(JSON.parse(text));
  }

  close(code) {
    this.closed = code;
    this.onclose?.({ code, reason: "" });
  }

  /** The server sends this. */
  say(message) {
    this.onmessage({ data: typeof message === "string" ? message : JSON.stringify(message) });
  }

  /** The server answers the newest call of that name. */
  answer(name, result) {
    const asked = this.sent.filter(({ call }) => call === name).at(-1);
    this.say({ id: asked.id, result });
  }
}

/** Timers that run when the test says so. */
export class Clock {
  constructor() {
    this.now = 0;
    this._due = new Map();
    this._last = 0;
    this.setTimeout = (run, ms) => {
      this._due.set(++this._last, { at: this.now + ms, run });
      return this._last;
    };
    this.clearTimeout = (number) => this._due.delete(number);
  }

  get waiting() {
    return this._due.size;
  }

  pass(ms) {
    const end = this.now + ms;
    for (;;) {
      const next = [...this._due].filter(([, { at }]) => at <= end).sort((a, b) => a[1].at - b[1].at)[0];
      if (next === undefined) break;
      this._due.delete(next[0]);
      this.now = next[1].at;
      next[1].run();
    }
    this.now = end;
  }
}

/** Let what waits for promises run. */
export const settle = () => new Promise((resolve) => setImmediate(resolve));
