import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { drawCurve, extent, nearest, place, thinned, ticks } = await load("curves.js");
const { Camera, VIEWS, boundsOf } = await load("projection.js");
const { Path, drawPath } = await load("channels.js");
const { Plan } = await load("plan.js");

const close = (found, wanted) => found.forEach((value, n) =>
  assert.ok(Math.abs(value - wanted[n]) < 1e-9, `${found} is not ${wanted}`));

/** A context that keeps what is drawn and refuses what is no number. */
function context() {
  const drawn = [];
  return new Proxy({ drawn }, {
    get: (kept, name) => kept[name] ?? ((...values) => {
      for (const value of values) {
        if (typeof value === "number") assert.ok(Number.isFinite(value), `${String(name)}(${values})`);
      }
      drawn.push([name, ...values]);
    }),
    set: () => true,
  });
}

test("an extent has room, and none without values", () => {
  assert.deepEqual(extent([3, -1, NaN, 2, Infinity, null]), [-1, 3]);
  assert.deepEqual(extent([5, 5]), [4.5, 5.5]);
  assert.deepEqual(extent([0]), [-1, 1]);
  for (const empty of [[], [NaN], undefined]) assert.equal(extent(empty), null);
});

test("ticks are round, within the ends, and few", () => {
  assert.deepEqual(ticks([0, 360], 4), [0, 100, 200, 300]);
  assert.deepEqual(ticks([-1, 1], 4), [-1, -0.5, 0, 0.5, 1]);
  for (const span of [[1, 1], [2, 1], [NaN, 1], [0, Infinity]]) assert.deepEqual(ticks(span), []);
  for (const power of [-300, -9, 0, 9, 300]) {
    const found = ticks([0, 10 ** power], 5);
    assert.ok(found.length >= 3 && found.length <= 11, `${power}: ${found}`);
  }
});

test("fewer rows have the first and the last", () => {
  assert.deepEqual(thinned(3, 10), [0, 1, 2]);
  const rows = thinned(500, 73);
  assert.deepEqual([rows.length, rows[0], rows.at(-1)], [73, 0, 499]);
  assert.equal(new Set(rows).size, 73);
});

test("the value under the cursor is the nearest", () => {
  assert.deepEqual([-5, 4, 6, 99].map((value) => nearest([0, 10, 20], value)), [0, 0, 1, 2]);
  assert.equal(nearest([7], 1), 0);
  assert.deepEqual([place(0, 400), place(1e9, 400)], [0, 1]);
});

test("a curve with gaps is drawn in pieces", () => {
  const kept = context();
  drawCurve(kept, 400, 200, {}, { x: [0, 1, 2, 3], y: [0, NaN, 1, 2], kind: "accent", at: 1 });
  const empty = context();
  drawCurve(empty, 400, 200, {}, { x: [], y: [], kind: "accent" });
  assert.equal(empty.drawn.at(-1)[1], "no values");
  assert.ok(kept.drawn.length > 10);
});

test("each view shows its plane", () => {
  const seen = (view) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => {
    const camera = new Camera(view);
    return camera.turned()(axis).slice(0, 2);
  });
  const planes = { XY: [[1, 0], [0, 1], [0, 0]], XZ: [[1, 0], [0, 0], [0, 1]], YZ: [[0, 0], [1, 0], [0, 1]] };
  for (const [view, wanted] of Object.entries(planes)) {
    seen(view).forEach((found, n) => close(found, wanted[n]));
  }
  assert.equal(new Camera("constructor").view, "3D");
});

test("turning keeps lengths, and all fits in the picture from every side", () => {
  const bounds = boundsOf([[-30, 0, 5], [70, 40, 25], [NaN, 0, 0]]);
  const camera = new Camera();
  for (let n = 0; n < 40; n += 1) {
    camera.move(0.37 * n, n % 2 ? 0.21 : -0.17);
    const turned = camera.turned()([3, -4, 12]);
    assert.ok(Math.abs(Math.hypot(...turned) - 13) < 1e-9);
    const onto = camera.onto(400, 300, bounds);
    for (const x of [-30, 70]) for (const y of [0, 40]) for (const z of [5, 25]) {
      const [right, down] = onto([x, y, z]);
      assert.ok(right >= 0 && right <= 400 && down >= 0 && down <= 300);
    }
  }
});

