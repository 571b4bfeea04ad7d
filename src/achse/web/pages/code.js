/** Code: sources of the PLCs, checked as one types, saved, and taken over by online change. */

import { act, h, link, mark, quiet, show } from "./dom.js";
import { drafted, jump, lines, valuesOf } from "./code_text.js";
import { drawing } from "./drawing.js";
import { number } from "./format.js";
import { LiveTable, column } from "./table.js";

const PAUSE = 250;
const VALUES = 60;

export function mount(element, session) {
  const files = new FileList(session, (row) => leaveFor(row));
  const editor = new Editor(session, { notify: (findings) => showFindings(findings) });
  const findings = new LiveTable({
    caption: "Findings", key: ({ key }) => key, empty: "No findings.",
    columns: [
      { title: "Place", head: true, make: placeCell },
      column("Finding", ({ text }) => text),
      { title: "Code", make: (row) => [link(row.link, row.code), () => {}] },
    ],
  });
  const counts = h("p", { class: "dim", role: "status" });
  const values = new Values(session);
  const drawings = new Drawings(session);
  element.append(h("div", { class: "code" },
    h("section", { class: "panel", "aria-label": "Files" }, files.element),
    h("div", { class: "column" }, editor.element, drawings.element,
      h("section", { class: "panel" }, h("h2", {}, "Findings"), counts, findings.element)),
    h("div", { class: "column" }, values.element, values.axes)));
  const closing = (event) => {
    if (editor.isDraft) event.preventDefault();
  };
  addEventListener("beforeunload", closing);
  files.load(session.view.get("file")).then((row) => row && open(row));
  const unmount = () => {
    removeEventListener("beforeunload", closing);
    editor.end();
  };
  return Object.assign(unmount, { mayLeave });

  function mayLeave() {
    return !editor.isDraft || globalThis.confirm("The file has changes that are not saved. Leave it?");
  }

  function leaveFor(row) {
    if (mayLeave()) open(row);
  }

  async function open(row, at = null) {
    if (!await editor.open(row)) return;
    files.mark(row);
    session.view.set({ project: row.project || null, file: row.file });
    values.of(editor.sections);
    drawings.of(row, editor.isDrawn);
    if (at) editor.jump(at);
  }

  function showFindings({ counts: { error, warning, unreached }, rows }) {
    const more = error + warning + unreached - rows.length;
    show(counts, `Errors ${error}, warnings ${warning}, in units that no task reaches ${unreached}`
      + (more > 0 ? `; the first ${rows.length} are shown` : ""));
    mark(counts, "class", error ? "bad" : "dim");
    findings.update(rows.map((row) => ({
      ...row, key: [row.kind, row.code, row.file, row.section, row.line, row.column, row.text].join("|"),
    })));
    files.update(rows);
  }

  function placeCell(first) {
    let latest = first;
    const button = h("button", { type: "button", class: "small plain" });
    button.addEventListener("click", () => {
      const row = files.find(editor.project, latest.file);
      if (latest.file === editor.file) editor.jump(latest);
      else if (row && !editor.isDraft) open(row, latest);
      else session.say("Save the file first, or discard its changes.");
    });
    return [button, (row) => {
      latest = row;
      show(button, `${row.kind} ${row.file}:${row.line}`);
    }];
  }
}

/** The files of all projects, each with the number of its errors. */
class FileList {
  constructor(session, chosen) {
    this._session = session;
    this._chosen = chosen;
    this._rows = [];
    this._open = null;
    this._filter = h("input", {
      type: "search", class: "search", placeholder: "Filter files", "aria-label": "Filter files by name",
    });
    this._filter.addEventListener("input", () => this._draw());
    this._list = h("ul", { class: "found files" });
    this.element = h("div", { class: "stack" }, this._filter, this._list);
  }

  /** Gives the row of the wanted file, or of the first one. */
  async load(wanted) {
    const projects = await this._session.do("sources.list");
    if (projects === undefined) return null;
    this._rows = projects.flatMap(({ project, name, files }) =>
      files.map((row) => ({ project, name, ...row })));
    this._draw();
    return this._rows.find(({ file }) => file === wanted) ?? this._rows[0] ?? null;
  }

  find(project, file) {
    return this._rows.find((row) => row.project === project && row.file === file);
  }

  mark(row) {
    this._open = row;
    this._draw();
  }

  /** Count the errors anew, by the findings of the open file's project. */
  update(findings) {
    for (const row of this._rows) {
      if (row.project !== this._open?.project) continue;
      row.errors = findings.filter(({ kind, file }) => kind === "error" && file === row.file).length;
    }
    this._draw();
  }

