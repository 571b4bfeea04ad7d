import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { SceneError, atLimit, partsOf, placed } = await load("scene_tree.js");
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

test("ways between limits stand still, a lamp names a symbol", () => {
  const arm = { name: "arm", at: [0, 0, 1], lamp: "MAIN.bOpen", shape: { kind: "line", points: [[2, 0, 0]] },
    joint: { kind: "linear", axis: "X", along: [3, 0, 0], limits: [-5, 10] } };
  const wheel = { name: "wheel", joint: { kind: "rotary", axis: "C", along: [0, 0, 1], limits: [0, 90] }, shape: line };
  const parts = partsOf({ parts: [arm, wheel] });
  assert.equal(parts[0].lamp, "MAIN.bOpen");
  for (const at of [0, 4, NaN]) {
    const [linear, rotary] = placed(parts, () => at);
    assert.deepEqual(linear.ways, [[[-5, 0, 1], [10, 0, 1]]]);
    const [[foot, one], [, other]] = rotary.ways;
    assert.deepEqual(foot, [0, 0, 0]);
    assert.ok(Math.abs(one[0] * other[0] + one[1] * other[1]) < 1e-9, "a right angle");
  }
  const { joint } = parts[0];
  assert.deepEqual([-6, -5, 0, 10, 11, NaN, undefined].map((at) => atLimit(joint, at)), [true, true, false, true, true, false, false]);
  assert.equal(atLimit(partsOf({ parts: [{ name: "a", joint: { kind: "linear", axis: 1 } }] })[0].joint, 1e9), false);
});

test("broken scenes are refused with a place", () => {
  const part = (rest) => ({ parts: [{ name: "a", ...rest }] });
  for (const scene of [null, 1, [], {}, { parts: Array(1e6).fill({}) }, { parts: [null] }, { parts: [{ name: "a" }, { name: "a" }] },
    { parts: [{ name: "a", parent: "b" }, { name: "b", parent: "a" }] }, part({ parent: "a" }), part({ parent: "z" }),
    part({ lamp: 1 }), part({ lamp: "" }), part({ joint: { kind: "linear", axis: 1, limits: [1, 1] } }),
    part({ joint: { kind: "linear", axis: 1, limits: [1] } }), part({ at: [NaN, 0, 0] }), part({ at: [1e300, 0, 0] }), part({ shape: { kind: "ball" } }), part({ colour: "url(x)" }),
    part({ joint: { kind: "linear", axis: 1, along: [0, 0, 0] } }), part({ joint: { kind: "screw", axis: 1 } })]) {
    assert.throws(() => partsOf(scene), SceneError);
  }
});
