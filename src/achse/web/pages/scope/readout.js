import { h, mark, show } from "../dom.js";
import { number, seconds } from "../format.js";

/** The numbers at the cursors: a table with a row for each trace. */
export class Readout {
  /** `colours.trace(n)`; `remove(text)` and `place(text, chart)` are what the row's controls do. */
  constructor({ colours, remove, place }) {
    this._means = { colours, remove, place };
    this._rows = new Map();
    this._body = h("tbody");
    this._times = [0, 1, 2, 3].map(() => h("th", { scope: "col", class: "numeric" }));
    this._titles = ["", "", "", ""]; // those of the times, which cards have at each number
    const head = (text) => h("th", { scope: "col" }, text);
    this.element = h("div", { class: "scroll", id: "scope-readout", tabindex: "0", role: "region",
      "aria-label": "Numbers of the traces" },
    h("table", { class: "live cards" }, h("caption", { class: "unseen" }, "Numbers of the traces"),
      h("thead", {}, h("tr", {}, head("Trace"), head("Unit"), this._times, head("Chart"),
        h("th", { scope: "col" }, h("span", { class: "unseen" }, "Actions")))), this._body));
  }

  /** `rows`: [{text, title, unit, chart, number, last, a, b}]; `times`: [last, A, B]. */
  update(rows, [last, a, b]) {
    show(this._times[0], last === null ? "Last" : `Last, ${number(last, 3)} s`);
    show(this._times[1], a === null ? "A" : `A, ${number(a, 6)} s`);
    show(this._times[2], b === null ? "B" : `B, ${number(b, 6)} s`);
    show(this._times[3], a === null || b === null ? "B − A"
      : `Δt ${seconds(b - a)}${b === a ? "" : ` (${number(1 / Math.abs(b - a), 3)} Hz)`}`);
    this._titles = this._times.map(({ textContent }) => textContent);
    for (const [text, { element }] of this._rows) {
      if (!rows.some((row) => row.text === text)) {
        element.remove();
        this._rows.delete(text);
      }
    }
    for (const row of rows) {
      const shown = this._rows.get(row.text) ?? this._add(row);
      shown.swatch.style.backgroundColor = this._means.colours.trace(row.number);
      show(shown.unit, row.unit);
      const change = row.a === null || row.b === null ? null : row.b - row.a;
      [row.last, row.a, row.b, change].forEach((value, n) => {
        show(shown.cells[n], number(value, 6));
        mark(shown.cells[n], "data-label", this._titles[n]);
      });
      if (shown.chart.value !== String(row.chart)) shown.chart.value = String(row.chart);
    }
  }

  _add({ text, title }) {
    const swatch = h("span", { class: "swatch", "aria-hidden": "true" });
    const unit = h("td", { "data-label": "Unit" });
    const cells = [0, 1, 2, 3].map(() => h("td", { class: "numeric" }));
    const chart = h("select", { "aria-label": `Chart of ${title}` },
      [1, 2, 3, 4, 5, 6, 7, 8].map((n) => h("option", { value: n }, String(n))));
    chart.addEventListener("change", () => this._means.place(text, Number(chart.value)));
    const away = h("button", { type: "button", class: "small", "aria-label": `Remove ${title}` },
      "Remove");
    away.addEventListener("click", () => this._means.remove(text));
    const element = h("tr", {}, h("th", { scope: "row" }, h("span", { class: "trace" }, swatch,
      h("span", {}, title))), unit, cells, h("td", { "data-label": "Chart" }, chart), h("td", {}, away));
    this._body.append(element);
    const shown = { element, swatch, unit, cells, chart };
    this._rows.set(text, shown);
    return shown;
  }
}
