/** Pictures of drawn bodies: rungs, boxes and charts, from the lines that `achse plc draw` prints. */

import { svg } from "./dom.js";

const WIDE = 8;
const HIGH = 18;
/** Directions in which the sign of a line goes: left, right, up, down. */
const SIGNS = {
  "─": "lr", "═": "lr", "│": "ud", "┌": "rd", "┐": "ld", "└": "ru", "┘": "lu", "├": "rud", "┤": "lud", "┬": "lrd",
  "┴": "lru", "┼": "lrud",
};
const ENDS = { l: [-0.5, 0], r: [0.5, 0], u: [0, -0.5], d: [0, 0.5] };

/** What is in a picture: paths of lines, with power or without, and texts with their cells. */
export function parts(lines) {
  const paths = { plain: [], power: [] };
  const texts = [];
  lines.forEach((line, row) => {
    const signs = [...line];
    signs.forEach((sign, column) => {
      for (const way of SIGNS[sign] ?? "") {
        const beside = way === "l" ? signs[column - 1] : way === "r" ? signs[column + 1] : "";
        const [x, y] = [(column + 0.5) * WIDE, (row + 0.5) * HIGH];
        const [dx, dy] = ENDS[way];
        const kind = sign === "═" || beside === "═" ? "power" : "plain";
        paths[kind].push(`M${x} ${y}l${dx * WIDE} ${dy * HIGH}`);
      }
    });
    const isActive = /^\* /.test(line);
    for (const run of line.matchAll(/[^\s─═│┌┐└┘├┤┬┴┼]+(?: [^\s─═│┌┐└┘├┤┬┴┼]+)*/gu)) {
      texts.push({ text: run[0], row, column: [...line.slice(0, run.index)].length, isActive });
    }
  });
  return { paths, texts, columns: Math.max(1, ...lines.map((line) => [...line].length)), rows: Math.max(1, lines.length) };
}

/** The picture; `name` is what a screen reader says. */
export function drawing(name, lines) {
  const { paths, texts, columns, rows } = parts(lines);
  const [width, height] = [columns * WIDE, rows * HIGH];
  return svg("svg", { class: "drawing", viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": name },
    svg("path", { class: "plain", d: paths.plain.join("") }), svg("path", { class: "power", d: paths.power.join("") }),
    texts.map(({ text, row, column, isActive }) => svg("text", { x: column * WIDE, y: (row + 0.72) * HIGH,
      textLength: [...text].length * WIDE, lengthAdjust: "spacingAndGlyphs", class: isActive ? "active" : null }, text)));
}
