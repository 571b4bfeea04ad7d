/** The parameters of an axis by group, with units and ranges; those that may be written, edited. */

import { h, link, mark, quiet, show } from "./dom.js";
import { parsed, plain, range } from "./format.js";
import { LiveTable, column } from "./table.js";

export class ParameterTables {
  constructor(session, axis) {
    this._session = session;
    this._axis = axis;
    this._groups = [];
    this._group = session.view.get("group");
    this._search = h("input", {
      type: "search", placeholder: "Search parameters", "aria-label": "Search parameters",
      value: session.view.get("find"),
    });
    this._search.addEventListener("input", quiet(() => {
      session.view.set({ find: this._search.value.trim() });
      this._draw();
    }, 150));
    this._tabs = h("div", { class: "tabs", role: "tablist", "aria-label": "Groups of parameters" });
    this._tabs.addEventListener("keydown", (event) => this._walk(event));
    this._again = h("button", { type: "button", class: "small" }, "Read again");
    this._again.addEventListener("click", () => this.load());
    this._table = new LiveTable({
      caption: "Parameters", key: ({ key }) => key, cards: true, empty: "No parameter has this name, key or meaning: empty the search to see all.",
      columns: [
        { title: "Parameter", head: true, make: nameCell },
        { title: "Value", make: (row) => valueCell(row, this) },
        column("Unit", ({ unit }) => (unit && unit !== "1" ? unit : ""), { kind: () => "nowrap" }),
        column("Range", (row) => range(row), { kind: () => "nowrap dim" }),
        column("Meaning", ({ meaning }) => meaning ?? "", { kind: () => "long" }),
      ],
    });
    this._panel = h("div", { role: "tabpanel", "aria-label": "Parameters of the group" }, this._table.element);
    this._state = h("p", { class: "dim", role: "status" }, "Reading the parameters…");
    this.element = h("section", { class: "panel wide", "aria-label": "Parameters" },
      h("div", { class: "row between" }, h("h2", {}, "Parameters"),
        h("div", { class: "row" }, this._search, this._again)),
      this._tabs, this._state, this._panel);
  }

  /** Read every parameter and show it. */
  async load() {
    this._again.disabled = true;
    try {
      this._groups = await this._session.call("axes.parameters", { axis: this._axis });
      show(this._state, "");
    } catch (error) {
      show(this._state, error.message);
    } finally {
      this._again.disabled = false;
    }
    this._draw();
  }

  async write(row, value) {
    const answer = await this._session.do(
      "axes.write", { axis: this._axis, key: row.key, value }, `${row.name}: written.`,
    );
    if (answer !== undefined) await this.load();
    return answer !== undefined;
  }

  get control() {
    return this._session.control;
  }

  _draw() {
    const names = this._groups.map(({ group }) => group);
    if (!names.includes(this._group)) this._group = names[0] ?? "";
    const shown = [...this._tabs.children].map((tab) => tab.dataset.group);
    if (shown.join() !== names.join()) {
      this._tabs.replaceChildren(...names.map((name) => {
        const tab = h("button", { type: "button", role: "tab", "data-group": name }, name);
        tab.addEventListener("click", () => this._choose(name));
        return tab;
      }));
    }
    const wanted = this._search.value.trim().toLowerCase();
    for (const tab of this._tabs.children) {
      const chosen = !wanted && tab.dataset.group === this._group;
      mark(tab, "aria-selected", chosen ? "true" : "false");
      mark(tab, "tabindex", tab.dataset.group === this._group ? "0" : "-1");
    }
    // a search goes through all groups
    this._table.update(this._groups
      .filter(({ group }) => wanted !== "" || group === this._group)
      .flatMap(({ rows }) => rows)
      .filter((row) => wanted === ""
        || `${row.name} ${row.meaning ?? ""} ${row.key}`.toLowerCase().includes(wanted)));
  }

  _choose(name) {
    this._group = name;
    this._search.value = "";
    this._session.view.set({ group: name, find: "" });
    this._draw();
  }

  _walk(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step === undefined || this._groups.length === 0) return;
    event.preventDefault();
    const tabs = [...this._tabs.children];
    const next = (tabs.indexOf(document.activeElement) + step + tabs.length) % tabs.length;
    this._choose(tabs[next].dataset.group);
    tabs[next].focus();
  }
}

function nameCell(row) {
  const name = h("span", {}, link(row.link, row.name));
  return [h("span", { title: row.key }, name), () => {}];
}

/** A value that is edited in place: `tables.write(row, value)` is true when it is taken. */
export function valueCell(first, tables) {
  const text = h("span", { class: "mono" });
  const edit = h("button", { type: "button", class: "value mono", title: "Change this value" });
  const place = h("span", {});
  let latest = first;
  edit.addEventListener("click", () => {
    const input = inputFor(latest);
    const wrong = h("span", { class: "bad", role: "status" });
    const leave = (focus = true) => {
      place.replaceChildren(edit);
      if (focus) edit.focus();
    };
    const form = h("form", { class: "row" }, input,
      h("button", { type: "submit", class: "small main" }, "Write"),
      h("button", { type: "button", class: "small", onclick: () => leave() }, "Cancel"), wrong);
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      const { value, problem } = checked(latest, input.value);
      show(wrong, problem ?? "");
      mark(input, "aria-invalid", problem ? "true" : null);
      if (problem === undefined && (await tables.write(latest, value))) leave();
    });
    form.addEventListener("keydown", (event) => {
      if (event.key === "Escape") leave();
    });
    place.replaceChildren(form);
    input.focus();
    input.select?.();
  });
  return [place, (row) => {
    latest = row;
    show(text, textOf(row));
    if (row.writable && text.parentElement !== edit) {
      edit.append(text);
      place.replaceChildren(edit);
    } else if (!row.writable) {
      place.replaceChildren(text);
    }
    edit.disabled = !tables.control;
    mark(edit, "aria-label", `${row.name}: ${textOf(row)}, change`);
  }];
}

function textOf({ value, choices }) {
  const choice = choices?.find((each) => each.value === value);
  return choice ? `${choice.name} (${plain(value)})` : plain(value);
}

function inputFor(row) {
  const label = { "aria-label": `New value of ${row.name}` };
  const choices = row.choices?.length ? row.choices
    : typeof row.value === "boolean" ? [{ value: true, name: "TRUE" }, { value: false, name: "FALSE" }]
      : null;
  if (choices === null) {
    return h("input", { type: "text", class: "number", value: plain(row.value), ...label });
  }
  const select = h("select", label,
    choices.map(({ value, name }) => h("option", { value: String(value) }, name)));
  select.value = String(row.value);
  return select;
}

/** The value to write, or what is wrong with the text. */
export function checked(row, text) {
  if (typeof row.value === "boolean") return { value: text === "true" };
  if (row.choices?.length || typeof row.value === "number") {
    const value = parsed(text);
    if (value === null) return { problem: "a number is needed" };
    const outside = (row.minimum !== null && row.minimum !== undefined && value < row.minimum)
      || (row.maximum !== null && row.maximum !== undefined && value > row.maximum);
    return outside ? { problem: `expected ${range(row)}` } : { value };
  }
  return { value: text };
}
