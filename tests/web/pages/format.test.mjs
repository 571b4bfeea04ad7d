import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const format = await load("format.js");

const CASES = {
  number: [[[1.23456], "1.235"], [[-0.0001], "0.000"], [[-1e12], "-1.0000e+12"], [[NaN], "–"],
    [[Infinity], "∞"], [[-Infinity], "-∞"], [[undefined], "–"], [["7"], "–"], [[5, 0], "5"]],
  plain: [[[true], "TRUE"], [[-0], "0"], [[null], "–"], [["<b>"], "<b>"], [[0.1], "0.1"], [[1e20], "1e+20"],
    [[1000000], "1000000"], [[0.1 + 0.2], "0.30000000000000004"],
    [[{ a: 1 }], '{"a":1}']],
  count: [[[1234567], "1\u2009234\u2009567"], [[-1234], "-1\u2009234"], [[0], "0"], [[null], "–"]],
  percent: [[[0.034], "3.4 %"], [[1, 0], "100 %"], [[null], "–"]],
  seconds: [[[0.002], "2 ms"], [[0.00025], "250 µs"], [[0], "0 s"], [[1.5], "1.5 s"], [[null], "–"]],
  elapsed: [[[3723.9], "1:02:03"], [[0], "0:00:00"], [[null], "–"]],
  code: [[[0x4655], "0x4655"], [[7], "0x0007"], [[null], "–"]],
  word: [[["OPERATION_ENABLED"], "operation enabled"], [[""], "–"], [[null], "–"]],
  range: [[[{ minimum: 0, maximum: 5 }], "0 … 5"], [[{ minimum: 1, maximum: null }], "from 1"],
    [[{ maximum: 9 }], "to 9"], [[{}], ""]],
  parsed: [[["1,5"], 1.5], [[" -2e3 "], -2000], [[""], null], [["1,234,5"], null], [["x"], null],
    [["Infinity"], null]],
};

for (const [name, cases] of Object.entries(CASES)) {
  test(`${name} tells numbers as people read them`, () => {
    for (const [values, expected] of cases) {
      assert.deepEqual(format[name](...values), expected, `${name}(${values})`);
    }
  });
}

test("times of day have milliseconds", () => {
  assert.match(format.clock(1_700_000_000.25), /^\d\d:\d\d:\d\d\.250$/);
  assert.equal(format.clock(null), "–");
});

test("drives have the unit of their axis, or increments", async () => {
  const { positionOf, velocityOf } = await load("drives.js");
  const scaled = { position: -229376, velocity: -100, scaled_position: 30, scaled_velocity: 0.0131, unit: "mm" };
  assert.equal(positionOf(scaled), "30.000 mm");
  assert.equal(velocityOf(scaled), "0.013 mm/s");
  const loose = { position: 1234567, velocity: null, scaled_position: null, scaled_velocity: null, unit: "" };
  assert.equal(positionOf(loose), "1\u2009234\u2009567 inc");
  assert.equal(velocityOf(loose), "–");
  assert.equal(velocityOf({ ...scaled, unit: "" }), "0.013");
});
