/** The state machine of a drive after CiA 402 as a picture; the active state is marked. */

import { svg } from "./dom.js";
import { word } from "./format.js";

const WIDTH = 176;
const HEIGHT = 30;

/** State: column and row of its box. */
const PLACES = {
  NOT_READY_TO_SWITCH_ON: [0, 0],
  SWITCH_ON_DISABLED: [0, 1],
  READY_TO_SWITCH_ON: [0, 2],
  SWITCHED_ON: [0, 3],
  OPERATION_ENABLED: [0, 4],
  FAULT_REACTION_ACTIVE: [1, 0],
  FAULT: [1, 1],
  QUICK_STOP_ACTIVE: [1, 4],
};

/** Ways between states; the second of a pair leads back. */
const WAYS = [
  ["NOT_READY_TO_SWITCH_ON", "SWITCH_ON_DISABLED"],
  ["SWITCH_ON_DISABLED", "READY_TO_SWITCH_ON"],
  ["READY_TO_SWITCH_ON", "SWITCHED_ON"],
  ["SWITCHED_ON", "OPERATION_ENABLED"],
  ["OPERATION_ENABLED", "QUICK_STOP_ACTIVE"],
  ["FAULT_REACTION_ACTIVE", "FAULT"],
  ["FAULT", "SWITCH_ON_DISABLED"],
];

const X = 12;
const Y = 10;
const STEP_X = 220;
const STEP_Y = 52;

export function machine() {
  const boxes = new Map();
  const title = svg("title", {}, "State machine of the drive");
  const lines = WAYS.map(([from, to]) => {
    const [[a, b], [c, d]] = [PLACES[from], PLACES[to]].map(([column, row]) =>
      [X + column * STEP_X + WIDTH / 2, Y + row * STEP_Y + HEIGHT / 2]);
    return svg("line", { x1: a, y1: b, x2: c, y2: d, class: "way" });
  });
  for (const [state, [column, row]] of Object.entries(PLACES)) {
    const x = X + column * STEP_X;
    const y = Y + row * STEP_Y;
    boxes.set(state, svg("g", { class: "state" },
      svg("rect", { x, y, width: WIDTH, height: HEIGHT, rx: 6 }),
      svg("text", { x: x + WIDTH / 2, y: y + HEIGHT / 2 + 4.5, "text-anchor": "middle" }, word(state))));
  }
  const element = svg("svg", {
    viewBox: `0 0 ${2 * X + STEP_X + WIDTH} ${2 * Y + 4 * STEP_Y + HEIGHT}`, class: "machine", role: "img",
  }, title, lines, [...boxes.values()]);
  return {
    element,
    show(state) {
      const text = `State of the drive: ${word(state)}`;
      if (title.textContent === text) return;
      title.textContent = text;
      for (const [name, box] of boxes) box.classList.toggle("active", name === state);
    },
  };
}
