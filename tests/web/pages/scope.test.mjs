import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { Ring } = await load("scope/ring.js");
const { decode } = await load("scope/blocks.js");
const { decimate } = await load("scope/decimate.js");
const { spectrum, transform } = await load("scope/fft.js");
const { derive, parse, sources, unitOf } = await load("scope/derive.js");
const { requestedTrigger, tracesOf, tracesText, triggerOf, triggerText } = await load("scope/address.js");
const { Span } = await load("scope/span.js");
const { csv } = await load("scope/export.js");
const { Recorder } = await load("scope/recorder.js");

/** A generator of numbers that is the same in each run. */
function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

function block({ flags = 0, scope = 1, columns = [], dropped = 0 }) {
  const rows = columns[0]?.length ?? 0;
  const buffer = new ArrayBuffer(16 + 8 * columns.length * rows);
  const head = new DataView(buffer);
  head.setUint8(0, 1);
  head.setUint8(1, flags);
  head.setUint16(2, scope, true);
  head.setUint32(4, columns.length, true);
  head.setUint32(8, rows, true);
  head.setUint32(12, dropped, true);
  columns.forEach((column, n) =>
    column.forEach((value, k) => head.setFloat64(16 + 8 * (n * rows + k), value, true)));
  return buffer;
}

test("a block is taken apart", () => {
  const told = decode(block({ flags: 3, scope: 513, columns: [[1, 2], [-0.5, 1e300]], dropped: 7 }));
  assert.deepEqual([told.scope, told.rows, told.dropped], [513, 2, 7]);
  assert.deepEqual([told.gap, told.trigger, told.end], [true, true, false]);
  assert.deepEqual(told.columns.map((each) => [...each]), [[1, 2], [-0.5, 1e300]]);
  assert.equal(decode(block({ flags: 4 })).end, true);
});

test("what is not a whole block is nothing", () => {
  const whole = block({ columns: [[1, 2, 3]] });
  for (const wrong of ["text", new ArrayBuffer(3), whole.slice(0, -1), null]) {
    assert.equal(decode(wrong), null);
  }
  new DataView(whole).setUint32(4, 0xffffffff, true);
  assert.equal(decode(whole), null);
});

test("a ring holds the newest rows, whatever the blocks are", () => {
  for (let seed = 1; seed < 40; seed += 1) {
    const next = random(seed);
    const ring = new Ring(2, 1 + Math.floor(50 * next()));
    const all = [];
    for (let n = 0; n < 60; n += 1) {
      const rows = Array.from({ length: Math.floor(70 * next()) }, (_, k) => all.length + k);
      ring.append([Float64Array.from(rows), Float64Array.from(rows, (row) => -row)]);
      all.push(...rows);
      const kept = all.slice(all.length - ring.size);
      assert.ok(ring.size === Math.min(all.length, ring.capacity) && ring.total === all.length);
      assert.deepEqual([...ring.part(0, ring.start, ring.end)], kept);
      assert.deepEqual([...ring.part(1, ring.start, ring.end)], kept.map((row) => -row));
      if (kept.length) {
        const time = kept[Math.floor(next() * kept.length)];
        assert.equal(ring.columns[0][ring.find(time)], time);
        assert.equal(ring.at(1, time), -time);
        assert.equal(ring.at(1, ring.last + 1), null);
      }
    }
    assert.equal(ring.columns[0].length, 2 * ring.capacity);
  }
});

test("a gap is a row without values, and another layout keeps what is there", () => {
  const ring = new Ring(2, 10);
  ring.gap();
  assert.equal(ring.size, 0);
  ring.append([Float64Array.of(1, 2), Float64Array.of(5, 6)]);
  ring.gap();
  assert.ok(Number.isNaN(ring.columns[1][2]) && ring.last === 2);
  const next = ring.rebuilt([0, -1, 1], 2);
  assert.deepEqual([...next.part(2, next.start, next.end)], [6, NaN]);
  assert.deepEqual([...next.part(1, next.start, next.end)], [NaN, NaN]);
  assert.throws(() => ring.append([Float64Array.of(1)]), RangeError);
  assert.throws(() => new Ring(0, 1), RangeError);
});

