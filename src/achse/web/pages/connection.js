/**
 * The WebSocket to the server: calls with answers, watches that outlive a lost connection, blocks
 * of samples. It dials again by itself; everybody who listens sees the state.
 */

const FIRST_PAUSE = 250;
const LONGEST_PAUSE = 5_000;
const ANSWER_WITHIN = 20_000;

/** What the target or the server refused, with the code and a link to its explanation. */
export class Refusal extends Error {
  constructor({ text, code = null, name = null, link = null }) {
    super(text);
    this.name = "Refusal";
    this.code = code;
    this.codeName = name;
    this.link = link;
  }
}

/** A call that has no answer because the connection is not there. */
export class NotConnected extends Error {
  constructor(text = "Not connected to the station: nothing was sent.") {
    super(text);
    this.name = "NotConnected";
  }
}

export class Connection {
  /**
   * @param {string} url of the WebSocket
   * @param {{dial?: (url: string) => WebSocket, clock?: {setTimeout: Function,
   *   clearTimeout: Function}}} means replaced in tests
   */
  constructor(url, means = {}) {
    this._url = url;
    this._dial = means.dial ?? ((address) => new WebSocket(address));
    this._clock = means.clock ?? {
      setTimeout: (...args) => globalThis.setTimeout(...args),
      clearTimeout: (number) => globalThis.clearTimeout(number),
    };
    this._socket = null;
    this._number = 0;
    this._pending = new Map();
    this._watches = new Set();
    this._byNumber = new Map();
    this._early = new Map();
    this._last = 0;
    this._listeners = new Map();
    this._pause = FIRST_PAUSE;
    this._retry = null;
    this.state = "closed";
    this.hello = null;
  }

  /** Dial, and dial again until `close`. */
  open() {
    if (this._socket !== null) return;
    this._tell("connecting");
    const socket = this._dial(this._url);
    socket.binaryType = "arraybuffer";
    this._socket = socket;
    socket.onopen = () => this._greet(socket);
    socket.onmessage = (message) => {
      if (socket === this._socket) this._receive(message.data);
    };
    socket.onclose = (event) => {
      if (socket === this._socket) this._lost(event);
    };
  }

  /** End the connection for good. */
  close() {
    this._clock.clearTimeout(this._retry);
    const socket = this._socket;
    this._socket = null;
    socket?.close(1000);
    this._fail(new NotConnected("The page has ended the connection."));
    this._tell("closed");
  }

  /**
   * Listen: "state" ({state, text}), "hello" (its result), "connection" (of the target), "block"
   * (an ArrayBuffer of samples). Gives the function that ends it.
   */
  on(event, listener) {
    const known = this._listeners.get(event) ?? new Set();
    this._listeners.set(event, known.add(listener));
    return () => known.delete(listener);
  }

  /** Call a service of the server. Rejects with Refusal or NotConnected. */
  call(name, values = {}) {
    return this.state === "open" ? this._call(name, values) : Promise.reject(new NotConnected());
  }

  /**
   * Watch a topic: `receive(value, lost)` is called with each value, `failed(error)` when the
   * server refuses it. After a lost connection the watch goes on. Gives the function that ends it.
   */
  watch(topic, values, receive, failed = () => {}) {
    const watch = { topic, values, receive, failed, number: null, sent: false, ended: false };
    this._watches.add(watch);
    if (this.state === "open") this._begin(watch);
    return () => {
      if (watch.ended) return;
      watch.ended = true;
      this._watches.delete(watch);
      if (watch.number !== null) this._end(watch);
    };
  }

  /** Ask again what the target has; "hello" is emitted with the answer. */
  refresh() {
    const socket = this._socket;
    if (this.state !== "open") return;
    this._call("hello", {}).then((hello) => {
      if (socket !== this._socket) return;
      this.hello = hello;
      this._emit("hello", hello);
    }, () => {}); // the request is repeated soon
  }

  // one connection --------------------------------------------------------------------------

