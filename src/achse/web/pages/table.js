import { h, show } from "./dom.js";

/**
 * A table whose rows live: `update(rows)` adds, changes, moves and removes rows by their key and
 * touches only what is another than before.
 *
 * Columns: {title, text: (row) => string} or {title, make: (row) => [node, (row) => void]} for
 * cells with controls; `numeric` puts it to the right, `head` makes it the heading of its row,
 * `quiet` is left out on narrow screens, `kind: (row) => string` sets a class for the cell.
 */
export class LiveTable {
  /** `empty` says what to do without rows: a text, or nodes and texts. */
  constructor({ caption, columns, key, empty = "Nothing here.", cards = false }) {
    this._columns = columns;
    this._key = key;
    this._rows = new Map();
    this._body = h("tbody");
    this._empty = h("p", { class: "dim empty" }, empty);
    const headings = columns.map(({ title, numeric, quiet, hidden }) =>
      h("th", { scope: "col", class: classes({ numeric, quiet }) },
        hidden ? h("span", { class: "unseen" }, title) : title));
    this._table = h(
      "table", { class: cards ? "live cards" : "live" },
      h("caption", { class: "unseen" }, caption), h("thead", {}, h("tr", {}, headings)), this._body,
    );
    // a table that is wider than the screen is scrolled, by keys too
    this.element = h(
      "div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
      this._table, this._empty,
    );
    this.update([]);
  }

  get size() {
    return this._rows.size;
  }

  /** Rows that stay are not moved for the sake of those that go: who types in one goes on typing. */
  update(rows) {
    const wanted = new Map();
    for (const row of rows) {
      const key = this._key(row);
      if (!wanted.has(key)) wanted.set(key, row);
    }
    for (const [key, { element }] of this._rows) {
      if (!wanted.has(key)) {
        element.remove();
        this._rows.delete(key);
      }
    }
    let place = this._body.firstElementChild;
    for (const [key, row] of wanted) {
      const shown = this._rows.get(key) ?? this._add(key, row);
      shown.update(row);
      if (shown.element === place) place = place.nextElementSibling;
      else this._body.insertBefore(shown.element, place);
    }
    this._table.hidden = wanted.size === 0;
    this._empty.hidden = wanted.size > 0;
  }

  _add(key, first) {
    const updates = [];
    const cells = this._columns.map((column) => {
      const { title, text, make, numeric, quiet, head, kind } = column;
      const plain = classes({ numeric, quiet });
      const cell = h(head ? "th" : "td", {
        scope: head ? "row" : null, class: plain, "data-label": title,
      });
      if (make) {
        const [node, update] = make(first);
        cell.append(node);
        updates.push(update);
      } else {
        updates.push((row) => show(cell, text(row)));
      }
      if (kind) updates.push((row) => { cell.className = `${plain ?? ""} ${kind(row)}`.trim(); });
      return cell;
    });
    const shown = {
      element: h("tr", {}, cells),
      update: (row) => { for (const each of updates) each(row); },
    };
    this._rows.set(key, shown);
    return shown;
  }
}

function classes(flags) {
  return Object.keys(flags).filter((name) => flags[name]).join(" ") || null;
}

/** A column of one text. */
export function column(title, text, rest = {}) {
  return { title, text, ...rest };
}

/** Facts as a list of names and values: `facts.update([["Version", "0.9"], …])`. */
export class Facts {
  constructor() {
    this.element = h("dl", { class: "facts" });
    this._shown = new Map();
  }

  update(pairs) {
    for (const [name, text, kind = ""] of pairs) {
      let value = this._shown.get(name);
      if (value === undefined) {
        value = h("dd");
        this._shown.set(name, value);
        this.element.append(h("div", {}, h("dt", {}, name), value));
      }
      show(value, text);
      if (value.className !== kind) value.className = kind;
    }
  }
}

/** A lamp with its word: colour is never the only sign. Kinds: on, move, warn, bad, off. */
export function lamp() {
  const light = h("span", { class: "lamp", "aria-hidden": "true" });
  const text = h("span");
  const element = h("span", { class: "lamp-text" }, light, text);
  return [
    element,
    (kind, words) => {
      if (light.dataset.kind !== kind) light.dataset.kind = kind;
      show(text, words);
    },
  ];
}
