/**
 * Scope: channels over time in one or several charts, live or from a recording.
 *
 * Samples go into a ring (scope/ring.js) as they come; the picture is drawn only in a frame, and
 * of it only what is another than before. The numbers follow some times a second, and at once what
 * somebody did. The address holds what is shown.
 */

import { field, h, mark, show, typing } from "./dom.js";
import { number } from "./format.js";
import { singleKeys, withModifier } from "./keys.js";
import { requestedTrigger, tracesOf, tracesText, triggerOf, triggerText } from "./scope/address.js";
import { Analysis } from "./scope/analysis.js";
import { Chart } from "./scope/chart.js";
import { Colours, probe, useStyle } from "./scope/colours.js";
import { title } from "./scope/derive.js";
import { csv, follow, picture, save } from "./scope/export.js";
import { Finder } from "./scope/find.js";
import { Readout } from "./scope/readout.js";
import { Recorder } from "./scope/recorder.js";
import { Recordings } from "./scope/recordings.js";
import { Roll } from "./scope/roll.js";
import { Span } from "./scope/span.js";
import { Starts } from "./scope/starts.js";
import { TriggerForm } from "./scope/trigger.js";

const WIDTHS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120];
const CYCLES = [0.0001, 0.00025, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 1];
const SLOW_FRAME = 250; // ms between pictures for people who want less motion
const STOP = "Stop";
const NUMBERS = 200; // ms between numbers without a request

export function mount(element, session) {
  const page = new ScopePage(element, session);
  return () => page.leave();
}

class ScopePage {
  constructor(element, session) {
    this._session = session;
    const { view } = session;
    this._traces = tracesOf(view.get("traces"));
    this._span = new Span(nearest(WIDTHS, Number(view.get("width")), 5));
    this._cursors = [null, null];
    this._active = 0;
    this._earlier = null;
    this._charts = new Map();
    this._fired = null;
    this._pending = null;
    this._roll = new Roll();
    this._plan = null;
    this._width = 0;
    this._due = false;
    this._drawn = this._spoken = 0;
    this._left = false;

    this._still = matchMedia("(prefers-reduced-motion: reduce)");
    useStyle();
    this._probe = probe();
    this._place = h("div", { class: "charts" });
    element.append(this._probe);
    this._colours = new Colours(this._probe);
    this._recorder = new Recorder(session, (what, value) => this._notify(what, value));
    this._recorder.cycle = nearest(CYCLES, Number(view.get("cycle")), 0.001);
    this._form = new TriggerForm(triggerOf(view.get("trigger")), () => this._retrigger());
    this._finder = new Finder(session, {
      add: (text, chart) => this.add(text, chart),
      last: () => Math.max(0, ...this._traces.map(({ chart }) => chart)),
    });
    this._starts = new Starts(session, (traces) => {
      this._change(traces);
      if (!this._recorder.running) this.run();
    });
    this._readout = new Readout({
      colours: this._colours, remove: (text) => this._change(this._traces.filter((t) => t.text !== text)),
      place: (text, chart) => this._change(
        this._traces.map((each) => (each.text === text ? { text, chart } : each))),
    });
    this._recordings = new Recordings(session, this._recorder, {
      open: (recording) => this._open(recording), hold: (held) => this._hold(held),
      drop: () => this._hold(null), now: () => this._snapshot(),
    });
    this._analysis = new Analysis(session, this._colours, {
      add: (text) => this.add(text, 1 + Math.max(0, ...this._traces.map(({ chart }) => chart))),
      changed: () => this.dirty(), again: () => this._frame(),
    });
    element.append(this._finder.element, this._bar(),
      h("div", { class: "panel", id: "scope-charts" }, this._state, this._starts.element, this._place), this._readoutPanel(),
      this._recordings.element, this._analysis.element);
    this._listen();
    this._offer();
    this._recorder.lookBack = this._lookBack();
    this._recorder.trigger = requestedTrigger(this._form.value);
    this._recorder.choose(this._traces.map(({ text }) => text));
    if (this._traces.length) this._recorder.start();
    this.dirty();
  }

  leave() {
    this._left = true;
    this._recorder.stop();
    this._finder.destroy();
    this._analysis.destroy();
    for (const chart of this._charts.values()) chart.destroy();
    clearTimeout(this._later);
    clearTimeout(this._numbers);
    for (const end of this._ends) end();
  }