  _draw() {
    const wanted = this._filter.value.trim().toLowerCase();
    const rows = this._rows.filter(({ file }) => file.toLowerCase().includes(wanted));
    this._list.replaceChildren(...rows.map((row) => {
      const button = h("button", { type: "button", class: "plain small",
        "aria-pressed": String(row.project === this._open?.project && row.file === this._open?.file) },
      row.file, row.errors ? h("span", { class: "bad" }, ` ${row.errors}`) : null);
      button.addEventListener("click", () => this._chosen(row));
      return h("li", {}, button);
    }), ...(rows.length ? [] : [h("li", { class: "dim" }, "No file has this name. ",
      act("Show all files", () => { this._filter.value = ""; this._draw(); }))]));
  }
}

/** One open file: a text field for each of its sections. */
class Editor {
  constructor(session, { notify }) {
    this._session = session;
    this._notify = notify;
    this._fields = [];
    this._saved = [];
    this._newest = 0;
    this.project = 0;
    this.file = "";
    this.sections = [];
    this._title = h("h2", {}, "No file");
    this._state = h("output", { class: "dim" });
    this._save = h("button", { type: "button", disabled: true }, "Save");
    this._apply = h("button", { type: "button", class: "main", disabled: true,
      title: "Save, and let the running PLC go on with the new code" }, "Apply");
    this._discard = h("button", { type: "button", disabled: true }, "Discard");
    this._save.addEventListener("click", () => this.save());
    this._apply.addEventListener("click", () => this.apply());
    this._discard.addEventListener("click", () => this.open({ project: this.project, file: this.file }));
    this._texts = h("div", { class: "stack" });
    this.element = h("section", { class: "panel", "aria-label": "Editor" },
      h("div", { class: "row between" }, this._title,
        h("div", { class: "row" }, this._state, this._discard, this._save, this._apply)), this._texts);
    this._later = quiet(() => this._check(), PAUSE);
  }

  get isDraft() {
    return drafted(this._saved, this._current());
  }

  end() {
    this._later.cancel();
  }

  _current() {
    return this._fields.map(({ value }) => value);
  }

  async open({ project, file }) {
    this._later.cancel();
    const request = ++this._newest;
    const answer = await this._session.do("sources.read", { project, file });
    if (answer === undefined || request !== this._newest) return false;
    const { tag, sections, findings, is_drawn: isDrawn } = answer;
    Object.assign(this, { isDrawn, project, file, sections, _tag: tag, _saved: sections.map(({ text }) => text) });
    show(this._title, file);
    show(this._state, "");
    mark(this._state, "class", "dim");
    this._fields = sections.map((section) => this._field(section));
    this._texts.replaceChildren(...(sections.length ? this._fields.map((field, n) => h("label", { class: "source" },
      sections[n].name ? h("span", { class: "dim" }, `${sections[n].name} – ${sections[n].kind}`) : null, field))
      : [h("p", { class: "dim" }, "This file has no code as text: its bodies are drawn.")]));
    this._changed();
    this._notify(findings);
    return true;
  }

  _field({ text, name, kind }) {
    const field = h("textarea", { class: "mono", spellcheck: "false", autocapitalize: "off", wrap: "off",
      "aria-label": `${name} ${kind}`.trim(), readonly: !this._session.control });
    field.value = text;
    field.rows = Math.min(lines(text) + 1, 60);
    field.addEventListener("input", () => {
      field.rows = Math.max(field.rows, Math.min(lines(field.value) + 1, 60));
      this._changed();
      this._later();
    });
    field.addEventListener("keydown", (event) => {
      if (event.key === "s" && (event.ctrlKey || event.metaKey)) {
        event.preventDefault();
        this.save();
      }
    });
    return field;
  }

  _changed() {
    const may = this._session.control && this._fields.length > 0;
    this._save.disabled = this._discard.disabled = !may || !this.isDraft;
    this._apply.disabled = !may;
  }

  async _check() {
    const request = ++this._newest;
    const before = performance.now();
    const findings = await this._session.do("sources.check",
      { project: this.project, file: this.file, texts: this._current(), tag: this._tag });
    if (findings === undefined || request !== this._newest) return;
    const { is_changed: isChanged } = findings;
    show(this._state, isChanged ? "written by others meanwhile: cannot be saved over it"
      : `checked in ${number(performance.now() - before, 0)} ms`);
    mark(this._state, "class", isChanged ? "bad" : "dim");
    this._notify(findings);
  }