test("decimation keeps every peak, every gap and the order of times", () => {
  for (let seed = 1; seed < 30; seed += 1) {
    const next = random(seed);
    const rows = 1 + Math.floor(5000 * next());
    const pixels = 20 + Math.floor(300 * next());
    const times = Float64Array.from({ length: rows }, (_, n) => n / 1000);
    const values = Float64Array.from({ length: rows }, () => next() - 0.5);
    const peak = Math.floor(next() * rows);
    values[peak] = 100;
    const [x, y] = decimate([times, values], pixels, Math.floor(1e6 * next()));
    assert.equal(x.length, y.length);
    assert.ok(x.length <= 2 * pixels + 4, `${x.length} for ${pixels}`);
    assert.ok(x.every((time, n) => n === 0 || time >= x[n - 1]));
    assert.equal(Math.max(...y), 100);
    assert.equal(Math.min(...y), values.reduce((a, b) => Math.min(a, b)));
    values[peak] = NaN;
    assert.ok(decimate([times, values], pixels, 0)[1].includes(null));
  }
});

test("pairs stay where they are while the picture rolls", () => {
  const times = Float64Array.from({ length: 4000 }, (_, n) => n);
  const first = decimate([times.subarray(0, 3000)], 100, 0)[0];
  const later = decimate([times.subarray(500, 3500)], 100, 500)[0];
  assert.ok(later.slice(2, -2).filter((time) => first.includes(time)).length > 100);
});

test("a spectrum has the amplitude of a sine at its frequency", () => {
  const step = 0.001;
  const values = Float64Array.from({ length: 5000 }, (_, n) =>
    7 + 3 * Math.sin(2 * Math.PI * 62.5 * n * step));
  values[100] = NaN; // older than what is taken
  const [frequencies, amplitudes] = spectrum(values, step);
  assert.equal(frequencies.length, 2048);
  const top = amplitudes.indexOf(Math.max(...amplitudes));
  assert.ok(Math.abs(frequencies[top] - 62.5) < 0.25);
  assert.ok(Math.abs(amplitudes[top] - 3) < 0.01);
  assert.ok(amplitudes[0] < 0.01);
  assert.deepEqual(spectrum(values.subarray(0, 15), step), [[], []]);
});

test("the transform is that of the definition", () => {
  const next = random(5);
  const values = Array.from({ length: 16 }, () => [next(), next()]);
  const [real, imaginary] = [0, 1].map((n) => Float64Array.from(values, (each) => each[n]));
  transform(real, imaginary);
  for (let k = 0; k < 16; k += 1) {
    let [a, b] = [0, 0];
    values.forEach(([re, im], n) => {
      const angle = (-2 * Math.PI * k * n) / 16;
      a += re * Math.cos(angle) - im * Math.sin(angle);
      b += re * Math.sin(angle) + im * Math.cos(angle);
    });
    assert.ok(Math.abs(a - real[k]) < 1e-12 && Math.abs(b - imaginary[k]) < 1e-12);
  }
  assert.throws(() => transform(new Float64Array(3), new Float64Array(3)), RangeError);
});

test("derived traces", () => {
  assert.deepEqual(parse("diff a b"), { kind: "diff", names: ["a", "b"] });
  assert.deepEqual(sources(["a", "rate a", "diff a b"]), ["a", "b"]);
  assert.equal(unitOf("rate a", new Map([["a", "mm/s"]])), "mm/s²");
  const values = { a: Float64Array.of(1, 3), b: Float64Array.of(1, 1) };
  const of = (name) => values[name];
  assert.deepEqual([...derive("diff a b", [0, 1], of)], [0, 2]);
  assert.deepEqual([...derive("rate a", [0, 0.5], of)], [NaN, 4]);
  assert.deepEqual([...derive("rate a", [0, 0.5], of, [-1, 0])], [1, 4]);
});

test("what an address says comes back, and nonsense does no harm", () => {
  const traces = [{ text: "Axes.X.ActPos", chart: 1 }, { text: "diff MAIN.a[1,2] b", chart: 3 }];
  assert.deepEqual(tracesOf(tracesText(traces)), traces);
  assert.deepEqual(tracesOf("a~99|a~1||~2|b~x"), [{ text: "a", chart: 8 }, { text: "b", chart: 1 }]);
  const trigger = { mode: "single", channel: "a", kind: "leaves", level: 0, low: -2, high: 5.5, before: 30 };
  assert.deepEqual(triggerOf(triggerText(trigger)), trigger);
  assert.deepEqual(requestedTrigger(trigger), { channel: "a", kind: "leaves", low: -2, high: 5.5 });
  assert.equal(triggerOf("x~~boom~NaN~~~900").before, 100);
  assert.equal(requestedTrigger(triggerOf("")), null);
});

