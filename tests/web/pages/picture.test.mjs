import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { Columns, Grid, extent, rowAt } = await load("scope/columns.js");
const { Raster, over, wordOf } = await load("scope/raster.js");
const { Roll } = await load("scope/roll.js");
const { fitted, kept } = await load("scope/scale.js");
const { Ring } = await load("scope/ring.js");

/** A generator of numbers that is the same in each run. */
function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

function source(times, ...columns) {
  return { times: Float64Array.from(times), begin: 0, end: times.length,
    columns: columns.map((each) => Float64Array.from(each)) };
}

/** Columns of a picture by their numbers, found out as a strip does it. */
function follow(grid, columns, given, range) {
  grid.place(range);
  const last = given.end > given.begin ? given.times[given.end - 1] : -Infinity;
  const parts = grid.missing(last);
  for (const n of [0, 2]) {
    if (parts[n + 1] > parts[n]) columns.find(given, given.columns[0], parts[n], parts[n + 1]);
  }
  return parts[1] - parts[0] + parts[3] - parts[2];
}

function shown(grid, { low, high }) {
  return Array.from({ length: grid.width }, (_, n) => {
    const slot = grid.slot(grid.first + n);
    return [low[slot], high[slot]];
  });
}

/** What a column shows by its definition: values at its edges and of the samples in it. */
function byDefinition({ times, begin, end, columns: [values] }, from, to) {
  let [low, high] = [Infinity, -Infinity];
  const take = (value) => {
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (let n = begin; n < end; n += 1) {
    if (Number.isFinite(values[n]) && times[n] >= from && times[n] < to) take(values[n]);
    if (n === begin || !Number.isFinite(values[n]) || !Number.isFinite(values[n - 1])) continue;
    for (const edge of [from, to]) {
      if (times[n - 1] < edge && edge <= times[n] && (edge < to || times[n - 1] < to)) {
        const part = (edge - times[n - 1]) / (times[n] - times[n - 1]);
        take(values[n - 1] + part * (values[n] - values[n - 1]));
      }
    }
  }
  return [low, high];
}

const close = (a, b) => a === b || Math.abs(a - b) < 1e-9;

test("a row is found by its time", () => {
  const given = source([1, 2, 2, 5], [0, 0, 0, 0]);
  assert.deepEqual([0, 1, 2, 3, 5, 6].map((time) => rowAt(given, time)), [0, 0, 1, 3, 3, 4]);
});

test("each column has the lowest and the highest value of the line, few samples or many", () => {
  for (let seed = 1; seed < 120; seed += 1) {
    const next = random(seed);
    const rows = 1 + Math.floor(400 * next());
    const times = [];
    let time = 10 * next();
    for (let n = 0; n < rows; n += 1) times.push(time += 0.0017 + 0.01 * next());
    const given = source(times, times.map(() => (next() < 0.05 ? NaN : next() - 0.5)));
    const grid = new Grid(1 + Math.floor(300 * next()));
    const columns = new Columns(grid);
    const from = times[0] - 1 + 3 * next();
    follow(grid, columns, given, [from, from + 0.05 + 4 * next()]);
    shown(grid, columns).forEach(([low, high], n) => {
      const left = grid.origin + (grid.first + n) * grid.step;
      const wanted = byDefinition(given, left, left + grid.step);
      assert.ok(close(low, wanted[0]) && close(high, wanted[1]),
        `seed ${seed}, column ${n}: ${[low, high]} for ${wanted}`);
    });
  }
});

test("a picture that rolls, pans and gets samples late is the one that is made at once", () => {
  for (let seed = 1; seed < 60; seed += 1) {
    const next = random(seed);
    const ring = new Ring(2, 300 + Math.floor(2000 * next()));
    const grid = new Grid(20 + Math.floor(200 * next()));
    const columns = new Columns(grid);
    const width = 0.05 + next();
    let time = 0;
    let edge = 0;
    let found = 0;
    for (let n = 0; n < 80; n += 1) {
      const rows = Math.floor(60 * next());
      const times = Array.from({ length: rows }, () => (time += 0.001));
      if (next() < 0.1) ring.gap();
      ring.append([Float64Array.from(times), Float64Array.from(times, () => next())]);
      edge = next() < 0.1 ? time * next() : edge + (time - edge) * next();
      const given = { times: ring.columns[0], begin: ring.start, end: ring.end,
        columns: [ring.columns[1]] };
      found += follow(grid, columns, given, [edge - width, edge]);
      const fresh = new Grid(grid.width);
      const again = new Columns(fresh);
      Object.assign(fresh, { origin: grid.origin, step: grid.step });
      follow(fresh, again, given, [edge - width, edge]);
      assert.equal(fresh.first, grid.first);
      // rows may have left the ring whose columns are still shown
      const there = shown(fresh, again);
      shown(grid, columns).forEach((each, k) => {
        const left = grid.origin + (grid.first + k - 1) * grid.step;
        if (left > ring.first) {
          assert.ok(each.every((value, at) => close(value, there[k][at])), `seed ${seed}, step ${n}`);
        }
      });
    }
    assert.ok(found < 80 * grid.width);
  }
});

test("only what is new is found out while it rolls", () => {
  const grid = new Grid(1000);
  const columns = new Columns(grid);
  const times = Array.from({ length: 20_000 }, (_, n) => n / 1000);
  const given = source(times, times.map((time) => Math.sin(time)));
  given.end = 5001;
  assert.equal(follow(grid, columns, given, [0, 5]), 1000);
  for (let n = 1; n < 100; n += 1) {
    given.end = 5001 + 20 * n;
    assert.ok(follow(grid, columns, given, [0.02 * n, 5 + 0.02 * n]) <= 6);
  }
  grid.place([3, 4]);
  assert.deepEqual(grid.missing(7), [0, 1000, 1000, 1000]);
});

test("a peak of one sample is seen wherever it is", () => {
  for (let row = 0; row < 5000; row += 37) {
    const times = Array.from({ length: 5000 }, (_, n) => n / 1000);
    const given = source(times, times.map((_, n) => (n === row ? 100 : 0)));
    const grid = new Grid(200);
    const columns = new Columns(grid);
    follow(grid, columns, given, [0, 5]);
    assert.deepEqual(extent([columns]), [0, 100]);
    const high = shown(grid, columns).map((each) => each[1]);
    assert.ok(Math.abs(high.indexOf(Math.max(...high)) - Math.floor(row / 25)) <= 1);
  }
  assert.deepEqual(extent([]), [null, null]);
});

test("a line of whole pixels is opaque, its edges are as much as they are covered", () => {
  const raster = new Raster(3, 10);
  const red = wordOf("#ff0000");
  assert.equal(red, 0x0000ff);
  assert.equal(wordOf("#0072b2"), 0xb27200);
  raster.line(1, 2.25, 5.5, red);
  const alphas = Array.from({ length: 10 }, (_, y) => raster.pixels[3 * y + 1] >>> 24);
  assert.deepEqual(alphas, [0, 0, 191, 255, 255, 128, 0, 0, 0, 0]);
  assert.ok(raster.pixels.every((word, at) => at % 3 === 1 || word === 0));
  raster.line(0, -50, 1000, red);
  raster.line(2, -5, -1, red);
  raster.line(2, 10, 11, red);
  assert.ok(raster.pixels.every((word, at) => at % 3 === 1 || (word !== 0) === (at % 3 === 0)));
  raster.clear(0);
  assert.ok(raster.pixels.every((word, at) => at % 3 === 1 || word === 0));
});

test("colours are mixed as by light", () => {
  const [red, blue] = [wordOf("#ff0000"), wordOf("#0000ff")];
  assert.equal(over(0, red, 1), 0xff0000ff);
  assert.equal(over(0, red, 0), 0);
  assert.equal(over(0xff0000ff, blue, 0.5), 0xff800080);
  const twice = over(over(0, red, 0.5), red, 0.5);
  assert.ok(Math.abs((twice >>> 24) - 191) <= 1 && (twice & 0xffffff) === red);
});

test("dashes roll with the trace, and a peak is not lost between them", () => {
  const grid = new Grid(40);
  const columns = new Columns(grid);
  const times = Array.from({ length: 400 }, (_, n) => n / 10);
  const look = { word: wordOf("#00795a"), width: 1, opacity: 1, dash: [4, 4] };
  const painted = (given, first) => {
    grid.forget();
    follow(grid, columns, given, [first, first + 40]);
    const raster = new Raster(40, 100);
    raster.trace(grid, columns, [-1, 11], look, grid.first, grid.first + 40);
    return Array.from({ length: 40 }, (_, n) => {
      const slot = grid.slot(grid.first + n);
      return Array.from({ length: 100 }, (_, y) => raster.pixels[40 * y + slot] >>> 24)
        .some((alpha) => alpha > 0);
    });
  };
  const flat = painted(source(times, times.map(() => 0)), 0);
  assert.equal(flat.filter(Boolean).length, 20);
  const later = painted(source(times.map((time) => time + 3), times.map(() => 0)), 3);
  assert.deepEqual(later.slice(0, 37), flat.slice(3));
  const peak = painted(source(times, times.map((time) => (time === 5.5 ? 10 : 0))), 0);
  assert.ok(!flat[5] && peak[5]);
});

test("thick lines are as thick where they are steep", () => {
  const grid = new Grid(9);
  const columns = new Columns(grid);
  const given = source([0, 4.5, 4.6, 4.7, 9], [0, 0, 10, 0, 0]);
  follow(grid, columns, given, [0, 9]);
  const raster = new Raster(9, 60);
  raster.trace(grid, columns, [-5, 15], { word: 1, width: 3, opacity: 1, dash: [] }, 0, 9);
  const high = Array.from({ length: 9 }, (_, n) => raster.pixels[9 * 25 + n] !== 0);
  assert.deepEqual(high.flatMap((each, n) => (each ? [n] : [])), [3, 4, 5]);
});

test("the edge follows evenly and comes to rest on the newest sample", () => {
  const roll = new Roll();
  const steps = [];
  let before = null;
  let [last, now] = [100, 0];
  for (let frame = 0; frame < 600; frame += 1) {
    now += 1000 / 60;
    if (frame % 3 === 0) last += 0.05; // blocks of 50 ms
    const edge = roll.step(last, now, 5);
    assert.ok(edge <= last && last - edge < 0.2);
    if (frame > 100) steps.push(edge - before);
    assert.ok(before === null || edge >= before);
    before = edge;
  }
  const even = 1 / 60;
  assert.ok(steps.every((each) => each > 0.5 * even && each < 1.6 * even));
  for (let frame = 0; frame < 120; frame += 1) roll.step(last, now += 1000 / 60, 5);
  assert.equal(roll.edge, last);
  assert.equal(roll.step(last + 10, now, 5), last + 10); // far away: at once
  assert.equal(roll.step(3, now, 5), 3); // another time base
  assert.equal(roll.step(4, now, 5, false), 4); // less motion
});

test("a scale is kept while what is seen fills it", () => {
  assert.deepEqual(fitted(null, null), [0, 1]);
  assert.deepEqual(fitted(4, 4), [2, 6]);
  assert.deepEqual(fitted(0, 0), [-0.5, 0.5]);
  assert.ok(fitted(-Number.MAX_VALUE, Number.MAX_VALUE).every(Number.isFinite));
  for (let seed = 1; seed < 200; seed += 1) {
    const next = random(seed);
    const low = 100 * (next() - 0.5);
    const high = low + 0.001 + 50 * next();
    const [bottom, top] = fitted(low, high);
    assert.ok(bottom < low && high < top && (high - low) / (top - bottom) > 0.85);
    assert.deepEqual(kept(null, low, high), [bottom, top]);
    const a = low + (high - low) * 0.1 * next();
    assert.deepEqual(kept([bottom, top], a, high), [bottom, top]);
    assert.deepEqual(kept([bottom, top], low, top + 1), fitted(low, top + 1));
    assert.deepEqual(kept([bottom, top], low, low + (high - low) / 2), fitted(low, low + (high - low) / 2));
  }
});
