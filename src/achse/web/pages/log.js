/** Log and traffic: lines as they come, filtered, paused, at most so many kept. */

import { act, code as command, h, mark, quiet, show } from "./dom.js";
import { clock, code, count, plain } from "./format.js";

const KEPT = 1000;
const LEVELS = ["info", "warning", "error"];

export function mount(element, session) {
  const kinds = [
    session.has("log") ? ["log", "Log", logOptions, logLine] : null,
    session.has("traffic") ? ["traffic", "Traffic", trafficOptions, trafficLine] : null,
  ].filter((kind) => kind !== null);
  const place = h("div", { class: "panel" });
  const tabs = h("div", { class: "tabs", role: "tablist", "aria-label": "What is shown" });
  let leave = () => {};
  const choose = (name) => {
    const kind = kinds.find(([each]) => each === name) ?? kinds[0];
    for (const tab of tabs.children) {
      const chosen = tab.dataset.name === kind[0];
      mark(tab, "aria-selected", String(chosen));
      mark(tab, "tabindex", chosen ? "0" : "-1");
    }
    leave();
    leave = showLines(place, session, kind);
  };
  for (const [name, title] of kinds) {
    const tab = h("button", { type: "button", role: "tab", "data-name": name }, title);
    tab.addEventListener("click", () => {
      session.view.set({ show: name });
      choose(name);
    });
    tabs.append(tab);
  }
  tabs.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowRight" && event.key !== "ArrowLeft") return;
    event.preventDefault();
    const other = [...tabs.children].find((tab) => tab !== document.activeElement);
    other?.click();
    other?.focus();
  });
  place.setAttribute("role", "tabpanel");
  mark(place, "aria-label", "Lines");
  element.append(tabs, place);
  choose(session.view.get("show", kinds[0][0]));
  return () => leave();
}

function showLines(place, session, [topic, title, options, line]) {
  const chosen = options(session);
  const lines = h("ol");
  const list = h("div", {
    class: "lines", role: "log", "aria-live": "off", "aria-label": title, tabindex: "0",
  }, lines);
  const empty = h("p", { class: "dim empty" }, chosen.empty);
  const none = h("p", { class: "dim empty" }, "No line is like this. ", act("Show all lines", () => chosen.all()));
  const counted = h("span", { class: "dim" });
  const pause = h("button", { type: "button", class: "small", "aria-pressed": "false" }, "Pause");
  const clear = h("button", { type: "button", class: "small" }, "Clear");
  let end = () => {};
  let kept = [];
  let fresh = [];
  let held = [];
  let anew = true;
  let again = false;
  let paused = false;
  let dropped = 0;
  let due = false;

  const draw = () => {
    due = false;
    const following = list.scrollHeight - list.scrollTop - list.clientHeight < 40;
    const nodes = (anew ? kept : fresh).filter(chosen.wanted).map(({ node }) => node);
    if (anew) lines.replaceChildren(...nodes);
    else lines.append(...nodes);
    while (lines.childElementCount > KEPT) lines.firstElementChild.remove();
    fresh = [];
    anew = false;
    const shown = lines.childElementCount;
    empty.hidden = kept.length > 0;
    none.hidden = shown > 0 || kept.length === 0;
    clear.disabled = kept.length === 0 && held.length === 0;
    list.hidden = shown === 0;
    const more = held.length ? `, ${count(held.length)} wait` : "";
    show(counted, `${count(shown)} lines${more}${dropped ? `, ${count(dropped)} lost` : ""}`);
    if (following) list.scrollTop = list.scrollHeight;
  };
  const soon = () => {
    if (!due) requestAnimationFrame(draw);
    due = true;
  };
  const take = (entries) => {
    const made = entries.map((entry) => ({ entry, node: line(entry) }));
    kept = [...kept, ...made].slice(-KEPT);
    fresh = [...fresh, ...made].slice(-KEPT);
  };
  const begin = () => {
    end();
    end = session.watch(topic, { ...chosen.asked() }, (value, lost) => {
      const entries = Array.isArray(value) ? value : [];
      if (again && entries.length) { // the server tells again what it still has
        const from = timeOf(entries[0]);
        kept = kept.filter(({ entry }) => timeOf(entry) < from);
        again = false;
        anew = true;
      }
      dropped = Math.max(dropped, lost);
      if (paused) held = [...held, ...entries].slice(-KEPT);
      else take(entries);
      soon();
    });
  };
  pause.addEventListener("click", () => {
    paused = !paused;
    mark(pause, "aria-pressed", String(paused));
    show(pause, paused ? "Go on" : "Pause");
    if (!paused) {
      take(held);
      held = [];
    }
    soon();
  });
  clear.addEventListener("click", () => {
    kept = [];
    fresh = [];
    held = [];
    anew = true;
    soon();
  });
  chosen.changed = (ask) => {
    anew = true;
    if (ask) {
      kept = [];
      begin();
    }
    soon();
  };
  place.replaceChildren(
    h("div", { class: "row" }, chosen.controls, pause, clear, counted), empty, none, list);
  const forget = session.on("state", ({ state }) => { again ||= state === "lost"; });
  begin();
  soon();
  return () => {
    forget();
    end();
  };
}