test("keys turn, zoom within bounds and go back", () => {
  const camera = new Camera("XZ");
  for (let n = 0; n < 100; n += 1) assert.ok(camera.key("ArrowUp") && camera.key("+"));
  assert.ok(camera.tilt <= Math.PI / 2 && camera.zoom <= 50);
  for (let n = 0; n < 200; n += 1) camera.key("-");
  assert.ok(camera.zoom >= 0.05);
  assert.ok(camera.key("0"));
  assert.deepEqual([camera.turn, camera.tilt, camera.zoom], [VIEWS.XZ.turn, VIEWS.XZ.tilt, 1]);
  for (const key of ["a", "5", "toString", "Tab"]) assert.equal(camera.key(key), false);
});

test("a path takes what moved, and is bounded", () => {
  const path = new Path(10);
  assert.ok(path.add([0, 0, 0, 0]));
  assert.equal(path.add([0, 0, 0, 0]), false);
  for (const broken of [null, [1, 2], [NaN, 0, 0], "1,2,3"]) assert.equal(path.add(broken), false);
  for (let n = 1; n < 100; n += 1) path.add([n, 0, 0, 0]);
  assert.deepEqual([path.points.length, path.points[0][0]], [10, 90]);
  path.fill([[1, 2, 3, 0], [null, 0, 0, 0]]);
  assert.deepEqual(path.points, [[1, 2, 3, 0]]);
});

test("a path of one point, of none, and of huge ones is drawn", () => {
  for (const points of [[], [[1, 1, 1, 0]], [[-1e300, 0, 0, 0], [1e300, 0, 0, 1]]]) {
    drawPath(context(), 400, 300, {}, new Camera(), { points, tool: points[0] ?? null });
  }
});

test("the tool is on the piece of its block that is nearest", () => {
  const plan = new Plan([[0, 0, 0, true, 0], [3, 4, 0, true, 1], [13, 4, 0, false, 2],
    [13, 14, 0, false, 3], [13, 4, 0, false, 3], [0, 4, 0, false, 5]]);
  assert.equal(plan.length, 48);
  const place = (tool, block) => {
    const found = plan.find(tool, block);
    return found && [found.piece, found.length];
  };
  assert.deepEqual(place([8, 4, 0], 2), [2, 10]);
  assert.deepEqual(place([8, 4.5, 1], 2), [2, 10]);
  assert.deepEqual(place([13, 9, 0], 3), [3, 20]);
  assert.deepEqual(place([8, 4, 0], 5), [5, 40]); // the same place on the way back
  assert.deepEqual(place([-9, 4, 0], 5), [5, 48]);
  for (const [tool, block] of [[null, 2], [[8, 4, 0], 0], [[8, 4, 0], 4], [[8, 4, 0], 9]]) {
    assert.equal(place(tool, block), null);
  }
  assert.equal(new Plan().find([0, 0, 0], 1), null);
});

test("what is planned is drawn from where the tool is, in two colours", () => {
  const points = [[0, 0, 0, true, 0], [10, 0, 0, true, 1], [10, 10, 0, false, 2], [0, 10, 0, false, 3]];
  const plan = new Plan(points);
  for (const view of Object.keys(VIEWS)) {
    const kept = context();
    drawPath(kept, 300, 300, {}, new Camera(view), { points: [], tool: [10, 5, 0], plan,
      at: plan.find([10, 5, 0], 2) });
    assert.equal(kept.drawn.filter(([name]) => name === "lineTo").length > 4, true);
  }
  const all = context();
  drawPath(all, 300, 300, {}, new Camera("XY"), { points: [], tool: null, plan });
  assert.ok(all.drawn.length > 10);
});