  _greet(socket) {
    this._call("hello", {}).then(
      (hello) => {
        if (socket !== this._socket) return;
        this.hello = hello;
        this._pause = FIRST_PAUSE;
        this._tell("open");
        for (const watch of this._watches) if (!watch.sent) this._begin(watch);
        this._emit("hello", hello);
      },
      (error) => {
        if (socket === this._socket) {
          this._refused = error.message;
          socket.close(4000);
        }
      },
    );
  }

  _call(name, values) {
    const id = ++this._number;
    return new Promise((resolve, reject) => {
      const late = this._clock.setTimeout(() => {
        this._pending.delete(id);
        reject(new Refusal({ text: `${name}: no answer within ${ANSWER_WITHIN / 1000} s.` }));
      }, ANSWER_WITHIN);
      this._pending.set(id, { resolve, reject, late });
      this._socket.send(JSON.stringify({ id, call: name, with: values }));
    });
  }

  _begin(watch) {
    const socket = this._socket;
    watch.sent = true;
    this._call("watch", { topic: watch.topic, ...watch.values }).then(
      (answer) => {
        if (socket !== this._socket) return;
        watch.number = answer.watch;
        this._byNumber.set(watch.number, watch);
        this._last = Math.max(this._last, watch.number);
        const early = this._early.get(watch.number);
        this._early.delete(watch.number);
        if (watch.ended) this._end(watch);
        else if (early) this._show(watch, early);
      },
      (error) => {
        if (!watch.ended && !(error instanceof NotConnected)) watch.failed(error);
      },
    );
  }

  _end(watch) {
    this._byNumber.delete(watch.number);
    if (this.state === "open") this._call("unwatch", { watch: watch.number }).catch(() => {});
  }

  _receive(data) {
    if (typeof data !== "string") {
      this._emit("block", data);
      return;
    }
    const message = JSON.parse(data);
    if (message.event === "data") {
      const watch = this._byNumber.get(message.watch);
      if (watch !== undefined) this._show(watch, message);
      // a value may come before the answer that tells the number of its watch
      else if (message.watch > this._last) this._early.set(message.watch, message);
    } else if (message.event !== undefined) {
      this._emit(message.event, message);
    } else {
      const request = this._pending.get(message.id);
      if (request === undefined) return;
      this._pending.delete(message.id);
      this._clock.clearTimeout(request.late);
      if (message.error) request.reject(new Refusal(message.error));
      else request.resolve(message.result);
    }
  }

  _show(watch, { value, lost, error }) {
    if (watch.ended) return;
    if (error) watch.failed(new Refusal(error));
    else watch.receive(value, lost ?? 0);
  }

  _lost(event) {
    this._socket = null;
    this._byNumber.clear();
    this._early.clear();
    this._last = 0;
    for (const watch of this._watches) Object.assign(watch, { number: null, sent: false });
    this._fail(new NotConnected("The connection was lost before the answer came."));
    const reason = this._refused ?? event?.reason ?? "";
    this._refused = undefined;
    this._tell("lost", reason);
    this._retry = this._clock.setTimeout(() => this.open(), this._pause);
    this._pause = Math.min(2 * this._pause, LONGEST_PAUSE);
  }

  _fail(error) {
    const pending = [...this._pending.values()];
    this._pending.clear();
    for (const { reject, late } of pending) {
      this._clock.clearTimeout(late);
      reject(error);
    }
  }

  _tell(state, text = "") {
    this.state = state;
    this._emit("state", { state, text });
  }

  _emit(event, value) {
    for (const listener of this._listeners.get(event) ?? []) listener(value);
  }
}

/** The server's WebSocket beside this page; a token in the page's address goes along. */
export function addressOf(place = globalThis.location) {
  const secure = place.protocol === "https:" ? "wss:" : "ws:";
  const token = new URLSearchParams(place.search).get("token");
  return `${secure}//${place.host}/ws${token ? `?token=${encodeURIComponent(token)}` : ""}`;
}