  // what is shown -----------------------------------------------------------------------------

  add(text, chart = 1) {
    if (this._traces.some((each) => each.text === text)) {
      this._session.say(`${title(text)} is there already.`);
      return;
    }
    const before = this._traces.length;
    this._change([...this._traces, { text, chart: Math.min(chart, 8) }]);
    this._session.say(`${title(text)} added.`);
    if (before === 0 && !this._recorder.running) this.run();
  }

  run() {
    if (this._recordings.shown) {
      this._recordings.close();
      this._recorder.ring = null;
      this._recorder.columns = [];
      this._recorder.choose(this._traces.map(({ text }) => text));
    }
    this._span.follow();
    this._roll = new Roll();
    this._fired = this._pending = null;
    this._recorder.start();
  }

  /** Do what the button says, also when the recording has just ended by itself. */
  _toggle() {
    if (this._runs.textContent === STOP) this._recorder.stop().then(() => this._recordings.refresh());
    else this.run();
  }

  _change(traces) {
    this._traces = traces;
    this._session.view.set({ traces: tracesText(traces) });
    this._offer();
    this._recorder.trigger = requestedTrigger(this._form.value);
    if (!this._recordings.shown) this._recorder.choose(traces.map(({ text }) => text));
    this.dirty();
  }

  _offer() {
    const texts = this._traces.map(({ text }) => text);
    this._form.offer(texts);
    this._finder.refresh();
    this._analysis.offer(texts);
  }

  _retrigger() {
    this._session.view.set({ trigger: triggerText(this._form.value) });
    this._fired = this._pending = null;
    const before = this._recorder.trigger;
    this._recorder.trigger = requestedTrigger(this._form.value);
    if (this._recorder.wanted && (before || this._recorder.trigger)) {
      this._span.follow();
      this._recorder.start();
    }
    this.dirty();
  }

  _open(recording) {
    this._recorder.stop();
    this._recorder.show(recording);
    const known = new Map(this._traces.map(({ text, chart }) => [text, chart]));
    this._traces = recording.columns.map((text) => ({ text, chart: known.get(text) ?? 1 }));
    this._offer();
    this._roll = new Roll();
    this._fired = recording.trigger;
    this._span.fix([recording.ring.first, recording.ring.last]);
    this.dirty();
  }

  /** The rows that are seen now, to compare with. */
  _snapshot() {
    const { ring, columns } = this._recorder;
    if (!ring?.size) return null;
    const [from, to] = this._places();
    return { times: ring.part(0, from, to).slice(), anchor: this._fired ?? this._edge,
      values: new Map(columns.map((name, n) => [name, ring.part(n + 1, from, to).slice()])) };
  }

  _hold(held) {
    this._earlier = held;
    this._recordings.holds = held !== null;
    this.dirty();
  }

  _notify(what, value) {
    if (this._left) return;
    if (what === "error") this._session.fail(value);
    if (what === "trigger" && this._form.value.mode !== "off") this._trigger(value);
    if (what === "samples") {
      this._captured();
      this._frame();
    } else {
      this._say();
      this.dirty();
    }
  }

  /** A trigger counts when the picture of the one before it is whole. */
  _trigger(time) {
    if (this._pending === null) this._pending = time;
  }

  _captured() {
    const time = this._pending;
    if (time === null) return;
    const range = this._span.about(time, this._form.value.before);
    if (this._recorder.ring.last < range[1]) return;
    this._pending = null;
    this._fired = time;
    this._span.fix(range);
    if (this._form.value.mode === "single") this._recorder.stop();
  }

  _lookBack() {
    return Math.max(120, 3 * this._span.width);
  }

  // the picture -------------------------------------------------------------------------------

  /** Something is another than before: draw in the next frame, numbers and all. */
  dirty() {
    this._plan = null;
    this._frame();
  }

  /** There are new samples: draw in the next frame. A tab that is hidden has none. */
  _frame() {
    if (this._due || this._left) return;
    this._due = true;
    const draw = () => requestAnimationFrame((now) => {
      this._due = false;
      this._drawn = now;
      if (!this._left) this._draw(now);
    });
    const wait = this._still.matches ? this._drawn + SLOW_FRAME - performance.now() : 0;
    if (wait > 0) this._later = setTimeout(draw, wait);
    else draw();
  }

