import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { checked } = await load("parameters.js");
const { fieldsOf, valuesOf } = await load("faults.js");
const { errorOf, motion, stateOf } = await load("axis_state.js");
const { parsed } = await load("format.js");
const { Hold } = await load("hold.js");
const { web } = await load("dom.js");

test("values of parameters are checked before they are sent", () => {
  const row = { value: 1, minimum: 0, maximum: 10 };
  assert.deepEqual(checked(row, "2,5"), { value: 2.5 });
  assert.deepEqual(checked(row, "11"), { problem: "expected 0 … 10" });
  assert.deepEqual(checked(row, "x"), { problem: "a number is needed" });
  assert.deepEqual(checked({ value: true }, "false"), { value: false });
  assert.deepEqual(checked({ value: "X" }, " Y "), { value: " Y " });
  assert.deepEqual(checked({ value: "A", choices: [{ value: 3, name: "A" }] }, "3"), { value: 3 });
});

test("fields of faults become numbers and texts; empty ones are left out", () => {
  const input = (name, value, type) => ({ name, value, type });
  assert.deepEqual(valuesOf([input("code", "0x706", "integer"), input("by", "0.5", "number"),
    input("client", " 10.* ", "string"), input("at", "", "number")]),
  { values: { code: 0x706, by: 0.5, client: "10.*" } });
  assert.equal(valuesOf([input("by", "soon", "number")]).bad, "by");
  assert.equal(valuesOf([input("count", "1.5", "integer")]).bad, "count");
  const late = (value) => valuesOf([{ name: "by", value, type: "number", unit: "s" }]);
  for (const text of ["0.05", "50ms", "50 ms", "50000us", "0,05s"]) {
    assert.deepEqual(late(text), { values: { by: 0.05 } }, text);
  }
  for (const text of ["50 min", "ms", "s"]) assert.equal(late(text).bad, "by", text);
  assert.equal(valuesOf([{ name: "by", value: "5ms", type: "number", unit: "ppm" }]).bad, "by");
  assert.deepEqual(fieldsOf({ fields: ["at"] }), [{ name: "at", type: "string" }]);
  assert.deepEqual(fieldsOf(undefined), []);
});

test("moves need numbers where they are needed", () => {
  const fields = (to, velocity, jerk) =>
    [["to", to, true], ["velocity", velocity, true], ["jerk", jerk, false]];
  assert.deepEqual(motion(fields("10", "5", ""), parsed), { values: { to: 10, velocity: 5 } });
  assert.deepEqual(motion(fields("", "5", ""), parsed), { wrong: "to" });
  assert.deepEqual(motion(fields("1", "5", "x"), parsed), { wrong: "jerk" });
});

test("an axis has one lamp: errors first", () => {
  const row = { error: 0, moving: false, enabled: true, state: "STANDSTILL" };
  assert.deepEqual(stateOf(row), ["on", "standstill"]);
  assert.deepEqual(stateOf({ ...row, moving: true, state: "DISCRETE_MOTION" }),
    ["move", "discrete motion"]);
  assert.deepEqual(stateOf({ ...row, enabled: false }), ["off", "not enabled"]);
  assert.deepEqual(stateOf({ ...row, error: 0x4550, moving: true }), ["bad", "error"]);
  assert.equal(errorOf({ error: 0x4550, error_text: "late" }).name, "0x4550");
  assert.equal(errorOf(row).name, "");
});

test("a held button repeats while it is held, and ends once", (context) => {
  context.mock.timers.enable({ apis: ["setInterval"] });
  const calls = [];
  const hold = new Hold({
    begin: () => calls.push("begin"), again: () => calls.push("again"), end: () => calls.push("end"),
  });
  hold.release();
  hold.press();
  hold.press();
  context.mock.timers.tick(600);
  hold.release();
  hold.release();
  context.mock.timers.tick(600);
  assert.deepEqual(calls, ["begin", "again", "again", "end"]);
  assert.equal(hold.held, false);
});

test("links lead to the web or to this server, never to scripts", () => {
  assert.equal(web("javascript:alert(1)"), null);
  assert.equal(web("data:text/html,x"), null);
  assert.equal(web("https://x.example/#y"), "https://x.example/#y");
  assert.equal(web("docs/errors#e"), "http://localhost/docs/errors#e");
  assert.equal(web("http://["), null);
  assert.equal(web(null), null);
});
