import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { SceneError, partsOf, placed } = await load("scene_tree.js");
const line = { kind: "line", points: [[1, 0, 0]] };

test("children move with their parents, and the file's order does not matter", () => {
  const parts = partsOf({ parts: [
    { name: "tool", parent: "table", at: [0, 0, 5], shape: line, joint: { kind: "linear", axis: "X", along: [2, 0, 0] } },
    { name: "table", joint: { kind: "rotary", axis: 2 } },
  ] });
  assert.deepEqual(parts.map(({ name }) => name), ["table", "tool"]);
  const [point] = placed(parts, (axis) => ({ X: 9, 2: 90 })[axis])[1].lines[0];
  [0, 10, 5].forEach((value, n) => assert.ok(Math.abs(point[n] - value) < 1e-9, `${point}`));
});

test("shapes have lines of finite points", () => {
  for (const shape of [{ kind: "box", size: [1, 2, 3] }, { kind: "cylinder", radius: 1, length: 2 }, line]) {
    const [{ lines }] = placed(partsOf({ parts: [{ name: "a", shape }] }), () => NaN);
    assert.ok(lines.flat(2).every(Number.isFinite));
  }
});

test("broken scenes are refused with a place", () => {
  const part = (rest) => ({ parts: [{ name: "a", ...rest }] });
  for (const scene of [null, 1, [], {}, { parts: Array(1e6).fill({}) }, { parts: [null] }, { parts: [{ name: "a" }, { name: "a" }] },
    { parts: [{ name: "a", parent: "b" }, { name: "b", parent: "a" }] }, part({ parent: "a" }), part({ parent: "z" }),
    part({ at: [NaN, 0, 0] }), part({ at: [1e300, 0, 0] }), part({ shape: { kind: "ball" } }), part({ colour: "url(x)" }),
    part({ joint: { kind: "linear", axis: 1, along: [0, 0, 0] } }), part({ joint: { kind: "screw", axis: 1 } })]) {
    assert.throws(() => partsOf(scene), SceneError);
  }
});
