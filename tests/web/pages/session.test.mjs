import assert from "node:assert/strict";
import { test } from "node:test";
import { load, settle } from "./support.mjs";

const { Session } = await load("session.js");

/** A connection by hand: the newest watch and listener, and what has ended. */
function began({ answer = () => Promise.resolve({}) } = {}) {
  const seen = { said: [], failed: [], closed: 0, ended: [] };
  const connection = {
    hello: { control: true, features: ["axes"] },
    call: (name, values) => answer(name, values),
    watch(topic, values, receive, failed) {
      Object.assign(seen, { receive, fail: failed });
      return () => seen.ended.push(topic);
    },
    on: (event) => () => seen.ended.push(event),
  };
  const session = new Session(connection, null, {
    say: (text) => seen.said.push(text),
    fail: (error) => {
      seen.failed.push(error.message);
      return () => { seen.closed += 1; };
    },
  });
  return { session, seen };
}

test("what a page has begun ends with it, and nothing begins after it", () => {
  const { session, seen } = began();
  session.watch("axes", {}, () => {});
  session.on("state", () => {});
  session.watch("log", {}, () => {})();
  session.leave();
  session.watch("late", {}, () => {})();
  assert.deepEqual(seen.ended, ["log", "axes", "state"]);
});

test("a refusal of a watch is shown until a value comes", () => {
  const { session, seen } = began();
  const values = [];
  session.watch("axes", {}, (value) => values.push(value));
  seen.fail(new Error("no link"));
  seen.fail(new Error("still none"));
  seen.receive("value", 0);
  seen.receive("next", 0);
  assert.deepEqual([seen.failed, seen.closed, values],
    [["no link", "still none"], 2, ["value", "next"]]);
});

test("states are drawn once a frame, the newest only, and not after the page", () => {
  const { session, seen } = began();
  const frames = [];
  const drawn = [];
  session.draw("axes", {}, (value) => drawn.push(value), (run) => frames.push(run));
  for (const value of [1, 2, 3]) seen.receive(value, 0);
  assert.equal(frames.length, 1);
  frames.pop()();
  seen.receive(4, 0);
  session.leave();
  frames.pop()();
  assert.deepEqual(drawn, [3]);
});

test("a button says what it did, or what was refused", async () => {
  const { session, seen } = began({
    answer: (name) => (name === "good" ? Promise.resolve(7) : Promise.reject(new Error("no"))),
  });
  assert.equal(await session.do("good", {}, "done"), 7);
  assert.equal(await session.do("bad", {}, "done"), undefined);
  session.leave();
  await session.do("bad", {});
  await settle();
  assert.deepEqual([seen.said, seen.failed], [["done"], ["no"]]);
});
