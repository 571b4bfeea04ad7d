import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./support.mjs";

const { View, fragment, parse } = await load("view.js");

function view(hash) {
  const place = { hash };
  const kept = [];
  const past = { replaceState: (state, title, next) => {
    place.hash = next;
    kept.push(next);
  } };
  return { view: new View(place, past), place, kept };
}

test("whatever a view holds comes back from its address", () => {
  const texts = ["", "MAIN.fb[3].x", "a&b=c?d#e", "Ü \u2028 %", "<script>", "+ +", "%zz"];
  for (const text of texts) {
    const { page, values } = parse(fragment("axes", { search: text, other: 1 }));
    assert.deepEqual([page, values.get("search") ?? "", values.get("other")], ["axes", text, "1"]);
  }
});

test("addresses by hand do no harm", () => {
  assert.equal(parse("#%zz").page, "");
  assert.equal(parse("").page, "");
  assert.equal(parse("#axes?").page, "axes");
  assert.equal(parse("#axes?axis=2&axis=3").values.get("axis"), "2");
});

test("changes are kept in place, and only if there are any", () => {
  const { view: shown, place, kept } = view("#axes?axis=2");
  shown.set({ group: "limits" });
  shown.set({ group: "limits" });
  assert.deepEqual([place.hash, kept.length], ["#axes?axis=2&group=limits", 1]);
  shown.set({ group: null, axis: "" });
  assert.equal(place.hash, "#axes");
  assert.equal(shown.get("axis", "none"), "none");
});

test("going to a page is a new entry", () => {
  const { view: shown, place, kept } = view("#axes?axis=2");
  shown.go("symbols", { search: "x" });
  assert.deepEqual([place.hash, kept.length, shown.page], ["#symbols?search=x", 0, "symbols"]);
});