function timeOf({ time, time_ns: nanoseconds }) {
  return time ?? nanoseconds / 1e9;
}

function logOptions(session) {
  const { view } = session;
  const level = h("select", {}, LEVELS.map((name) => h("option", { value: name }, name)));
  const wanted = view.get("level");
  level.value = LEVELS.includes(wanted) ? wanted : LEVELS[0];
  const search = h("input", {
    type: "search", placeholder: "Text or source", "aria-label": "Filter lines", value: view.get("search"),
  });
  const self = {
    controls: [h("label", { class: "field" }, h("span", {}, "from level"), level), search],
    asked: () => ({}),
    wanted: ({ entry }) => LEVELS.indexOf(entry.level) >= LEVELS.indexOf(level.value)
      && `${entry.source} ${entry.text}`.toLowerCase().includes(search.value.trim().toLowerCase()),
    changed: () => {},
    empty: ["Nothing has been logged yet. Lines come from the station, and from PLC programs by ",
      command("ADSLOGSTR"), "."],
    all() {
      level.value = LEVELS[0];
      search.value = "";
      changed();
    },
  };
  const changed = () => {
    view.set({ level: level.value === "info" ? "" : level.value, search: search.value.trim() });
    self.changed(false);
  };
  level.addEventListener("change", changed);
  search.addEventListener("input", quiet(changed, 150));
  return self;
}

function logLine({ time, level, source, text }) {
  const kind = { error: "bad", warning: "warn" }[level] ?? "";
  return h("li", { class: kind || null }, h("time", {}, clock(time)),
    h("span", { class: "level" }, level ?? ""), h("span", { class: "source" }, source ?? ""),
    h("span", { class: "text" }, text ?? ""));
}

function trafficOptions(session) {
  const { view } = session;
  const errors = h("input", { type: "checkbox" });
  errors.checked = view.get("errors") === "1";
  const samples = h("input", { type: "checkbox" });
  samples.checked = view.get("samples") === "1";
  const search = h("input", {
    type: "search", placeholder: "Client, device, name", "aria-label": "Filter lines", value: view.get("search"),
  });
  const self = {
    controls: [search, h("label", { class: "check" }, errors, "only what failed"),
      h("label", { class: "check" }, samples, "notifications too")],
    asked: () => ({ errors: errors.checked, samples: samples.checked }),
    wanted: ({ entry, node }) => node.textContent.toLowerCase().includes(search.value.trim().toLowerCase())
      && (!errors.checked || Boolean(entry.error) || entry.answered === false)
      && (samples.checked || entry.command !== "notification"),
    changed: () => {},
    empty: ["No request has come yet. Send one from another terminal: ",
      command(`achse ads state --host ${location.hostname}`), "."],
    all() {
      const asked = errors.checked || !samples.checked;
      errors.checked = false;
      samples.checked = true;
      search.value = "";
      keep();
      self.changed(asked);
    },
  };
  const keep = () => view.set({
    search: search.value.trim(), errors: errors.checked ? 1 : "", samples: samples.checked ? 1 : "",
  });
  for (const each of [errors, samples]) {
    each.addEventListener("change", () => {
      keep();
      self.changed(true);
    });
  }
  search.addEventListener("input", quiet(() => {
    keep();
    self.changed(false);
  }, 150));
  return self;
}

/** One thing that was asked for: "read GVL.bBool = TRUE". */
function textOf({ text, verb, name, value, error }) {
  if (text) return text;
  const is = value === null || value === undefined || value === "" ? "" : ` = ${plain(value)}`;
  return `${verb ? `${verb} ` : ""}${name ?? ""}${is}${error ? ` ✗ ${code(error)}` : ""}`;
}

function trafficLine({ time_ns: at, peer, client, device, command, duration_ns: took, error, answered, items = [] }) {
  const bad = Boolean(error) || answered === false;
  const texts = items.length ? items.map(textOf) : [command];
  const many = texts.length > 1 ? `${texts.length} at once: ` : "";
  const end = answered === false ? "no answer" : error ? code(error)
    : typeof took === "number" ? `${(took / 1e6).toFixed(2)} ms` : "";
  return h("li", { class: bad ? "bad" : null }, h("time", {}, clock(at / 1e9)),
    h("span", { class: "level" }, String(device ?? "").split(":").pop()),
    h("span", { class: "source", title: client ?? "" }, peer ?? client ?? ""),
    h("span", { class: "text" }, `${many}${texts.join(" · ")}${end ? `  (${end})` : ""}`));
}
