/** The shell: connection, navigation, the Stop button, theme, help, messages. */

import { Connection, NotConnected, addressOf } from "./connection.js";
import { h, link, mark, show, typing } from "./dom.js";
import { code } from "./format.js";
import { setSingleKeys, singleKeys, withModifier } from "./keys.js";
import { PAGES, offered } from "./pages.js";
import { Session } from "./session.js";
import { View, fragment } from "./view.js";

const MESSAGES = 4;
const REFRESH = 3000;
const SHORTCUTS = [
  ["F6 or Ctrl+.", "stop every axis, from every page"],
  ["1 … 9", "go to a page"],
  ["?", "this help"],
  ["/", "search on this page; Enter watches the first symbol, adds the first channel"],
  ["F1 F2 F3 F4", "one axis: jog fast back, back, forward, fast forward, while held"],
  ["F5", "one axis: start the move that is filled in"],
  ["F8, F9", "one axis: reset, home"],
  ["↑ ↓ ← →", "symbols: walk through the tree; Home, End; Enter watches a symbol"],
  ["Space", "scope: run and stop"],
  ["T, C", "scope: trigger on and off, the other cursor"],
  ["← →", "scope: move the cursor, with Shift by one row; cams: along the curve"],
  ["+ −", "scope: zoom"],
  ["Esc", "scope: clear the cursors, follow the newest samples"],
  ["↑ ↓ ← → + − 0", "pictures of paths and machines: turn, zoom, show all"],
];

const at = (id) => document.getElementById(id);
const connection = new Connection(addressOf());
const view = new View();
let page = null;
let openings = 0;
let targetThere = true;
let met = "";
let offers = "";

// messages ------------------------------------------------------------------------------------

let quietAfter = null;

function say(text) {
  clearTimeout(quietAfter);
  show(at("said"), text);
  quietAfter = setTimeout(() => show(at("said"), ""), 4000);
}

function fail(error) {
  const notices = at("notices");
  const number = error.code ? ` ${code(error.code)}` : "";
  const name = [error.codeName, number].filter(Boolean).join("");
  const text = h("p", {}, error.message, " ");
  if (name) text.append(link(error.link, name.trim()));
  const notice = h("div", { class: "notice" }, text);
  const close = h("button", { type: "button", class: "plain", "aria-label": "Close this message" }, "×");
  close.addEventListener("click", () => notice.remove());
  notice.append(close);
  for (const known of [...notices.children]) {
    if (known.firstChild.textContent === text.textContent) known.remove();
  }
  notices.append(notice);
  while (notices.children.length > MESSAGES) notices.firstChild.remove();
  return () => notice.remove();
}

// pages ---------------------------------------------------------------------------------------

function pages() {
  return connection.hello ? offered(connection.hello.features) : [];
}

function drawNavigation() {
  const known = pages();
  at("nav").replaceChildren(
    h("ul", {}, known.map(({ name, title }, number) =>
      h("li", {}, h("a", { href: fragment(name), "data-page": name,
        "aria-keyshortcuts": number < 9 ? String(number + 1) : null }, title)))),
  );
}

/** Show a link in the row of pages of a narrow screen. `scrollIntoView` would let Tab go on there. */
function scrollRowTo(link) {
  const row = at("nav").getBoundingClientRect();
  const { left, right } = link.getBoundingClientRect();
  at("nav").scrollLeft += Math.min(0, left - row.left) + Math.max(0, right - row.right);
}

async function open() {
  const opening = ++openings;
  const known = pages();
  const first = known[0]?.name ?? "overview";
  const wanted = view.page || first;
  const entry = PAGES.find(({ name }) => name === wanted);
  const there = known.includes(entry);
  for (const a of at("nav").querySelectorAll("a")) {
    mark(a, "aria-current", a.dataset.page === wanted ? "page" : null);
    if (a.dataset.page === wanted) scrollRowTo(a);
  }
  const title = entry?.title ?? "No such page";
  let module = null;
  let failure = entry ? "This target does not offer what this page shows." : "There is no such page.";
  if (there) {
    try {
      module = await import(entry.module);
    } catch (error) {
      failure = `This page could not be loaded: ${error.message}`;
    }
    if (opening !== openings) return; // the user has gone on meanwhile
  }
  leave();
  const element = h("div", { id: "page", "data-shows": wanted });
  at("page").replaceWith(element);
  show(at("title"), title);
  document.title = `${title} – ${connection.hello.name || "achse"}`;
  if (module === null) {
    element.append(h("p", {}, failure, " ", h("a", { href: fragment(first) }, "Go to the first page")));
    return;
  }
  const session = new Session(connection, view, { say, fail });
  page = { session, unmount: undefined };
  try {
    page.unmount = module.mount(element, session);
  } catch (error) {
    element.append(h("p", {}, `This page failed: ${error.message}`));
    console.error(error);
  }
}

function leave() {
  page?.session.leave();
  page?.unmount?.();
  page = null;
}

/** Load the module of the first page while the connection is made. */
function foresee() {
  const entry = PAGES.find(({ name }) => name === (view.page || "overview"));
  if (entry) import(entry.module).catch(() => {});
}

// connection ----------------------------------------------------------------------------------

