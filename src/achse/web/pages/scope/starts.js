/** Channels to start with: axes at one click, while the scope shows nothing. */

import { h } from "../dom.js";

const AXES = 4; // more would be a list to read, not a start
const VALUES = ["ActPos", "ActVelo"];

/** Traces that show an axis: position above velocity. */
export function startOf(name) {
  return VALUES.map((value, n) => ({ text: `Axes.${name}.${value}`, chart: n + 1 }));
}

export class Starts {
  /** `choose(traces)` is called with what a button stands for. */
  constructor(session, choose) {
    this._choose = choose;
    this._buttons = h("span", { class: "row" });
    this.element = h("p", { class: "row" }, h("span", { class: "dim" }, "Start with position and velocity of"),
      this._buttons);
    this._wanted = false;
    this._known = false;
    this.show(false);
    if (session.has("axes")) this._end = session.watch("axes", { every: 1 }, (rows) => this._learn(rows), () => {});
  }

  /** Offer them, or do not. */
  show(wanted) {
    this._wanted = wanted;
    this.element.hidden = !wanted || !this._known;
  }

  /** The names come once: the watch ends with the first of them. */
  _learn(rows) {
    if (!rows?.length) return;
    this._end?.();
    const names = rows.slice(0, AXES).map(({ name }) => name);
    this._buttons.replaceChildren(...names.map((name) => h("button", { type: "button", class: "small",
      onclick: () => this._choose(startOf(name)) }, name)));
    this._known = true;
    this.show(this._wanted);
  }
}