  /** Gives whether the file is saved. */
  async save() {
    if (!this.isDraft) return true;
    this._later.cancel();
    const texts = this._current();
    const { project, file } = this;
    const request = ++this._newest;
    const answer = await this._session.do("sources.save", { project, file, texts, tag: this._tag }, `${file}: saved.`);
    if (answer === undefined || file !== this.file || project !== this.project) return false;
    // what is typed meanwhile is a draft of the file as it is saved now
    this._tag = answer.tag;
    this._saved = texts;
    this._changed();
    if (request === this._newest) this._notify(answer.findings);
    return !this.isDraft;
  }

  async apply() {
    if (!await this.save()) return;
    const ports = await this._session.do("sources.apply", {});
    if (ports !== undefined) this._session.say("The PLC goes on with the new code.");
  }

  jump({ section, line, column }) {
    const field = this._fields[section ?? 0];
    if (!field) return;
    const at = jump(field.value, line, column);
    field.focus();
    field.setSelectionRange(at, at);
    // a field does not scroll to its cursor by itself
    field.scrollIntoView({ block: "nearest" });
    field.scrollTop = (field.scrollHeight / Math.max(1, lines(field.value))) * Math.max(0, line - 5);
  }
}

/** Drawn bodies of the open file, with power and values. */
class Drawings {
  constructor(session) {
    this._session = session;
    this._end = () => {};
    this._of = h("input", { type: "text", class: "mono", placeholder: "MAIN.fbValve", "aria-label": "Instance" });
    this._pictures = h("div", { class: "stack drawings" });
    this.element = h("section", { class: "panel", "aria-label": "Drawn bodies", hidden: true },
      h("h2", {}, "Drawn bodies"), h("label", { class: "row" }, "Values of the block ", this._of), this._pictures);
    this._of.addEventListener("change", () => this._watch());
  }

  of({ project, file }, isDrawn) {
    Object.assign(this, { project, file });
    this.element.hidden = !isDrawn;
    this._of.value = "";
    this._end();
    this._end = () => {};
    this._pictures.replaceChildren();
    if (isDrawn) this._watch();
  }

  _watch() {
    this._end();
    const { project, file } = this;
    this._end = this._session.draw("drawings", { project, file, of: this._of.value.trim() }, (bodies) => {
      this._pictures.replaceChildren(...bodies.map(({ name, lines }) =>
        h("figure", {}, h("figcaption", { class: "dim" }, name), drawing(name, lines))));
    });
  }
}

/** Values of the unit in the open file, and positions of the axes. */
class Values {
  constructor(session) {
    this._session = session;
    this._end = () => {};
    this._newest = 0;
    this._table = new LiveTable({
      caption: "Values", key: ({ path }) => path,
      empty: "Programs and global variables show their values here.",
      columns: [
        column("Symbol", ({ path }) => path, { head: true, kind: () => "path" }),
        column("Value", ({ is }) => is?.text ?? is?.error ?? (is === undefined ? "…" : String(is)),
          { kind: () => "mono" }),
      ],
    });
    this.element = h("section", { class: "panel" }, h("h2", {}, "Values"),
      h("div", { class: "tall" }, this._table.element));
    const axes = new LiveTable({
      caption: "Axes", key: ({ id }) => id, empty: "There are no axes.",
      columns: [
        column("Axis", ({ name }) => name, { head: true }),
        column("Position", ({ position, unit }) => `${number(position)} ${unit ?? ""}`, { numeric: true }),
      ],
    });
    this.axes = h("section", { class: "panel" }, h("h2", {}, "Axes"), axes.element);
    this.axes.hidden = !session.has("axes");
    if (session.has("axes")) session.draw("axes", { every: session.every }, (rows) => axes.update(rows));
  }

  async of(sections) {
    const request = ++this._newest;
    this._end();
    this._end = () => {};
    this._table.update([]);
    const found = [];
    for (const unit of valuesOf(sections)) {
      try {
        const answer = await this._session.call("symbols.list", { under: unit, limit: VALUES });
        found.push(...(Array.isArray(answer) ? answer : answer.rows));
      } catch {
        continue; // a block or a type: it has no values of its own
      }
    }
    const rows = found.filter(({ type, children }) => type && !children).slice(0, VALUES)
      .map((row) => ({ ...row, path: row.path ?? row.name }));
    if (request !== this._newest || rows.length === 0) return;
    this._end = this._session.draw("symbols", { names: rows.map(({ path }) => path), every: this._session.every },
      (values) => this._table.update(rows.map((row) => ({ ...row, is: values?.[row.path] }))));
  }
}
