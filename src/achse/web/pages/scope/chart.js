import { h, mark } from "../dom.js";
import { number } from "../format.js";
import uPlot from "../vendor/uPlot.js";
import { fitted, kept } from "./scale.js";
import { Strip } from "./strip.js";

/** More traces than these are hairlines. */
const FEW = 3;
const WHEEL = 1.2;
const BESIDE = 60; // pixels that are not the picture's

/**
 * One chart: traces over time. The page gives it the rows that are seen (`draw`) and hears what is
 * done by mouse or finger, if it is to: `notify("zoom", [from, to])`, `("wheel", {at, factor})`, `("pan", part)`,
 * `("cursor", time)`, `("reset")`.
 */
export class Chart {
  constructor(place, colours, notify, numbers = "The numbers are in the table below.") {
    this._numbers = numbers;
    this._colours = colours;
    this._notify = notify;
    this._shape = "";
    this._traces = null;
    this._overlaid = "";
    this._plot = null;
    this._strip = this._held = null;
    this._scales = new Map();
    this.cursors = [null, null];
    this.trigger = null;
    this.element = h("div", { class: "chart" });
    place.append(this.element);
    if (notify !== null) this._listen();
  }

  get pixels() {
    return Math.max(this.element.clientWidth - BESIDE, 50);
  }

  /** Colours or size are others now. */
  resize() {
    this._shape = "";
  }

  /**
   * `traces`: [{title, unit, number, held}], those of `source` first, then those of `held`; a list
   * that is the same object is not looked at again. `source` and `held`: {times, begin, end,
   * columns}; `range`: [from, to] in seconds, that of `held` is `shift` seconds before. Draws only
   * what is another than before; true if it drew.
   */
  draw(traces, source, range, { width, height, held = null, shift = 0 }) {
    if (traces !== this._traces || this._shape === "") {
      const shape = JSON.stringify([traces, width, height, devicePixelRatio, this._colours.dark]);
      if (shape !== this._shape) {
        this._shape = shape;
        this._make(traces, width, height);
      }
      this._traces = traces;
    }
    let other = this._strip.place(source, range);
    const seen = this._strip.grid.range;
    if (this._held !== null) {
      other = this._held.place(held, [seen[0] - shift, seen[1] - shift]) || other;
    }
    const rangeOf = (unit) => this._scales.get(unit);
    for (const unit of this._units) this._fit(unit, other);
    const painted = this._strip.paint(rangeOf);
    const repainted = this._held?.paint(rangeOf) ?? false;
    const overlaid = `${this.cursors} ${this.trigger} ${seen}`;
    if (!painted && !repainted && overlaid === this._overlaid) return false;
    this._overlaid = overlaid;
    this._plot.setScale("x", { min: seen[0], max: seen[1] });
    return true;
  }

  _fit(unit, other) {
    let [low, high] = this._strip.extent(unit);
    const [least, most] = this._held?.extent(unit) ?? [null, null];
    if (least !== null) {
      low = low === null ? least : Math.min(low, least);
      high = high === null ? most : Math.max(high, most);
    }
    const before = this._scales.get(unit) ?? null;
    this._scales.set(unit, other ? fitted(low, high) : kept(before, low, high));
  }

  destroy() {
    this._plot?.destroy();
    this.element.remove();
  }

  /** The picture itself. */
  get canvas() {
    return this._plot?.ctx.canvas ?? null;
  }

