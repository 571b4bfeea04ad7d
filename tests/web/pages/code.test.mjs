import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { drafted, jump, lines, valuesOf } = await load("code_text.js");

test("a place is an offset, and one outside is the nearest inside", () => {
  const text = "ab\n\u{1F600}cd\n";
  assert.equal(lines(text), 3);
  assert.equal(jump(text, 1, 1), 0);
  assert.equal(jump(text, 2, 2), 5); // behind a sign of two UTF-16 units
  assert.equal(jump(text, 2, 99), 7);
  assert.equal(jump(text, 99, 1), 8);
  assert.equal(jump("", 0, 0), 0);
});

test("a text that is as it was saved is no draft", () => {
  assert.equal(drafted(["a", "b"], ["a", "b"]), false);
  assert.equal(drafted(["a", "b"], ["a", "c"]), true);
  assert.equal(drafted([], ["a"]), true);
});

test("programs and lists of variables have values, blocks have none", () => {
  const file = (text) => valuesOf([{ name: "", kind: "file", text }]);
  assert.deepEqual(file("program Main\nVAR END_VAR\n(* PROGRAM No *) x := 'PROGRAM Not';\nPROGRAM B"), ["Main", "B"]);
  assert.deepEqual(file("FUNCTION_BLOCK FB_A\nVAR_INPUT END_VAR"), []);
  const part = (name, kind, text) => ({ name, kind, text });
  assert.deepEqual(valuesOf([part("GVL", "declaration", "{attribute 'x'}\nVAR_GLOBAL\nEND_VAR")]), ["GVL"]);
  assert.deepEqual(valuesOf([part("P", "declaration", "PROGRAM P"), part("P", "implementation", "PROGRAM Q")]), ["P"]);
});

const { parts } = await load("drawing.js");

test("a picture has lines with power and without, texts, and active steps", () => {
  const { paths, texts, columns, rows } = parts(["├═┤ a ├─( q )", "* [Work]  main Run"]);
  assert.deepEqual([columns, rows], [18, 2]);
  assert.deepEqual(texts.map(({ text, row, column }) => [text, row, column]),
    [["a", 0, 4], ["( q )", 0, 8], ["* [Work]", 1, 0], ["main Run", 1, 10]]);
  assert.deepEqual(texts.map(({ isActive }) => isActive), [false, false, true, true]);
  assert.equal(paths.power.length, 4); // both halves of the line, and the ends that it meets
  assert.ok(paths.plain.length > 4);
});