test("what is seen follows, is zoomed about a place and moved", () => {
  const span = new Span(10);
  assert.deepEqual(span.at(100), [90, 100]);
  span.zoom(0.5, 1, 100);
  assert.deepEqual(span.at(200), [95, 100]);
  span.pan(1, 200);
  assert.deepEqual(span.at(200), [100, 105]);
  span.fix([3, 3]);
  assert.deepEqual(span.at(200), [100, 105]);
  span.follow();
  assert.deepEqual(span.about(50, 20), [48, 58]);
});

test("exported rows are read by others", () => {
  const ring = new Ring(2, 5);
  ring.append([Float64Array.of(0, 0.1), Float64Array.of(1 / 3, NaN)]);
  assert.equal(csv(ring, ["=cmd, x"], [1], ring.start, ring.end),
    `time in s,"'=cmd, x"\r\n0,${1 / 3}\r\n0.1,\r\n`);
});

/** A session whose server is the test. */
function session(answers) {
  const requests = [];
  const listeners = {};
  return { requests, listeners, on: (event, run) => { listeners[event] = run; },
    call: (name, values) => {
      requests.push([name, values]);
      return Promise.resolve(answers(name, values));
    } };
}

test("an hour of 32 channels takes no more memory than the first minutes", async () => {
  const names = Array.from({ length: 32 }, (_, n) => `MAIN.f${n}`);
  const given = session((name) => (name === "scope.start" ? { scope: 4, cycle: 0.001,
    channels: names.map((each) => ({ name: each, unit: "" })) } : {}));
  const told = [];
  const recorder = new Recorder(given, (what, value) => told.push([what, value]));
  recorder.choose(names);
  await recorder.start();
  const rows = 4000;
  const columns = Array.from({ length: 33 }, () => new Array(rows).fill(0));
  const buffer = block({ scope: 4, columns });
  given.listeners.block(buffer);
  const size = recorder.ring.columns.reduce((sum, each) => sum + each.byteLength, 0);
  for (let n = 1; n < 900; n += 1) given.listeners.block(buffer); // 3600 s
  assert.equal(recorder.ring.total, 3_600_000);
  assert.equal(recorder.ring.columns.reduce((sum, each) => sum + each.byteLength, 0), size);
  assert.ok(size <= 64_000_000, `${size}`);
});

test("gaps, triggers, ends and a lost connection", async () => {
  let number = 0;
  const given = session((name) => (name === "scope.start"
    ? { scope: ++number, cycle: 1, channels: [{ name: "a", unit: "mm" }] } : {}));
  const told = [];
  const recorder = new Recorder(given, (what, value) => told.push([what, value]));
  recorder.choose(["a", "rate a"]);
  await recorder.start();
  given.listeners.block(block({ columns: [[1, 2], [5, 7]] }));
  given.listeners.block(block({ flags: 3, columns: [[9], [1]], dropped: 2 }));
  given.listeners.block(block({ scope: 99, columns: [[10], [1]] }));
  const part = (n) => [...recorder.ring.part(n, recorder.ring.start, recorder.ring.end)];
  assert.deepEqual(part(1), [5, 7, NaN, 1]);
  assert.deepEqual(part(2), [NaN, 2, NaN, NaN]);
  assert.deepEqual(told.find(([what]) => what === "trigger"), ["trigger", 9]);
  assert.deepEqual([recorder.dropped, recorder.unit("rate a")], [2, "mm/s"]);
  given.listeners.state({ state: "lost" });
  assert.equal(recorder.state, "idle");
  given.listeners.state({ state: "open" });
  await new Promise((resolve) => setImmediate(resolve));
  assert.deepEqual([recorder.state, recorder.scope], ["running", 2]);
  await recorder.stop();
  assert.deepEqual(given.requests.at(-1), ["scope.stop", { scope: 2 }]);
});