function drawConnection({ state, text }) {
  const words = {
    connecting: "Connecting…",
    open: targetThere ? "Connected" : `Target does not answer${text ? `: ${text}` : ""}`,
    lost: `Connection lost; values are old. Trying again…${text ? ` (${text})` : ""}`,
    closed: "Not connected",
  };
  // dialling again after a loss is still a loss to people
  const kept = document.body.dataset.connection;
  const shown = state === "connecting" && kept === "lost" ? "lost" : state;
  document.body.dataset.connection = shown === "open" && !targetThere ? "mute" : shown;
  if (shown === state) show(at("connection-text"), words[state]);
  const stop = at("stop");
  stop.hidden = connection.hello?.features.includes("router") === true; // it has no axes
  stop.disabled = shown !== "open" || connection.hello?.control !== true
    || !connection.hello.features.includes("axes");
}

function greet(hello) {
  const { name, target, features, control } = hello;
  const same = met === JSON.stringify([target, control]);
  met = JSON.stringify([target, control]);
  if (same && offers === features.join()) return;
  offers = features.join();
  targetThere = hello.connected !== false;
  show(at("station"), [name, target].filter(Boolean).join(" · ") || "achse");
  drawConnection({ state: connection.state, text: "" });
  drawNavigation();
  if (page === null || !same) open();
}

async function stopAll() {
  try {
    await connection.call("axes.do", { axis: null, action: "stop" });
    say("Stop sent to every axis.");
  } catch (error) {
    fail(error);
  }
}

/** A key is pressed in need: the page reports that it did nothing. */
function stopByKey() {
  if (!at("stop").disabled) stopAll();
  else if (connection.state !== "open") fail(new NotConnected("Stop was not sent: not connected to the station."));
  else if (connection.hello?.control !== true) fail(new Error("Stop was not sent: these pages may only look."));
  else fail(new Error("Stop was not sent: the target does not answer, or has no axes."));
}

// theme and help ------------------------------------------------------------------------------

const THEMES = ["system", "light", "dark"];

function theme() {
  return document.documentElement.dataset.theme ?? "system";
}

function drawTheme() {
  at("theme").replaceChildren(h("span", { class: "quiet" }, "Theme: "), theme());
  mark(at("theme"), "aria-label", `Theme: ${theme()}`);
}

function nextTheme() {
  const next = THEMES[(THEMES.indexOf(theme()) + 1) % THEMES.length];
  mark(document.documentElement, "data-theme", next === "system" ? null : next);
  try {
    if (next === "system") localStorage.removeItem("achse.theme");
    else localStorage.setItem("achse.theme", next);
  } catch {
    // without storage it holds until the page is closed
  }
  drawTheme();
}

function drawHelp() {
  const keys = h("input", { type: "checkbox", id: "single-keys" });
  keys.checked = singleKeys();
  keys.addEventListener("change", () => setSingleKeys(keys.checked));
  const close = h("button", { type: "button", class: "main" }, "Close");
  close.addEventListener("click", () => at("help-text").close());
  const { version = "", target = "" } = connection.hello ?? {};
  at("help-text").replaceChildren(
    h("h2", { id: "help-title" }, "Keys"),
    h("table", {}, h("tbody", {}, SHORTCUTS.map(([key, what]) =>
      h("tr", {}, h("th", { scope: "row" }, h("kbd", {}, key)), h("td", {}, what))))),
    h("label", { class: "check" }, keys, " Keys without Ctrl (1 … 9, ?, /, T, C, +, −)"),
    h("p", { class: "dim" }, `achse ${version}, ${target}. The address of this page says what it `
      + "shows: send it to a colleague to show the same."),
    close,
  );
  at("help-text").showModal();
}

function pressed(event) {
  if (event.key === "F6" || (event.key === "." && (event.ctrlKey || event.metaKey))) {
    event.preventDefault();
    if (!event.repeat) stopByKey();
    return;
  }
  if (!singleKeys() || withModifier(event) || typing(event.target)) return;
  if (at("help-text").open || document.querySelector("dialog[open]")) return;
  if (event.key === "?") {
    event.preventDefault();
    drawHelp();
  } else if (event.key === "/") {
    const search = at("page").querySelector("input[type=search]");
    if (search) {
      event.preventDefault();
      search.focus();
    }
  } else if (/^[1-9]$/.test(event.key)) {
    const wanted = pages()[Number(event.key) - 1];
    if (wanted) view.go(wanted.name);
  }
}

// begin ---------------------------------------------------------------------------------------

at("stop").addEventListener("click", stopAll);
at("theme").addEventListener("click", nextTheme);
at("help").addEventListener("click", drawHelp);
document.querySelector(".skip").addEventListener("click", (event) => {
  event.preventDefault();
  at("main").focus();
});
addEventListener("keydown", pressed);
addEventListener("hashchange", ({ oldURL }) => {
  if (!connection.hello) return;
  if (page?.unmount?.mayLeave?.() === false) {
    history.replaceState(null, "", oldURL);
    return;
  }
  open();
  at("main").focus({ preventScroll: false });
});
connection.on("hello", greet);
connection.on("state", drawConnection);
connection.on("connection", ({ state, text }) => {
  targetThere = state !== "lost";
  drawConnection({ state: connection.state, text });
});
// a target that starts has not all that it will have: drives, for example, are found later
setInterval(() => connection.refresh(), REFRESH);
drawTheme();
foresee();
connection.open();
