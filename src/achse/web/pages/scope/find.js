import { h, quiet } from "../dom.js";

/** Search for channels: `add(text, chart)` is called with what is chosen; `last()` is the last chart. */
export class Finder {
  constructor(session, { add, last }) {
    this._session = session;
    this._add = add;
    this._newest = 0;
    this._searched = ""; // the text whose matches are shown
    this._input = h("input", { type: "search", class: "search", placeholder: "Axes.X.ActPos, MAIN.…",
      "aria-label": "Search channels to add" });
    this._where = h("select", { "aria-label": "Add to" });
    this._last = last;
    this._results = h("ul", { class: "found", "aria-label": "Channels found" });
    this._note = h("p", { class: "dim empty" });
    this._note.hidden = true;
    this.element = h("div", { class: "panel" },
      h("div", { class: "row" }, this._input, this._where), this._results, this._note);
    this._search = quiet(() => this._ask());
    this._input.addEventListener("input", () => this._search());
    this._input.addEventListener("keydown", (event) => this._pressed(event));
    this._results.addEventListener("keydown", (event) => this._pressed(event));
    this.refresh();
  }

  destroy() {
    this._search.cancel();
  }

  /** The charts that there are now. */
  refresh() {
    const last = this._last();
    const chosen = this._where.value || "1";
    const options = Array.from({ length: Math.min(last + 1, 8) }, (_, n) =>
      h("option", { value: n + 1 }, n + 1 > last ? "to a new chart" : `to chart ${n + 1}`));
    this._where.replaceChildren(...options);
    this._where.value = Number(chosen) <= options.length ? chosen : "1";
  }

  async _ask() {
    const request = ++this._newest;
    const text = this._input.value.trim();
    if (text === "") {
      this._searched = "";
      this._results.replaceChildren();
      this._note.hidden = true;
      return;
    }
    let rows;
    try {
      rows = await this._session.call("scope.search", { text, limit: 40 });
    } catch (error) {
      if (request === this._newest) this._session.fail(error);
      return;
    }
    if (request !== this._newest) return;
    this._searched = text;
    this._results.replaceChildren(...rows.map((row) => this._row(row)));
    this._note.textContent = rows.length ? "" : "No number has a name or a comment like this.";
    this._note.hidden = rows.length > 0;
  }

  _row({ name, type, unit, meaning }) {
    const button = h("button", { type: "button", class: "small plain" }, name);
    button.addEventListener("click", () => {
      this._add(name, Number(this._where.value));
      this.refresh();
    });
    return h("li", {}, button, " ",
      h("span", { class: "dim" }, [unit, type, meaning].filter(Boolean).join(" · ")));
  }

  _pressed(event) {
    const buttons = [...this._results.querySelectorAll("button")];
    const at = buttons.indexOf(document.activeElement);
    if (event.key === "Escape") {
      this._input.value = "";
      this._ask();
      this._input.focus();
      event.stopPropagation();
    } else if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      event.preventDefault();
      event.stopPropagation();
      const next = at + (event.key === "ArrowDown" ? 1 : -1);
      (next < 0 ? this._input : buttons[Math.min(next, buttons.length - 1)])?.focus();
    } else if (event.key === "Enter" && at < 0) {
      event.preventDefault();
      this._addFirst();
    }
  }

  /** Add the first match of what the field says now, not of the rows from before. */
  async _addFirst() {
    this._search.cancel();
    const text = this._input.value.trim();
    if (text !== this._searched) await this._ask();
    if (text === this._searched) this._results.querySelector("button")?.click();
  }
}