  /** The right edge of a picture that follows. */
  get _edge() {
    return this._roll.edge ?? this._recorder.ring?.last ?? 0;
  }

  _places() {
    const { ring } = this._recorder;
    const [from, to] = this._span.at(this._edge);
    return [Math.max(ring.find(from) - 1, ring.start), Math.min(ring.find(to) + 1, ring.end)];
  }

  _draw(now) {
    const { ring } = this._recorder;
    const isMissing = this._plan === null;
    if (isMissing) this._plan = this._planned();
    if (ring?.size) {
      if (!this._span.fixed) {
        const edge = this._roll.step(ring.last, now, this._span.width, !this._still.matches);
        if (edge < ring.last) this._frame();
      }
      const range = this._span.at(this._edge);
      for (const each of this._plan) this._drawChart(each, range, ring);
      const [from, to] = this._places();
      this._analysis.draw({ recorder: this._recorder, from, to });
    }
    if (isMissing || now - this._spoken >= NUMBERS) {
      clearTimeout(this._numbers);
      this._numbers = null;
      this._spoken = now;
      this._say();
      this._drawReadout();
    } else {
      this._numbers ??= setTimeout(() => this.dirty(), NUMBERS); // these may be the last samples
    }
  }

  /** Which traces are drawn where: made again when somebody or the server changed something. */
  _planned() {
    const recorder = this._recorder;
    const wanted = [...new Set(this._traces.map(({ chart }) => chart))].sort((a, b) => a - b);
    for (const [n, chart] of this._charts) {
      if (!wanted.includes(n)) {
        chart.destroy();
        this._charts.delete(n);
      }
    }
    this._width ||= this._place.clientWidth;
    const height = Math.max(Math.min(Math.round(innerHeight * 0.6 / wanted.length), 420), 150);
    return wanted.map((n) => {
      const live = this._traces.map((trace, order) => ({ ...trace, order }))
        .filter(({ text, chart }) => chart === n && recorder.column(text) > 0);
      const drawn = live.map(({ text, order }) =>
        ({ title: title(text), unit: recorder.unit(text), number: order, held: false }));
      const held = live.map(({ text }) => this._earlier?.values.get(text));
      return { n, height, columns: live.map(({ text }) => recorder.column(text)),
        traces: [...drawn, ...drawn.filter((_, at) => held[at])
          .map((each) => ({ ...each, title: `${each.title}, held`, held: true }))],
        held: this._earlier && { times: this._earlier.times, begin: 0, end: this._earlier.times.length,
          columns: held.filter(Boolean) } };
    });
  }

  _drawChart({ n, height, columns, traces, held }, range, ring) {
    const chart = this._charts.get(n) ?? this._newChart(n);
    chart.cursors = this._cursors;
    chart.trigger = this._fired;
    chart.draw(traces, { times: ring.columns[0], begin: ring.start, end: ring.end,
      columns: columns.map((column) => ring.columns[column]) }, range, { width: this._width, height, held,
      shift: held ? (this._fired ?? this._edge) - this._earlier.anchor : 0 });
  }

  _newChart(n) {
    const chart = new Chart(this._place, this._colours, (what, value) => this._used(what, value));
    this._charts.set(n, chart);
    const order = [...this._charts.keys()].sort((a, b) => a - b);
    for (const each of order) this._place.append(this._charts.get(each).element);
    return chart;
  }

  _drawReadout() {
    const { ring } = this._recorder;
    const at = (column, time) =>
      (time === null || column < 0 || !ring ? null : ring.at(column, time));
    const rows = this._traces.map(({ text, chart }, order) => {
      const column = this._recorder.column(text);
      const last = column > 0 && ring?.size ? ring.columns[column][ring.end - 1] : null;
      return { text, title: title(text), unit: this._recorder.unit(text), chart, number: order,
        last, a: at(column, this._cursors[0]), b: at(column, this._cursors[1]) };
    });
    this._readout.update(rows, [ring?.last ?? null, ...this._cursors]);
    this._table.hidden = rows.length === 0;
    this._place.hidden = rows.length === 0;
    this._starts.show(rows.length === 0);
  }

