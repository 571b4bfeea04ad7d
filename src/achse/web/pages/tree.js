/**
 * A tree by keys as WAI-ARIA has it: up, down, right opens, left closes, Home, End, Enter chooses.
 * Branches ask for their rows when they are first opened; long ones show more on demand.
 */

import { h, mark, show } from "./dom.js";

export class Tree {
  constructor({ label, list, actions, chosen, failed, empty = "Nothing here." }) {
    Object.assign(this, { _list: list, _actions: actions, _chosen: chosen, _failed: failed });
    this._tree = h("ul", { class: "tree", role: "tree", "aria-label": label });
    this._empty = h("p", { class: "dim empty" }, empty);
    this.element = h("div", { class: "trees" }, this._tree, this._empty);
    this._tree.addEventListener("keydown", (event) => this._pressed(event));
    this._tree.addEventListener("focusin", ({ target }) => {
      const item = target.closest("[role=treeitem]");
      if (item) this._current(item);
    });
  }

  /** Replace what is at the top. */
  fill(rows, more = 0) {
    this._fill(this._tree, rows, more, "", 1);
    const first = this._tree.querySelector("[role=treeitem]");
    if (first) mark(first, "tabindex", "0");
    this._tree.hidden = first === null;
    this._empty.hidden = first !== null;
  }

  focus() {
    (this.element.querySelector("[tabindex='0']") ?? this._items()[0])?.focus();
  }

  _fill(list, rows, more, under, level) {
    list.replaceChildren(...rows.map((row) => this._item(row, level)));
    if (more <= 0) return;
    // a row of the tree like the others, so that keys reach it
    const item = h("li", { role: "treeitem", tabindex: "-1", "aria-level": level, class: "more" },
      h("div", { class: "row" }, `Show more (${more} left)`));
    item.more = async () => {
      try {
        const next = await this._list(under, rows.length);
        this._fill(list, next.rows, next.more, under, level);
        list.querySelectorAll(":scope > [role=treeitem]")[rows.length]?.focus();
      } catch (error) {
        this._failed(error);
      }
    };
    item.addEventListener("click", () => item.more());
    list.append(item);
  }

  _item(row, level) {
    const sign = h("span", { class: "sign", "aria-hidden": "true" }, row.children ? "▸" : "");
    const name = h("span", { class: "name" }, row.name);
    const type = h("span", { class: "type" }, row.type ?? "");
    const comment = h("span", { class: "comment" }, row.comment ?? "");
    const line = h("div", { class: "row" }, sign, name, type, comment,
      h("span", { class: "tools" }, this._actions(row)));
    const item = h("li", {
      role: "treeitem", tabindex: "-1", "aria-level": level, "aria-expanded": row.children ? "false" : null,
      "aria-label": [row.name, row.type, row.comment].filter(Boolean).join(", "),
    }, line);
    item.row = row;
    line.addEventListener("click", () => {
      item.focus();
      if (row.children) this._toggle(item);
    });
    line.addEventListener("dblclick", () => !row.children && this._chosen(row));
    return item;
  }

  async _toggle(item, wanted = item.getAttribute("aria-expanded") !== "true") {
    const { row } = item;
    if (!row?.children || wanted === (item.getAttribute("aria-expanded") === "true")) return;
    mark(item, "aria-expanded", String(wanted));
    show(item.querySelector(".sign"), wanted ? "▾" : "▸");
    let group = item.querySelector(":scope > [role=group]");
    if (group !== null) {
      group.hidden = !wanted;
      return;
    }
    group = h("ul", { role: "group" });
    item.append(group);
    mark(item, "aria-busy", "true");
    try {
      const { rows, more } = await this._list(row.path, 0);
      this._fill(group, rows, more, row.path, Number(item.getAttribute("aria-level")) + 1);
    } catch (error) {
      group.remove();
      mark(item, "aria-expanded", "false");
      show(item.querySelector(".sign"), "▸");
      this._failed(error);
    } finally {
      mark(item, "aria-busy", null);
    }
  }

  _items() {
    return [...this.element.querySelectorAll("[role=treeitem]")].filter(
      (item) => item.closest("[role=group][hidden]") === null);
  }

  _current(item) {
    for (const other of this.element.querySelectorAll("[role=treeitem][tabindex='0']")) {
      mark(other, "tabindex", "-1");
    }
    mark(item, "tabindex", "0");
  }

  _pressed(event) {
    const item = event.target.closest("[role=treeitem]");
    if (item === null || event.target !== item || event.ctrlKey || event.altKey || event.metaKey) return;
    const items = this._items();
    const place = items.indexOf(item);
    const open = item.getAttribute("aria-expanded");
    const moves = {
      ArrowDown: () => items[place + 1]?.focus(),
      ArrowUp: () => items[place - 1]?.focus(),
      Home: () => items[0]?.focus(),
      End: () => items.at(-1)?.focus(),
      ArrowRight: () => (open === "true" ? items[place + 1]?.focus() : this._toggle(item, true)),
      ArrowLeft: () => (open === "true" ? this._toggle(item, false)
        : item.parentElement.closest("[role=treeitem]")?.focus()),
      Enter: () => item.more ? item.more() : (item.querySelector(":scope > .row button")
        ? item.querySelector(":scope > .row button").click() : this._toggle(item)),
      " ": () => this._toggle(item),
    };
    if (event.key in moves) {
      event.preventDefault();
      moves[event.key]();
    }
  }
}
