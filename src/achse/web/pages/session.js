/**
 * What a page gets, one for each time that it is opened: the target, calls, watches, the view, and ways to tell the user something.
 *
 * - `session.hello`: {version, target, name, control, features, time, speed}
 * - `session.control`: may this page change things
 * - `session.call(name, values)`: a promise of the result
 * - `session.do(name, values, done)`: the same for a button: a refusal is shown, `done` is said
 * - `session.watch(topic, values, receive)`: values as they come; ends with the page
 * - `session.draw(topic, values, draw)`: the same for states: the newest value once a frame, nothing
 *   while the tab is hidden
 * - `session.on(event, listener)`: "state", "connection", "block" (samples); ends with the page
 * - `session.every`: seconds between two values that move: 0.1, or 0.25 for reduced motion
 * - `session.view`: get, set, go (view.js)
 * - `session.say(text)`, `session.fail(error)`: a quiet line; a message that stays until closed;
 *   `fail` gives the function that closes it
 */
export class Session {
  constructor(connection, view, { say, fail }) {
    this._connection = connection;
    this._ends = new Set();
    this._left = false;
    this.view = view;
    this.say = say;
    this.fail = fail;
  }

  get hello() {
    return this._connection.hello ?? { name: "", control: false, features: [] };
  }

  get control() {
    return this.hello.control === true;
  }

  get every() {
    return globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches ? 0.25 : 0.1;
  }

  has(feature) {
    return this.hello.features.includes(feature);
  }

  call(name, values = {}) {
    return this._connection.call(name, values);
  }

  async do(name, values, done = "") {
    try {
      const result = await this._connection.call(name, values);
      if (done) this.say(done);
      return result;
    } catch (error) {
      if (!this._left) this.fail(error);
      return undefined;
    }
  }

  /** Without `failed` a refusal is shown until a value comes again. */
  watch(topic, values, receive, failed = null) {
    if (this._left) return () => {};
    let close = () => {};
    const tell = failed ?? ((error) => {
      close();
      close = this.fail(error);
    });
    return this._keep(this._connection.watch(topic, values, (value, lost) => {
      close();
      close = () => {};
      receive(value, lost);
    }, tell));
  }

  draw(topic, values, draw, frame = (run) => requestAnimationFrame(run)) {
    let due = false;
    let newest = null;
    return this.watch(topic, values, (value) => {
      newest = value;
      if (due) return;
      due = true;
      frame(() => {
        due = false;
        if (!this._left) draw(newest);
      });
    });
  }

  on(event, listener) {
    if (this._left) return () => {};
    return this._keep(this._connection.on(event, listener));
  }

  /** End all that the page which is left has begun. */
  leave() {
    this._left = true;
    for (const end of this._ends) end();
    this._ends.clear();
  }

  _keep(end) {
    this._ends.add(end);
    return () => {
      this._ends.delete(end);
      end();
    };
  }
}
