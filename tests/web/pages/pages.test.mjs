import assert from "node:assert/strict";
import { readFile, readdir } from "node:fs/promises";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { PAGES as FOLDER, load } from "./support.mjs";

const { PAGES, offered } = await load("pages.js");
const FIRST_PAGE_BYTES = 80_000;

async function files(ending) {
  const names = await readdir(FOLDER, { recursive: true });
  return names.filter((name) => name.endsWith(ending) && !name.startsWith("vendor"));
}

const read = (name) => readFile(new URL(name, FOLDER), "utf-8");

test("each page of the list has a module that can be mounted", async () => {
  for (const { module } of PAGES) {
    assert.equal(typeof (await load(module)).mount, "function", module);
  }
  assert.equal(new Set(PAGES.map(({ name }) => name)).size, PAGES.length);
});

test("pages are offered by what the target has", () => {
  const names = (features) => offered(features).map(({ name }) => name);
  assert.deepEqual(names([]), []);
  assert.deepEqual(names(["overview", "bus"]), ["overview", "drives"]);
  assert.deepEqual(names(["overview", "traffic", "axes"]), ["overview", "axes", "log"]);
  assert.deepEqual(names(["router", "log", "traffic"]), ["router", "log"]);
});

test("no module makes HTML of texts, runs texts, or asks other hosts", async () => {
  for (const name of await files(".js")) {
    const code = await read(name);
    assert.doesNotMatch(code,
      /innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function/, name);
    const hosts = (code.match(/https?:\/\/[^\s"'`]+/g) ?? [])
      .filter((url) => !/^http:\/\/(www\.w3\.org\/2000\/svg|localhost\/)/.test(url));
    assert.deepEqual(hosts, [], name);
  }
  for (const name of [...(await files(".html")), ...(await files(".css"))]) {
    const text = await read(name);
    assert.doesNotMatch(text, /https?:\/\/|@import|\sstyle=|\son[a-z]+=|<script>/, name);
  }
});

/** What the browser loads until the overview is shown. */
test("the first page is small", async () => {
  const seen = new Set(["index.html", "style.css", "theme.js", "icon.svg"]);
  const walk = async (name) => {
    if (seen.has(name)) return;
    seen.add(name);
    for (const [, other] of (await read(name)).matchAll(/from "\.\/([^"]+)"/g)) await walk(other);
  };
  await walk("app.js");
  await walk("overview.js");
  let plain = 0;
  let packed = 0;
  for (const name of seen) {
    const data = await read(name);
    plain += Buffer.byteLength(data);
    packed += gzipSync(data).length;
  }
  assert.ok(plain < FIRST_PAGE_BYTES, `${plain} bytes, ${packed} packed`);
});

test("what is preloaded is there", async () => {
  const html = await read("index.html");
  for (const [, name] of html.matchAll(/(?:href|src)="([^"#]+)"/g)) await read(name);
});