  _make(traces, width, height) {
    this._plot?.destroy();
    const colours = this._colours;
    const units = this._units = [...new Set(traces.map(({ unit }) => unit))];
    this._scales.clear();
    const scale = (unit) => `y ${unit}`;
    const grid = { stroke: colours.line, width: 1 };
    const axis = { stroke: colours.dim, grid, ticks: grid, font: "12px system-ui, sans-serif" };
    this._plot = new uPlot({
      width: Math.max(width, 100), height,
      legend: { show: false },
      padding: [10, 12, 0, 0],
      cursor: { y: false, points: { show: false }, drag: { x: this._notify !== null, y: false, setScale: false } },
      select: { show: true, left: 0, top: 0, width: 0, height: 0 },
      scales: { x: { time: false, auto: false },
        ...Object.fromEntries(units.map((unit) =>
          [scale(unit), { range: () => this._scales.get(unit) ?? [0, 1] }])) },
      axes: [
        { ...axis, space: 70, size: 26, values: (_, splits) => splits.map(label) },
        ...units.slice(0, 2).map((unit, n) => ({
          ...axis, scale: scale(unit), side: n ? 1 : 3, size: 56,
          grid: n ? { show: false } : grid, label: unit || " ", labelSize: 18,
          labelFont: axis.font, values: (_, splits) => splits.map(label),
        })),
      ],
      // the lines are not uPlot's: a series of each unit gives it its scale
      series: [{}, ...units.map((unit) => ({ scale: scale(unit), paths: () => null,
        points: { show: false } }))],
      hooks: { draw: [(plot) => this._overlay(plot)], setSelect: [(plot) => this._selected(plot)] },
    }, [[0, 1], ...units.map(() => [null, null])], this.element);
    const { bbox } = this._plot;
    const few = traces.length <= FEW;
    const strip = (held) => {
      const looks = traces.filter((each) => each.held === held).map(({ unit, number: n }) => ({
        unit, colour: colours.trace(n), opacity: held ? 0.7 : 1,
        width: (held || !few ? 1 : 1.5) * devicePixelRatio,
        dash: (held ? [3, 3] : colours.dash(n)).map((each) => Math.round(each * devicePixelRatio)),
      }));
      return new Strip(Math.max(Math.round(bbox.width), 1), Math.max(Math.round(bbox.height), 1), looks);
    };
    this._strip = strip(false);
    this._held = traces.some(({ held }) => held) ? strip(true) : null;
    const names = traces.map(({ title, unit }) => (unit ? `${title} in ${unit}` : title));
    mark(this.canvas, "role", "img");
    mark(this.canvas, "aria-label", `Chart over time of ${names.join(", ") || "nothing yet"}. ${this._numbers}`);
  }

  _overlay(plot) {
    const { ctx, bbox } = plot;
    this._held?.show(ctx, Math.floor(bbox.left), Math.floor(bbox.top));
    this._strip?.show(ctx, Math.floor(bbox.left), Math.floor(bbox.top));
    const line = (time, text, dash) => {
      if (time === null || time < plot.scales.x.min || time > plot.scales.x.max) return;
      const x = Math.round(plot.valToPos(time, "x", true)) + 0.5;
      ctx.setLineDash(dash);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText(text, x + 4 * devicePixelRatio, bbox.top + 2 * devicePixelRatio);
    };
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = this._colours.ink;
    ctx.lineWidth = devicePixelRatio;
    ctx.font = `600 ${12 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.textBaseline = "top";
    line(this.cursors[0], "A", []);
    line(this.cursors[1], "B", [6, 4]);
    line(this.trigger, "T", [2, 3]);
    ctx.restore();
  }

  _selected(plot) {
    const { left, width } = plot.select;
    if (width > 4) {
      this._notify("zoom", [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
    }
    if (width > 0) plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  _part(event) {
    const over = this._plot.over.getBoundingClientRect();
    return (event.clientX - over.left) / Math.max(over.width, 1);
  }

  _listen() {
    let down = null;
    const { element } = this;
    element.addEventListener("wheel", (event) => {
      if (this._plot === null) return;
      event.preventDefault();
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        this._notify("pan", Math.sign(event.deltaX || event.deltaY) * 0.1);
      } else {
        this._notify("wheel", { at: this._part(event), factor: event.deltaY > 0 ? WHEEL : 1 / WHEEL });
      }
    }, { passive: false });
    // the phase of capture: with Shift uPlot does not see it
    element.addEventListener("mousedown", (event) => {
      if (event.button !== 0 || this._plot === null) return;
      down = { x: event.clientX, from: event.clientX, pan: event.shiftKey };
      if (event.shiftKey) {
        event.stopPropagation();
        event.preventDefault();
      }
    }, { capture: true });
    element.addEventListener("mousemove", (event) => {
      if (!down?.pan) return;
      this._notify("pan", (down.x - event.clientX) / this.pixels);
      down.x = event.clientX;
    });
    element.addEventListener("mouseup", (event) => {
      if (down && !down.pan && Math.abs(event.clientX - down.from) < 4) {
        const { min, max } = this._plot.scales.x;
        if (min !== null) this._notify("cursor", min + this._part(event) * (max - min));
      }
      down = null;
    });
    element.addEventListener("mouseleave", () => {
      down = null;
    });
    element.addEventListener("dblclick", (event) => {
      event.stopPropagation();
      this._notify("reset");
    }, { capture: true });
  }
}

function label(value) {
  if (value === null) return "";
  return Math.abs(value) >= 1e6 ? value.toExponential(2) : String(Number(number(value, 6)));
}
