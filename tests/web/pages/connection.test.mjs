import assert from "node:assert/strict";
import { test } from "node:test";
import { Clock, Socket, load, settle } from "./support.mjs";

const { Connection, NotConnected, Refusal, addressOf } = await load("connection.js");
const HELLO = { name: "demo", target: "1.2.3.4.1.1", control: true, features: ["axes"] };

function dialled() {
  const sockets = [];
  const clock = new Clock();
  const connection = new Connection("ws://x/ws", {
    clock,
    dial: (url) => {
      sockets.push(new Socket(url));
      return sockets.at(-1);
    },
  });
  const states = [];
  connection.on("state", ({ state }) => states.push(state));
  connection.open();
  return { connection, sockets, clock, states };
}

async function opened() {
  const all = dialled();
  await greet(all.sockets[0]);
  return all;
}

async function greet(socket) {
  socket.onopen();
  socket.answer("hello", HELLO);
  await settle();
}

test("the first call is hello, and the state follows", async () => {
  const { connection, sockets, states } = await opened();
  assert.deepEqual(sockets[0].sent[0], { id: 1, call: "hello", with: {} });
  assert.deepEqual(states, ["connecting", "open"]);
  assert.deepEqual(connection.hello, HELLO);
});

test("answers go to their calls in any order", async () => {
  const { connection, sockets: [socket] } = await opened();
  const first = connection.call("a", { x: 1 });
  const second = connection.call("b");
  const [a, b] = socket.sent.slice(-2);
  assert.deepEqual(a.with, { x: 1 });
  socket.say({ id: b.id, result: "second" });
  socket.say({ id: a.id, result: "first" });
  assert.deepEqual([await first, await second], ["first", "second"]);
});

test("a refusal has code, name and link", async () => {
  const { connection, sockets: [socket] } = await opened();
  const call = connection.call("axes.do");
  const error = { text: "not ready", code: 17185, name: "AXIS_NOT_READY", link: "https://x/#y" };
  socket.say({ id: socket.sent.at(-1).id, error });
  await assert.rejects(call, (refusal) => {
    assert.ok(refusal instanceof Refusal);
    assert.deepEqual([refusal.message, refusal.code, refusal.codeName, refusal.link],
      Object.values(error));
    return true;
  });
});

test("without a connection nothing is sent, and what waits is told", async () => {
  const { connection, sockets } = await opened();
  const call = connection.call("a");
  sockets[0].close(1006);
  await assert.rejects(call, NotConnected);
  await assert.rejects(connection.call("b"), NotConnected);
});

test("a call without an answer ends", async () => {
  const { connection, clock } = await opened();
  const call = connection.call("a");
  clock.pass(20_000);
  await assert.rejects(call, /a: no answer within 20 s/);
  assert.equal(clock.waiting, 0);
});

test("it dials again, later and later, and soon again after a success", async () => {
  const { sockets, clock, states } = dialled();
  const pauses = [];
  for (let round = 0; round < 7; round++) {
    const before = clock.now;
    sockets.at(-1).close(1006);
    const known = sockets.length;
    while (sockets.length === known) clock.pass(50);
    pauses.push(clock.now - before);
  }
  assert.deepEqual(pauses, [250, 500, 1000, 2000, 4000, 5000, 5000]);
  await greet(sockets.at(-1));
  assert.equal(states.at(-1), "open");
  sockets.at(-1).close(1006);
  const known = sockets.length;
  clock.pass(250);
  assert.equal(sockets.length, known + 1);
});

test("watches get values, and go on after a loss under their new numbers", async () => {
  const { connection, sockets, clock } = await opened();
  const seen = [];
  connection.watch("axes", { every: 0.1 }, (value, lost) => seen.push([value, lost]));
  assert.deepEqual(sockets[0].sent.at(-1).with, { topic: "axes", every: 0.1 });
  sockets[0].answer("watch", { watch: 3 });
  await settle();
  sockets[0].say({ event: "data", watch: 3, value: "one", lost: 0 });
  sockets[0].close(1006);
  clock.pass(250);
  await greet(sockets[1]);
  sockets[1].answer("watch", { watch: 1 });
  await settle();
  sockets[1].say({ event: "data", watch: 1, value: "two", lost: 5 });
  sockets[1].say({ event: "data", watch: 3, value: "not ours", lost: 0 });
  assert.deepEqual(seen, [["one", 0], ["two", 5]]);
});

test("a value that comes before the number of its watch is not lost", async () => {
  const { connection, sockets: [socket] } = await opened();
  const seen = [];
  connection.watch("log", {}, (value) => seen.push(value));
  socket.say({ event: "data", watch: 1, value: "early", lost: 0 });
  socket.answer("watch", { watch: 1 });
  await settle();
  assert.deepEqual(seen, ["early"]);
});

test("a watch that has ended is silent, whenever its number comes", async () => {
  const { connection, sockets: [socket] } = await opened();
  const seen = [];
  const end = connection.watch("axes", {}, (value) => seen.push(value));
  end();
  end();
  socket.answer("watch", { watch: 7 });
  await settle();
  assert.deepEqual(socket.sent.at(-1), { id: 3, call: "unwatch", with: { watch: 7 } });
  socket.say({ event: "data", watch: 7, value: 1, lost: 0 });
  assert.deepEqual(seen, []);
});

test("a watch that fails is told each time", async () => {
  const { connection, sockets: [socket] } = await opened();
  const failures = [];
  connection.watch("axis", { axis: 9 }, () => {}, (error) => failures.push(error.message));
  socket.say({ id: socket.sent.at(-1).id, error: { text: "no such axis" } });
  connection.watch("axis", { axis: 8 }, () => {}, (error) => failures.push(error.message));
  socket.answer("watch", { watch: 4 });
  await settle();
  socket.say({ event: "data", watch: 4, value: null, error: { text: "gone" } });
  assert.deepEqual(failures, ["no such axis", "gone"]);
});

test("blocks of samples and events go to their listeners", async () => {
  const { connection, sockets: [socket] } = await opened();
  const blocks = [];
  const told = [];
  const end = connection.on("block", (block) => blocks.push(block.byteLength));
  connection.on("connection", (event) => told.push(event.state));
  socket.onmessage({ data: new ArrayBuffer(16) });
  socket.say({ event: "connection", state: "lost", text: "gone" });
  end();
  socket.onmessage({ data: new ArrayBuffer(8) });
  assert.deepEqual([blocks, told], [[16], ["lost"]]);
});

test("closing is for good", async () => {
  const { connection, sockets, clock, states } = await opened();
  connection.close();
  clock.pass(60_000);
  assert.deepEqual([sockets.length, sockets[0].closed, states.at(-1)], [1, 1000, "closed"]);
});

test("the address is beside the page; a token goes along", () => {
  const place = { protocol: "http:", host: "h:8080", search: "" };
  assert.equal(addressOf(place), "ws://h:8080/ws");
  assert.equal(addressOf({ ...place, protocol: "https:", search: "?token=a%26b" }),
    "wss://h:8080/ws?token=a%26b");
});