  _say() {
    const { state, wanted, dropped, scope } = this._recorder;
    const { mode } = this._form.value;
    const words = this._traces.length === 0 ? "Nothing is recorded yet: search above, Enter adds a channel."
      : this._recordings.shown ? `Recording: ${this._recordings.shown}`
        : state === "starting" ? "Starting…"
          : state === "running" ? ["Running", mode === "off" ? "" : this._fired === null
            ? "waiting for the trigger" : `triggered at ${number(this._fired, 6)} s`,
          this._span.fixed && mode === "off" ? "view stands still (Esc follows)" : "",
          dropped ? `${dropped} blocks were dropped` : ""].filter(Boolean).join(", ")
            : wanted ? "Waiting for the station"
              : `Stopped${this._fired === null || mode === "off" ? "" : ` by the trigger at ${number(this._fired, 6)} s`}`;
    show(this._state, words);
    this._state.dataset.state = state;
    show(this._runs, wanted ? STOP : "Run");
    this._runs.disabled = !wanted && this._traces.length === 0;
    this._export.disabled = scope === null && !this._recordings.shown;
    const size = this._recorder.ring?.size ?? 0;
    for (const each of this._saves) each.disabled = size === 0;
    mark(this._follows, "aria-pressed", String(!this._span.fixed));
    this._clears.disabled = !this._span.fixed && this._cursors.every((each) => each === null);
  }

  // what a user does --------------------------------------------------------------------------

  _used(what, value) {
    const last = this._edge;
    if (what === "zoom") this._span.fix(value);
    else if (what === "wheel") this._span.zoom(value.factor, value.at, last);
    else if (what === "pan") this._span.pan(value, last);
    else if (what === "reset") this._follow();
    else if (what === "cursor") this._cursors[this._active] = value;
    this.dirty();
  }

  _follow() {
    this._span.follow();
    const { ring } = this._recorder;
    if (this._recordings.shown && ring?.size) this._span.fix([ring.first, ring.last]);
    this.dirty();
  }

  /** Arrows: the cursor by a hundredth of what is seen, with Shift by one row. */
  _step(way, fine) {
    const { ring, step } = this._recorder;
    if (!ring?.size) return;
    const [from, to] = this._span.at(this._edge);
    if (!this._span.fixed) this._span.fix([from, to]);
    const now = this._cursors[this._active] ?? (from + to) / 2;
    const next = now + way * (fine && step ? step : (to - from) / 100);
    this._cursors[this._active] = Math.min(Math.max(next, from), to);
    this.dirty();
  }

  _pressed(event) {
    if (withModifier(event) || typing(event.target)) return;
    if (document.querySelector("dialog[open]")) return;
    const button = event.target instanceof HTMLElement && event.target.closest("button, a, summary");
    const keys = {
      " ": () => !button && (this._toggle(), true),
      t: () => this._form.toggle(),
      c: () => this._choose(1 - this._active),
      ArrowLeft: () => this._step(-1, event.shiftKey),
      ArrowRight: () => this._step(1, event.shiftKey),
      "+": () => this._used("wheel", { at: 0.5, factor: 0.5 }),
      "-": () => this._used("wheel", { at: 0.5, factor: 2 }),
      Escape: () => this._escape(),
    };
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key; // with Caps Lock too
    const run = keys[key];
    if (run === undefined || event.defaultPrevented) return;
    if (key.length === 1 && key !== " " && !singleKeys()) return;
    if (run() !== false) event.preventDefault();
  }

  _escape() {
    this._cursors = [null, null];
    this._follow();
  }

  _choose(number) {
    this._active = number;
    this._cursorButtons.forEach((each, n) => mark(each, "aria-pressed", String(n === number)));
  }

  async _csv() {
    const { ring } = this._recorder;
    if (!ring?.size) return;
    const [from, to] = this._places();
    const texts = this._traces.filter(({ text }) => this._recorder.column(text) > 0);
    const titles = texts.map(({ text }) => {
      const unit = this._recorder.unit(text);
      return unit ? `${title(text)} in ${unit}` : title(text);
    });
    save("scope.csv", new Blob([csv(ring, titles,
      texts.map(({ text }) => this._recorder.column(text)), from, to)], { type: "text/csv" }));
  }

