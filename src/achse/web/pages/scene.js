/** Machine: the picture that the station's scene file describes, moved by its axes. */

import { drawDirections } from "./channels.js";
import { h, panel } from "./dom.js";
import { number } from "./format.js";
import { boundsOf } from "./projection.js";
import { atLimit, partsOf, placed } from "./scene_tree.js";
import { Facts } from "./table.js";
import { Turntable } from "./turntable.js";

export function mount(element, session) {
  let end = () => {};
  session.do("scene").then((scene) => {
    if (scene === undefined) return;
    try {
      end = mountScene(element, session, partsOf(scene));
    } catch (error) {
      element.append(h("p", { class: "bad", role: "alert" }, `The scene cannot be drawn. ${error.message}`));
    }
  });
  element.append(h("span", { hidden: true }));
  return () => end();
}

function mountScene(element, session, parts) {
  const positions = new Map();
  const facts = new Facts();
  const axes = new Set(parts.map(({ joint }) => joint?.axis));
  const lamps = [...new Set(parts.map(({ lamp }) => lamp).filter(Boolean))];
  let lit = {};
  const bounds = boundsOf(placed(parts, () => 0).flatMap(({ lines, ways }) => [...lines, ...ways].flat()));
  const table = new Turntable("The machine", session, (context, width, height, colours, camera) => {
    const onto = camera.onto(width, height, bounds);
    drawDirections(context, height, colours, camera);
    const stroke = (lines, colour, width, dashes = []) => {
      context.lineWidth = width;
      context.strokeStyle = colour;
      context.setLineDash(dashes);
      context.beginPath();
      for (const line of lines) {
        line.forEach((point, n) => context[n ? "lineTo" : "moveTo"](...onto(point).slice(0, 2)));
      }
      context.stroke();
    };
    for (const { part, lines, ways } of placed(parts, (axis) => positions.get(axis) ?? 0)) {
      const plain = part.colour === "raised" ? colours.ink : colours[part.colour];
      const on = part.lamp !== null && lit[part.lamp]?.text === "TRUE";
      stroke(lines, on ? colours.good : plain, on ? 3.5 : 1.5);
      if (ways.length === 0) continue;
      const stopped = atLimit(part.joint, positions.get(part.joint.axis));
      stroke(ways, stopped ? colours.bad : colours.dim, stopped ? 2.5 : 1, [5, 4]);
    }
    context.setLineDash([]);
  });
  element.append(h("div", { class: "grid" }, panel("Positions", facts.element),
    h("section", { class: "panel two", "aria-label": "Machine" }, table.element)));
  session.draw("axes", { every: session.every }, (rows) => {
    for (const { id, name, position, unit } of rows) {
      positions.set(id, position);
      positions.set(name, position);
      if (axes.has(id) || axes.has(name)) facts.update([[name, `${number(position)} ${unit ?? ""}`]]);
    }
    table.draw();
  });
  if (lamps.length) {
    session.draw("symbols", { names: lamps, every: session.every }, (values) => {
      lit = values ?? {};
      facts.update(lamps.map((name) => [name, lit[name]?.text ?? lit[name]?.error ?? "…"]));
      table.draw();
    });
  }
  table.draw();
  return () => table.end();
}
