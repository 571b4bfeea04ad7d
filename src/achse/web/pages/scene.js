/** Machine: the picture that the station's scene file describes, moved by its axes. */

import { drawDirections } from "./channels.js";
import { h, panel } from "./dom.js";
import { number } from "./format.js";
import { boundsOf } from "./projection.js";
import { partsOf, placed } from "./scene_tree.js";
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
  const bounds = boundsOf(placed(parts, () => 0).flatMap(({ lines }) => lines.flat()));
  const table = new Turntable("The machine", session, (context, width, height, colours, camera) => {
    const onto = camera.onto(width, height, bounds);
    drawDirections(context, height, colours, camera);
    context.lineWidth = 1.5;
    for (const { part, lines } of placed(parts, (axis) => positions.get(axis) ?? 0)) {
      context.strokeStyle = part.colour === "raised" ? colours.ink : colours[part.colour];
      context.beginPath();
      for (const line of lines) {
        line.forEach((point, n) => context[n ? "lineTo" : "moveTo"](...onto(point).slice(0, 2)));
      }
      context.stroke();
    }
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
  table.draw();
  return () => table.end();
}
