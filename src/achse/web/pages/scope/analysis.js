import { field, h, mark, panel } from "../dom.js";
import uPlot from "../vendor/uPlot.js";
import { decimate } from "./decimate.js";
import { parse, title } from "./derive.js";
import { spectrum } from "./fft.js";

const PAUSE = { fft: 250, xy: 50 }; // ms between two pictures

/** What is made of traces: derived ones, a spectrum, one over the other. */
export class Analysis {
  constructor(session, colours, { add, changed, again }) {
    this._colours = colours;
    this._view = session.view;
    this._again = again;
    this._plots = new Map();
    this._last = 0;
    this._one = h("select", { "aria-label": "First channel" });
    this._two = h("select", { "aria-label": "Second channel" });
    this._kind = h("select", { "aria-label": "What to draw of them" },
      [["", "nothing more"], ["fft", "spectrum of the first"], ["xy", "second over first"]]
        .map(([value, text]) => h("option", { value }, text)));
    this._kind.value = ["fft", "xy"].includes(this._view.get("more")) ? this._view.get("more") : "";
    this._wanted = [this._view.get("first"), this._view.get("second")];
    const button = (text, run) => {
      const each = h("button", { type: "button" }, text);
      each.addEventListener("click", run);
      return each;
    };
    this._makes = [button("Add derivative", () => add(`rate ${this._one.value}`)),
      button("Add difference", () => add(`diff ${this._one.value} ${this._two.value}`))];
    this._place = h("div", { class: "chart" });
    this.element = panel("Analyse", h("div", { class: "row" },
      field("First", this._one), field("Second", this._two),
      this._makes, field("Draw", this._kind)), this._place);
    for (const each of [this._one, this._two, this._kind]) {
      each.addEventListener("change", () => {
        this._wanted = [this._one.value, this._two.value];
        this._view.set({ more: this._kind.value,
          ...(this._kind.value ? { first: this._one.value, second: this._two.value } : {}) });
        this._last = 0;
        changed();
      });
    }
  }

  /** The traces that there are. */
  offer(texts) {
    const names = texts.filter((text) => parse(text).kind === "channel");
    [this._one, this._two].forEach((select, n) => {
      select.replaceChildren(...names.map((name) => h("option", { value: name }, name)));
      const wanted = this._wanted[n];
      select.value = names.includes(wanted) ? wanted : (names[n] ?? names[0] ?? "");
    });
    for (const each of [this._one, this._two, this._kind, ...this._makes]) each.disabled = names.length === 0;
  }

  destroy() {
    clearTimeout(this._later);
    this._plot?.destroy();
  }

  /** From the rows that are seen. */
  draw({ recorder, from, to }) {
    const kind = this._kind.value;
    const [one, two] = [this._one.value, this._two.value];
    this._place.hidden = kind === "";
    if (kind === "" || recorder.column(one) < 0 || recorder.column(two) < 0) return;
    const now = performance.now();
    const { ring } = recorder;
    if (now - this._last < PAUSE[kind]) {
      clearTimeout(this._later);
      this._later = setTimeout(this._again, PAUSE[kind]);
      return;
    }
    const rows = [kind, one, two, ring.total - (ring.end - from), to - from,
      this._place.clientWidth, this._colours.dark].join();
    if (ring === this._ring && rows === this._rows) return;
    [this._ring, this._rows] = [ring, rows];
    this._last = now;
    const part = (name) => recorder.ring.part(recorder.column(name), from, to);
    if (kind === "fft") {
      const unit = recorder.unit(one);
      this._show(kind, `Spectrum of ${title(one)}`, "frequency in Hz",
        `amplitude${unit ? ` in ${unit}` : ""}`, spectrum(part(one), recorder.step ?? 0));
    } else {
      const [x, y] = decimate([part(one), part(two)], 2000);
      this._show(kind, `${title(two)} over ${title(one)}`, axisText(one, recorder),
        axisText(two, recorder), [x, y]);
    }
  }

  _show(kind, name, across, up, [x, y]) {
    const key = JSON.stringify([kind, name, across, up, this._place.clientWidth, this._colours.dark]);
    if (key !== this._key) {
      this._key = key;
      this._plot?.destroy();
      this._plot = this._make(kind, across, up);
      mark(this._plot.ctx.canvas, "role", "img");
      mark(this._plot.ctx.canvas, "aria-label", `${name}: ${up}, ${across}`);
    }
    if (kind === "fft") this._plot.setData([x, y]);
    else this._plot.setData([null, [x, y]]);
  }

  _make(kind, across, up) {
    const colours = this._colours;
    const grid = { stroke: colours.line, width: 1 };
    const font = "12px system-ui, sans-serif";
    const axis = { stroke: colours.dim, grid, ticks: grid, font, labelFont: font, labelSize: 18 };
    const common = {
      width: Math.max(this._place.clientWidth, 100), height: 260, legend: { show: false },
      cursor: { drag: { x: kind === "fft", y: false } },
      axes: [{ ...axis, label: across }, { ...axis, label: up, size: 60 }],
    };
    const look = { stroke: colours.trace(0), width: 1.5, points: { show: false } };
    if (kind === "fft") {
      return new uPlot({ ...common, scales: { x: { time: false } },
        series: [{}, look] }, [[], []], this._place);
    }
    return new uPlot({
      ...common, mode: 2,
      scales: { x: { time: false, auto: true, range: roomy }, y: { auto: true, range: roomy } },
      series: [{}, { ...look, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
        paths: (plot, n) => line(plot, plot.data[n]) }],
    }, [null, [[], []]], this._place);
  }
}

function axisText(name, recorder) {
  const unit = recorder.unit(name);
  return unit ? `${name} in ${unit}` : name;
}

function roomy(_, low, high) {
  if (low === null || high === null) return [0, 1];
  const room = Math.max(0.05 * (high - low), 1e-9);
  return [low - room, high + room];
}

/** One value over the other, in the order of time; a break where one of them is missing. */
function line(plot, [x, y]) {
  const stroke = new Path2D();
  let drawing = false;
  for (let n = 0; n < x.length; n += 1) {
    if (x[n] === null || y[n] === null) {
      drawing = false;
      continue;
    }
    const [left, top] = [plot.valToPos(x[n], "x", true), plot.valToPos(y[n], "y", true)];
    if (drawing) stroke.lineTo(left, top);
    else stroke.moveTo(left, top);
    drawing = true;
  }
  return { stroke, fill: null, clip: null, band: null, gaps: null, flags: 0 };
}