  async _csvOfAll() {
    const { scope } = this._recorder;
    const of = this._recordings.shown ? { name: this._recordings.shown } : { scope };
    const path = await this._session.do("scope.export", { ...of, format: "csv" });
    if (path) follow(path);
  }

  async _png() {
    const all = [...this._charts.keys()].sort((a, b) => a - b)
      .map((n) => this._charts.get(n).canvas).filter(Boolean);
    if (all.length) save("scope.png", await picture(all, this._colours.ground));
  }

  // elements ----------------------------------------------------------------------------------

  _bar() {
    const button = (text, run, values = {}) => {
      const each = h("button", { type: "button", ...values }, text);
      each.addEventListener("click", run);
      return each;
    };
    const select = (label, options, value, changed) => {
      const each = h("select", { "aria-label": label },
        options.map(([key, text]) => h("option", { value: key }, text)));
      each.value = String(value);
      each.addEventListener("change", () => changed(Number(each.value)));
      return each;
    };
    this._state = h("p", { class: "dim", role: "status", id: "scope-state" });
    this._runs = button("Run", () => this._toggle(), { class: "main", "aria-keyshortcuts": "Space" });
    this._export = button("CSV of all", () => this._csvOfAll(),
      { title: "What the server keeps: the last 16 MB" });
    const width = select("Seconds that are seen", WIDTHS.map((s) => [s, `${s} s`]),
      this._span.width, (value) => {
        this._span.width = value;
        this._recorder.lookBack = this._lookBack();
        this._session.view.set({ width: value });
        this._follow();
      });
    const cycle = select("Time between samples", CYCLES.map((s) => [s, `${Number((1e3 * s).toFixed(3))} ms`]),
      this._recorder.cycle, (value) => {
        this._recorder.cycle = value;
        this._session.view.set({ cycle: value });
        if (this._recorder.wanted) this._recorder.start();
      });
    const zoom = (text, label, run) => button(text, run, { class: "small", "aria-label": label });
    this._cursorButtons = ["A", "B"].map((name, n) => button(name, () => this._choose(n),
      { class: "small", "aria-label": `Cursor ${name}`, "aria-pressed": n === 0 ? "true" : "false" }));
    this._follows = zoom("Follow", "Follow the newest samples", () => this._follow());
    this._clears = zoom("Clear", "Clear the cursors", () => this._escape());
    this._saves = [button("CSV", () => this._csv(), { title: "What is seen" }),
      button("PNG", () => this._png())];
    return h("div", { class: "panel" },
      h("div", { class: "row" }, this._runs, field("Window", width), field("Cycle", cycle),
        zoom("−", "Zoom out", () => this._used("wheel", { at: 0.5, factor: 2 })),
        zoom("+", "Zoom in", () => this._used("wheel", { at: 0.5, factor: 0.5 })),
        zoom("◀", "Earlier", () => this._used("pan", -0.25)),
        zoom("▶", "Later", () => this._used("pan", 0.25)),
        this._follows,
        h("span", { class: "dim" }, "Cursor"), this._cursorButtons,
        this._clears, this._saves[0], this._export, this._saves[1]),
      this._form.element);
  }

  _readoutPanel() {
    this._table = h("div", { class: "panel" }, this._readout.element,
      h("p", { class: "dim" }, "Drag: zoom. Wheel: zoom. Shift and drag: pan. Click: cursor. Keys: "
        + "Space run and stop, T trigger, arrows cursor (Shift: one row), C the other cursor, "
        + "+ and − zoom, Esc follow."));
    return this._table;
  }

  _listen() {
    const pressed = (event) => this._pressed(event);
    const changed = () => {
      for (const chart of this._charts.values()) chart.resize();
      this.dirty();
    };
    const size = new ResizeObserver(() => {
      this._width = this._place.clientWidth;
      this.dirty();
    });
    addEventListener("keydown", pressed);
    size.observe(this._place);
    this._ends = [
      () => removeEventListener("keydown", pressed),
      this._colours.follow(changed),
      () => size.disconnect(),
    ];
  }
}

function nearest(choices, value, otherwise) {
  return choices.includes(value) ? value : otherwise;
}
