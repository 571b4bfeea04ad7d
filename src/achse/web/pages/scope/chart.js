import { h, mark } from "../dom.js";
import { number } from "../format.js";
import uPlot from "../vendor/uPlot.js";

/** More traces than these are hairlines: without a graphics processor they take a third of the time. */
const FEW = 3;
const WHEEL = 1.2;

/**
 * One chart: traces over time. The page gives it the rows that are seen (`draw`) and hears what is
 * done by mouse or finger: `told("zoom", [from, to])`, `("wheel", {at, factor})`, `("pan", part)`,
 * `("cursor", time)`, `("reset")`.
 */
export class Chart {
  constructor(place, colours, told) {
    this._colours = colours;
    this._told = told;
    this._series = "";
    this._plot = null;
    this.cursors = [null, null];
    this.trigger = null;
    this.element = h("div", { class: "chart" });
    place.append(this.element);
    this._listen();
  }

  get pixels() {
    return Math.max(this.element.clientWidth - 60, 50);
  }

  /** Colours or size are others now. */
  resize() {
    this._series = "";
  }

  /**
   * `traces`: [{title, unit, number, held}] for the columns behind that of time; `data` as uPlot
   * takes it; `range`: [from, to] in seconds.
   */
  draw(traces, data, range, height) {
    const key = JSON.stringify([traces, this.element.clientWidth, height, this._colours.dark]);
    if (key !== this._series) {
      this._series = key;
      this._make(traces, height);
    }
    const plot = this._plot;
    plot.batch(() => {
      plot.setData(data, false);
      plot.setScale("x", { min: range[0], max: range[1] });
    });
  }

  destroy() {
    this._plot?.destroy();
    this.element.remove();
  }

  /** The picture itself. */
  get canvas() {
    return this._plot?.ctx.canvas ?? null;
  }

  _make(traces, height) {
    this._plot?.destroy();
    const colours = this._colours;
    const units = [...new Set(traces.map(({ unit }) => unit))];
    const scale = (unit) => `y ${unit}`;
    const grid = { stroke: colours.line, width: 1 };
    const axis = { stroke: colours.dim, grid, ticks: grid, font: "12px system-ui, sans-serif" };
    this._plot = new uPlot({
      width: Math.max(this.element.clientWidth, 100), height,
      legend: { show: false },
      padding: [10, 12, 0, 0],
      cursor: { y: false, points: { show: false }, drag: { x: true, y: false, setScale: false } },
      select: { show: true, left: 0, top: 0, width: 0, height: 0 },
      scales: { x: { time: false, auto: false },
        ...Object.fromEntries(units.map((unit) => [scale(unit), { range: fitted }])) },
      axes: [
        { ...axis, space: 70, size: 26, values: (_, splits) => splits.map(label) },
        ...units.slice(0, 2).map((unit, n) => ({
          ...axis, scale: scale(unit), side: n ? 1 : 3, size: 56,
          grid: n ? { show: false } : grid, label: unit || " ", labelSize: 18,
          labelFont: axis.font, values: (_, splits) => splits.map(label),
        })),
      ],
      series: [{}, ...traces.map(({ title, unit, number: n, held }) => ({
        label: title, scale: scale(unit), stroke: colours.trace(n),
        width: held || traces.length > FEW ? 1 : 1.5,
        dash: held ? [3, 3] : colours.dash(n), alpha: held ? 0.7 : 1,
        points: { show: false }, pxAlign: 0,
      }))],
      hooks: { draw: [(plot) => this._overlay(plot)], setSelect: [(plot) => this._selected(plot)] },
    }, [[], ...traces.map(() => [])], this.element);
    const names = traces.map(({ title, unit }) => (unit ? `${title} in ${unit}` : title));
    mark(this.canvas, "role", "img");
    mark(this.canvas, "aria-label", `Chart over time of ${names.join(", ") || "nothing yet"}. `
      + "The numbers are in the table below.");
  }

  _overlay(plot) {
    const { ctx, bbox } = plot;
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
      this._told("zoom", [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
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
        this._told("pan", Math.sign(event.deltaX || event.deltaY) * 0.1);
      } else {
        this._told("wheel", { at: this._part(event), factor: event.deltaY > 0 ? WHEEL : 1 / WHEEL });
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
      this._told("pan", (down.x - event.clientX) / this.pixels);
      down.x = event.clientX;
    });
    element.addEventListener("mouseup", (event) => {
      if (down && !down.pan && Math.abs(event.clientX - down.from) < 4) {
        const { min, max } = this._plot.scales.x;
        if (min !== null) this._told("cursor", min + this._part(event) * (max - min));
      }
      down = null;
    });
    element.addEventListener("mouseleave", () => {
      down = null;
    });
    element.addEventListener("dblclick", (event) => {
      event.stopPropagation();
      this._told("reset");
    }, { capture: true });
  }
}

/** The scale of values: a little room above and below, and never of no height. */
function fitted(_, low, high) {
  if (low === null || high === null) return [0, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  const room = Math.max(0.06 * (high - low), size * 1e-9, 1e-9);
  return high - low > size * 1e-9 ? [low - room, high + room] : [low - (size || 1) / 2, high + (size || 1) / 2];
}

function label(value) {
  if (value === null) return "";
  return Math.abs(value) >= 1e6 ? value.toExponential(2) : String(Number(number(value, 6)));
}
