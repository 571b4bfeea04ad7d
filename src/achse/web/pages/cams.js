/** Cam tables: position, velocity and acceleration over the master, and the same as numbers. */

import { Sheet } from "./canvas.js";
import { drawCurve, nearest, place, thinned } from "./curves.js";
import { code, h, panel, show } from "./dom.js";
import { NONE, number, word } from "./format.js";
import { LiveTable, column } from "./table.js";

const POINTS = 500;
const ROWS = 73;
const CURVES = [["position", "Position", "accent"], ["velocity", "Velocity", "good"],
  ["acceleration", "Acceleration", "warn"]];

/** Gives the function that ends it. */
export function mountCams(element, session) {
  const sheets = [];
  let points = null;
  let at = null;
  let current = null;
  const list = new LiveTable({
    caption: "Cam tables", key: ({ table }) => table, cards: true,
    empty: ["There are no cam tables. Clients load them, a station.toml names them: ", code("[[table]]"), ", or ",
      code("achse table --help"), "."],
    columns: [
      { title: "Table", head: true, make: (row) => {
        const button = h("button", { type: "button", class: "plain small" });
        button.addEventListener("click", () => load(row.table));
        return [button, ({ table, name }) => {
          show(button, name ? `${table} ${name}` : String(table));
          button.setAttribute("aria-pressed", String(table === current));
        }];
      } },
      column("Kind", ({ kind }) => word(kind)),
      column("Cyclic", ({ cyclic }) => (cyclic ? "yes" : "no")),
      column("Rows", ({ rows }) => String(rows ?? NONE), { numeric: true }),
      column("Used by", ({ users }) => String(users ?? NONE), { numeric: true }),
    ],
  });
  const values = new LiveTable({
    caption: "Values of the cam table", key: ({ n }) => n, empty: "No values.",
    columns: [
      column("Master", ({ n }) => number(points.master[n]), { numeric: true, head: true }),
      ...CURVES.map(([key, title]) => column(title, ({ n }) => number(points[key][n], 4), { numeric: true })),
    ],
  });
  const cursor = h("output", { class: "mono" });
  const pictures = CURVES.map(([key, title, kind]) => {
    const sheet = new Sheet(`${title} over the master; left and right arrow keys move the cursor.`,
      (context, width, height, colours) => {
        if (points) drawCurve(context, width, height, colours, { x: points.master, y: points[key], kind, at });
      }, { keys: true });
    sheet.element.classList.add("curve");
    sheets.push(sheet);
    listen(sheet.element);
    return h("figure", {}, h("figcaption", { class: "dim" }, title), sheet.element);
  });
  const state = h("p", { class: "dim", role: "status" });
  const curves = panel("Curves", state, cursor, ...pictures);
  const numbers = panel("Values", h("div", { class: "tall" }, values.element));
  curves.hidden = numbers.hidden = true;
  element.append(h("div", { class: "grid" },
    h("section", { class: "panel", "aria-label": "Cam tables" },
      h("div", { class: "row between" }, h("h2", {}, "Cam tables"), again()), list.element),
    h("div", { class: "column" }, curves, numbers)));
  refresh();
  return () => sheets.forEach((sheet) => sheet.end());

  function again() {
    const button = h("button", { type: "button", class: "small" }, "Read again");
    button.addEventListener("click", refresh);
    return button;
  }

  async function refresh() {
    const rows = await session.do("tables.list");
    if (rows === undefined) return;
    list.update(rows);
    const wanted = Number(session.view.get("table"));
    const chosen = rows.find(({ table }) => table === wanted) ?? rows[0];
    if (chosen) await load(chosen.table, rows);
    else curves.hidden = numbers.hidden = true;
  }

  async function load(table, rows = null) {
    current = table;
    show(state, `Reading table ${table}…`);
    curves.hidden = false;
    const answer = await session.do("tables.points", { table, count: POINTS });
    if (current !== table) return;
    if (rows === null) session.view.set({ table });
    points = answer ?? null;
    at = null;
    show(state, points ? `Table ${table}, ${points.master.length} points, at master velocity 1.`
      : `Table ${table} cannot be read.`);
    list.element.querySelectorAll("button").forEach((button) =>
      button.setAttribute("aria-pressed", String(Number.parseInt(button.textContent, 10) === table)));
    numbers.hidden = points === null;
    values.update(points ? thinned(points.master.length, ROWS).map((n) => ({ n })) : []);
    tell();
  }

  function tell() {
    show(cursor, points === null || at === null ? "Point at a curve to read its values."
      : [`master ${number(points.master[at])}`,
        ...CURVES.map(([key, title]) => `${title.toLowerCase()} ${number(points[key][at], 4)}`)].join("   "));
    for (const sheet of sheets) sheet.draw();
  }

  function listen(canvas) {
    canvas.addEventListener("pointermove", (event) => {
      if (!points?.master.length) return;
      const box = canvas.getBoundingClientRect();
      const [first, last] = [points.master[0], points.master.at(-1)];
      at = nearest(points.master, first + (last - first) * place(event.clientX - box.left, box.width));
      tell();
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (step === undefined || !points?.master.length || event.ctrlKey || event.altKey) return;
      event.preventDefault();
      const far = event.shiftKey ? 25 : 5;
      at = Math.min(points.master.length - 1, Math.max(0, (at ?? 0) + far * step));
      tell();
    });
  }
}
