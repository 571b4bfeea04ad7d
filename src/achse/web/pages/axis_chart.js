/**
 * Position, velocity and following error of one axis over the last seconds, drawn as the scope does.
 *
 * It samples while somebody can see it: not in a hidden tab, not scrolled out of view, not when it
 * is switched off. Then the station has no scope for it, and the page draws nothing.
 */

import { h, mark, show } from "./dom.js";
import { Chart } from "./scope/chart.js";
import { Colours, probe, useStyle } from "./scope/colours.js";
import { Recorder } from "./scope/recorder.js";
import { Roll } from "./scope/roll.js";

const WIDTH = 10; // seconds that are seen
const CYCLE = 0.01;
const SLOW_FRAME = 250; // ms between pictures for people who want less motion
const CHARTS = [
  { height: 200, values: [["ActPos", "Position"], ["ActVelo", "Velocity"]] },
  { height: 120, values: [["PosDiff", "Following error"]] },
];

/** Gives {element, end}. */
export function axisChart(session, axis) {
  useStyle();
  const names = CHARTS.map(({ values }) => values.map(([value]) => `Axes.${axis}.${value}`));
  const colourOf = probe();
  const place = h("div", { class: "charts" });
  const state = h("p", { class: "dim", role: "status" });
  const button = h("button", { type: "button", class: "small" });
  const legend = h("p", { class: "row dim" });
  const element = h("section", { class: "panel wide", "aria-label": "Chart" },
    h("div", { class: "row between" }, h("h2", {}, `Last ${WIDTH} s`), legend, button), colourOf, state, place);
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let on = session.view.get("chart") !== "off";
  let seen = false;
  let due = false;
  let drawn = 0;
  let later = null;
  let ended = false;
  let parts = null;
  let roll = new Roll();

  const recorder = new Recorder(session, (what, value) => {
    if (ended) return;
    if (what === "error") show(state, `No samples come: ${value.message}`);
    else frame();
    if (what === "samples" && state.textContent) show(state, "");
  });
  recorder.cycle = CYCLE;
  recorder.lookBack = 2 * WIDTH;
  recorder.choose(names.flat());

  /** Sample if it is to be seen, else have nothing done for it anywhere. */
  const settle = () => {
    const wanted = on && seen && !document.hidden && !ended;
    if (wanted === recorder.wanted) return;
    if (wanted) {
      roll = new Roll();
      recorder.start();
    } else {
      recorder.stop();
    }
  };
  const toggle = () => {
    show(button, on ? "Hide the chart" : "Show the chart");
    place.hidden = legend.hidden = !on;
    if (!on) show(state, "");
    settle();
  };
  button.addEventListener("click", () => {
    on = !on;
    session.view.set({ chart: on ? "" : "off" });
    toggle();
  });

  const make = (colours) => {
    let number = 0;
    const traces = CHARTS.map(({ values }, n) => values.map(([, title], at) =>
      ({ title, unit: recorder.unit(names[n][at]), number: number++, held: false })));
    legend.replaceChildren(...traces.flat().map((trace) => {
      const swatch = h("span", { class: "swatch", "aria-hidden": "true" });
      swatch.style.backgroundColor = colours.trace(trace.number);
      return h("span", { class: "trace" }, swatch, trace.unit ? `${trace.title}, ${trace.unit}` : trace.title);
    }));
    return CHARTS.map(({ height }, n) => ({ height, traces: traces[n],
      columns: names[n].map((name) => recorder.column(name)),
      chart: new Chart(place, colours, null, "The numbers are above.") }));
  };
  const draw = (now) => {
    const { ring } = recorder;
    if (!ring?.size || !recorder.wanted) return;
    parts ??= make(colours);
    const edge = roll.step(ring.last, now, WIDTH, !still.matches);
    if (edge < ring.last) frame();
    const width = place.clientWidth;
    for (const { chart, traces, columns, height } of parts) {
      chart.draw(traces, { times: ring.columns[0], begin: ring.start, end: ring.end,
        columns: columns.map((column) => ring.columns[column]) }, [edge - WIDTH, edge], { width, height });
    }
  };
  const frame = () => {
    if (due || ended) return;
    due = true;
    const next = () => requestAnimationFrame((now) => {
      due = false;
      drawn = now;
      if (!ended) draw(now);
    });
    const wait = still.matches ? drawn + SLOW_FRAME - performance.now() : 0;
    if (wait > 0) later = setTimeout(next, wait);
    else next();
  };

  document.addEventListener("visibilitychange", settle);
  const sight = new IntersectionObserver((entries) => {
    seen = entries.at(-1).isIntersecting;
    settle();
  });
  sight.observe(element);
  const colours = new Colours(colourOf);
  const unwatch = colours.follow(() => {
    for (const { chart } of parts ?? []) chart.resize();
    frame();
  });
  toggle();
  mark(element, "data-chart", axis);
  return {
    element,
    end() {
      ended = true;
      settle();
      sight.disconnect();
      unwatch();
      clearTimeout(later);
      document.removeEventListener("visibilitychange", settle);
      for (const { chart } of parts ?? []) chart.destroy();
    },
  };
}
