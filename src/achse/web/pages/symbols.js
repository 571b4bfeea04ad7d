/** Symbols: a tree whose branches are loaded when opened, search, a watch list, methods. */

import { act, h, mark, quiet, show } from "./dom.js";
import { callMethod } from "./methods.js";
import { LiveTable, column } from "./table.js";
import { Tree } from "./tree.js";

const LIMIT = 200;
const WATCHED_AT_MOST = 200;

export function mount(element, session) {
  const watched = new WatchList(session);
  const tree = new Tree({
    label: "Symbols",
    list: (under, skip) => listed(session, { under, limit: LIMIT + skip }),
    actions: (row) => [
      ...(row.type && !(row.children && row.size === 0)
        ? [action(`Watch ${row.path}`, "Watch", () => watched.add(row))] : []),
      ...(row.methods ? [action(`Methods of ${row.path}`, "Methods",
        () => callMethod(session, row.path))] : []),
    ],
    chosen: (row) => watched.add(row),
    failed: session.fail,
    empty: ["No symbol has a path or a comment like this. ", act("Show all symbols", () => {
      search.value = "";
      look();
      search.focus();
    })],
  });
  const found = h("p", { class: "dim", role: "status" });
  const search = h("input", {
    type: "search", placeholder: "Search by name  ( / ), Enter watches", "aria-label": "Search symbols",
    value: session.view.get("search"), class: "search",
  });
  let asked = 0;
  /** The matches of the search, or the top of the tree; null once the user has typed on. */
  const look = async () => {
    const text = search.value.trim();
    const number = ++asked;
    session.view.set({ search: text });
    try {
      const { rows, more } = await listed(session, text ? { search: text, limit: LIMIT } : { under: "", limit: LIMIT });
      if (number !== asked) return null;
      // a match is anywhere in the tree: its name alone does not say which one it is
      tree.fill(text ? rows.map((row) => ({ ...row, name: row.path })) : rows, more);
      show(found, text ? `${rows.length}${more ? ` of ${rows.length + more}` : ""} found` : "");
      return rows;
    } catch (error) {
      if (number === asked) session.fail(error);
      return null;
    }
  };
  /** Watch the first match of what the field says now, not of the rows from before. */
  const watchFirst = async () => {
    later.cancel();
    if (search.value.trim() === "") return;
    const rows = await look();
    if (rows === null) return;
    if (rows.length) watched.add(rows[0]);
    else session.say("No symbol has a path or a comment like this.");
    search.select();
  };
  const later = quiet(look, 200);
  search.addEventListener("input", later);
  search.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown") {
      event.preventDefault();
      tree.focus();
    } else if (event.key === "Enter") {
      event.preventDefault();
      watchFirst();
    }
  });
  element.append(h("div", { class: "split" },
    h("section", { class: "panel", "aria-label": "All symbols" },
      h("div", { class: "row" }, search, found), tree.element),
    h("section", { class: "panel", "aria-label": "Watch list" },
      h("div", { class: "row between" }, h("h2", {}, "Watch list"), watched.clear),
      watched.element)));
  look();
  return () => later.cancel();
}

/** Rows and how many were left out, from either form of the answer. */
async function listed(session, values) {
  const answer = await session.call("symbols.list", values);
  const rows = Array.isArray(answer) ? answer : answer.rows;
  return {
    more: Array.isArray(answer) ? 0 : (answer.more ?? 0),
    rows: rows.map((row) => ({ ...row, path: row.path ?? row.name })),
  };
}

function action(label, text, run) {
  const button = h("button", { type: "button", class: "small", "aria-label": label, tabindex: "-1" }, text);
  button.addEventListener("click", (event) => {
    event.stopPropagation();
    run();
  });
  return button;
}

/** What is watched: in the URL, read by one watch of the server. */
class WatchList {
  constructor(session) {
    this._session = session;
    this._known = new Map();
    this._values = {};
    this._end = () => {};
    this._table = new LiveTable({
      caption: "Watched symbols", key: ({ path }) => path,
      empty: "Nothing is watched. Type a part of a name and press Enter, or choose symbols in the tree: Enter, or "
        + "the button Watch.",
      columns: [
        column("Symbol", ({ path }) => path, { head: true, kind: () => "path" }),
        { title: "Value", make: (row) => this._value(row) },
        column("Type", ({ type }) => type ?? "", { quiet: true, kind: () => "dim" }),
        { title: "Remove", hidden: true, make: (row) => this._remover(row) },
      ],
    });
    this.element = this._table.element;
    this.clear = h("button", { type: "button", class: "small" }, "Remove all");
    this.clear.addEventListener("click", () => {
      this._known.clear();
      this._changed();
    });
    for (const path of session.view.get("watch").split(",").filter(Boolean).slice(0, WATCHED_AT_MOST)) {
      this._known.set(path, { path });
    }
    this._changed();
    this._learn([...this._known.keys()]);
  }

  add(row) {
    const known = this._known.get(row.path);
    if (known === undefined && this._known.size >= WATCHED_AT_MOST) {
      this._session.fail(new Error(`The watch list takes ${WATCHED_AT_MOST} symbols.`));
      return;
    }
    this._known.set(row.path, { ...known, ...row });
    this._changed();
    this._session.say(`${row.path}: watched.`);
  }

  /** Types of what came by the URL alone. */
  async _learn(paths) {
    for (const path of paths) {
      try {
        const { rows } = await listed(this._session, { search: path, limit: 20 });
        const row = rows.find((each) => each.path === path);
        if (row && this._known.has(path)) this._known.set(path, row);
      } catch {
        return; // values are shown all the same
      }
    }
    this._draw();
  }

  _changed() {
    const names = [...this._known.keys()];
    this._session.view.set({ watch: names.join(",") });
    this.clear.hidden = names.length === 0;
    const end = this._end;
    this._end = names.length === 0 ? () => {}
      : this._session.draw("symbols", { names, every: this._session.every }, (values) => {
        this._values = values ?? {};
        this._draw();
      });
    end();
    this._draw();
  }

  _draw() {
    this._table.update([...this._known.values()].map((row) => ({ ...row, is: this._values[row.path] })));
  }

  _value(first) {
    const text = h("span", { class: "mono answer" });
    const edit = h("button", { type: "button", class: "value mono" }, text);
    const place = h("span", {}, edit);
    let latest = first;
    edit.addEventListener("click", () => {
      const input = h("input", {
        type: "text", class: "mono", value: textOf(latest.is), "aria-label": `New value of ${latest.path}`,
      });
      const leave = () => {
        place.replaceChildren(edit);
        edit.focus();
      };
      const form = h("form", { class: "row" }, input,
        h("button", { type: "submit", class: "small main" }, "Write"),
        h("button", { type: "button", class: "small", onclick: leave }, "Cancel"));
      form.addEventListener("submit", async (event) => {
        event.preventDefault();
        const written = await this._session.do(
          "symbols.write", { name: latest.path, value: input.value }, `${latest.path}: written.`);
        if (written === undefined) mark(input, "aria-invalid", "true");
        else leave();
      });
      form.addEventListener("keydown", (event) => {
        if (event.key === "Escape") leave();
      });
      place.replaceChildren(form);
      input.focus();
      input.select();
    });
    return [place, (row) => {
      latest = row;
      const wrong = row.is?.error !== undefined;
      show(text, wrong ? row.is.error : textOf(row.is));
      mark(text, "data-wrong", wrong);
      edit.disabled = !this._session.control || row.writable === false || wrong;
      mark(edit, "aria-label", `${row.path}: ${text.textContent}, change`);
    }];
  }

  _remover({ path }) {
    const button = h("button", { type: "button", class: "small plain", "aria-label": `Remove ${path}` }, "×");
    button.addEventListener("click", () => {
      this._known.delete(path);
      this._changed();
    });
    return [button, () => {}];
  }
}

function textOf(value) {
  if (value === undefined || value === null) return "…";
  if (typeof value === "object") return value.text ?? value.error ?? "";
  return String(value);
}
