/** One axis in detail: read-outs, enables, moves, jog while held, parameters. */

import { errorOf, motion, stateOf } from "./axis_state.js";
import { field, h, link, mark, panel, show } from "./dom.js";
import { number, parsed, percent } from "./format.js";
import { Hold } from "./hold.js";
import { withModifier } from "./keys.js";
import { ParameterTables } from "./parameters.js";
import { Facts, lamp } from "./table.js";
import { fragment } from "./view.js";

const JOGS = [
  { text: "− −", label: "Jog fast back (F1)", key: "F1", direction: -1, fast: true },
  { text: "−", label: "Jog back (F2)", key: "F2", direction: -1, fast: false },
  { text: "+", label: "Jog forward (F3)", key: "F3", direction: 1, fast: false },
  { text: "+ +", label: "Jog fast forward (F4)", key: "F4", direction: 1, fast: true },
];

export function mountAxis(element, session, id) {
  if (!Number.isInteger(id)) {
    element.append(h("p", {}, "There is no such axis."), back());
    return undefined;
  }
  const send = (action, values = {}, done = "") =>
    session.do("axes.do", { axis: id, action, ...values }, done);
  const unit = [];
  const unitMark = (suffix = "") => {
    const node = h("i");
    unit.push([node, suffix]);
    return node;
  };

  const display = readouts(unitMark);
  const control = controls(send);
  const jog = jogging(session, send, unitMark);
  const moves = movement(session, send, unitMark);
  const parameters = new ParameterTables(session, id);
  const chartPlace = h("div", { class: "wide" });
  let endChart = () => {};
  let left = false;
  let chartOf = session.has("scope") ? null : "";
  const details = new Facts();
  const detailPanel = panel("Details", details.element);
  detailPanel.classList.add("details");
  detailPanel.hidden = true;

  element.append(
    h("div", { class: "row above" }, back()),
    h("div", { class: "axis grid" },
      h("div", { class: "column" },
        h("section", { class: "panel", "aria-label": "Actual values" }, display.element), detailPanel),
      h("div", { class: "column" }, panel("Control", control.element), panel("Jog while held", jog.element)),
      panel("Move", moves.element),
      chartPlace,
      parameters.element),
  );
  parameters.load();

  let row = null;
  const buttons = [...jog.buttons, moves.button];
  const stale = () => { // until its state is known a button could do what it does not say
    row = null;
    control.stale();
    for (const each of buttons) each.disabled = true;
  };
  stale();
  session.on("state", ({ state }) => state !== "open" && stale());
  session.draw("axis", { axis: id, every: session.every }, (value) => {
    row = value.axis ?? value;
    for (const [node, suffix] of unit) show(node, row.unit ? `${row.unit}${suffix}` : "");
    if (chartOf === null) {
      chartOf = row.name;
      // what draws is large: it comes when the page is there
      import("./axis_chart.js").then(({ axisChart }) => {
        if (left) return;
        const chart = axisChart(session, chartOf);
        endChart = chart.end;
        chartPlace.append(chart.element);
      }, session.fail);
    }
    display.update(row);
    control.update(row, session.control);
    for (const each of [...buttons, ...jog.inputs, ...moves.inputs]) each.disabled = !session.control;
    const rows = (value.details ?? []).flatMap((group) => group.rows ?? []);
    detailPanel.hidden = rows.length === 0;
    details.update(rows.map(({ name, value: is, unit: of }) => [name, `${is ?? "–"} ${of ?? ""}`.trim()]));
  });

  const keys = (event) => {
    const pressed = JOGS.findIndex(({ key }) => key === event.key);
    if (event.type === "keyup") {
      jog.holds[pressed]?.release(); // whatever has come between
      return;
    }
    // Alt+F4 closes a window: it does not jog
    if (document.querySelector("dialog[open]") || !session.control || withModifier(event) || event.shiftKey) return;
    const action = pressed >= 0 ? () => jog.holds[pressed].press() : {
      F5: moves.start, F8: () => send("reset", {}, `${row.name}: reset sent.`),
      F9: () => send("home", {}, `${row.name}: home sent.`) }[event.key];
    if (action === undefined) return;
    event.preventDefault();
    if (event.repeat) return;
    if (row === null) session.say("The state of the axis is not known: nothing was sent.");
    else action();
  };
  addEventListener("keydown", keys);
  addEventListener("keyup", keys);
  return () => {
    removeEventListener("keydown", keys);
    removeEventListener("keyup", keys);
    left = true;
    endChart();
    jog.end();
  };
}

function back() {
  return h("a", { href: fragment("axes") }, "← All axes");
}

function readouts(unitMark) {
  const name = h("h2", { class: "axis-name" });
  const [state, showState] = lamp();
  const position = h("output", { class: "big", "aria-label": "Position" });
  const error = h("p", { class: "bad", hidden: true });
  const facts = new Facts();
  let shown = null;
  return {
    element: h("div", { class: "readout" },
      h("div", { class: "row between" }, name, state),
      h("p", { class: "row" }, position, unitMark()), error, facts.element),
    update(row) {
      show(name, row.name);
      showState(...stateOf(row));
      show(position, number(row.position));
      const { name: number_, text, address } = errorOf(row);
      if (shown !== number_ + text) {
        shown = number_ + text;
        error.replaceChildren(...(number_ ? [link(address, number_), ` ${text}`] : []));
        error.hidden = number_ === "";
      }
      facts.update([
        ["Velocity", number(row.velocity)],
        ["Following error", number(row.following_error, 4)],
        ["Set position", number(row.set_position)],
        ["Set velocity", number(row.set_velocity)],
        ["Override", percent(row.override, 0)],
        ["Homed", row.homed ? "yes" : "no", row.homed ? "" : "warn"],
      ]);
    },
  };
}

function controls(send) {
  const button = (action, text, kind = "") => {
    const element = h("button", { type: "button", class: kind || null }, text);
    element.addEventListener("click", () => {
      const command = element.dataset.action ?? action;
      send(command, {}, `${element.textContent}: sent.`);
    });
    return element;
  };
  const power = button("", "Power", "main"); // until it is known what a click would do
  const reset = button("reset", "Reset");
  const home = button("home", "Home");
  const halt = button("halt", "Halt");
  const stop = button("stop", "Stop axis", "danger");
  const slide = h("input", { type: "range", min: 0, max: 100, step: 1, "aria-label": "Override, percent" });
  const exact = h("input", { type: "text", class: "number narrow", inputmode: "decimal", "aria-label": "Override" });
  const set = (text) => {
    const percentage = parsed(text);
    if (percentage === null || percentage < 0 || percentage > 100) {
      mark(exact, "aria-invalid", "true");
      return;
    }
    mark(exact, "aria-invalid", null);
    send("override", { percent: percentage }, `Override: ${percentage} %`);
  };
  slide.addEventListener("change", () => set(slide.value));
  exact.addEventListener("change", () => set(exact.value));
  const lamps = ["controller", "plus", "minus"].map((name) => [name, lamp()]);
  const all = [power, reset, home, halt, stop, slide, exact];
  return {
    stale() {
      for (const each of all) each.disabled = true;
    },
    element: h("div", { class: "stack" },
      h("div", { class: "row" }, power, reset, home),
      h("div", { class: "row" }, halt, stop),
      h("div", { class: "row", role: "group", "aria-label": "Enables" }, lamps.map(([, [node]]) => node)),
      h("div", { class: "row slide" }, h("span", { class: "dim label" }, "Override"), slide, exact, "%")),
    update(row, able) {
      power.dataset.action = row.enabled ? "disable" : "enable";
      show(power, row.enabled ? "Disable" : "Enable");
      for (const each of all) each.disabled = !able;
      for (const [name, [, update]] of lamps) {
        update(row.enable?.[name] ? "on" : "off", `${name}${row.enable?.[name] ? "" : " off"}`);
      }
      const now = String(Math.round(100 * (row.override ?? 0)));
      if (document.activeElement !== slide) slide.value = now;
      if (document.activeElement !== exact) exact.value = now;
    },
  };
}

function jogging(session, send, unitMark) {
  const velocity = h("input", {
    type: "text", inputmode: "decimal", class: "number", placeholder: "as set",
    value: session.view.get("jog"),
  });
  velocity.addEventListener("change", () => session.view.set({ jog: velocity.value.trim() }));
  const ends = [];
  const buttons = [];
  const holds = JOGS.map(({ text, label, direction, fast }) => {
    const button = h("button", { type: "button", class: "jog", "aria-label": label, title: label }, text);
    const values = () => {
      const { values: speed = {} } = motion([["velocity", velocity.value, false]], parsed);
      return { direction, fast, ...speed };
    };
    const jog = async () => {
      if ((await send("jog", values())) === undefined) hold.release(); // refused: do not go on
    };
    const hold = new Hold({
      begin() {
        mark(button, "aria-pressed", "true");
        jog();
      },
      again: jog,
      end() {
        mark(button, "aria-pressed", null);
        send("jog", { direction: 0 });
      },
    });
    ends.push(hold.attach(button));
    buttons.push(button);
    return hold;
  });
  return {
    holds,
    buttons,
    inputs: [velocity],
    element: h("div", { class: "stack" },
      h("div", { class: "row jogs" }, buttons),
      h("label", { class: "field" }, h("span", {}, "Velocity"), velocity, unitMark("/s"))),
    end() {
      for (const end of ends) end();
    },
  };
}

function movement(session, send, unitMark) {
  const { view } = session;
  const how = h("select", { "aria-label": "Kind of move" },
    h("option", { value: "to" }, "to a position"), h("option", { value: "by" }, "by a distance"),
    h("option", { value: "velocity" }, "with a velocity"),
    h("option", { value: "here" }, "none: the position here is"));
  how.value = view.get("move", "to");
  const input = (key) => h("input", {
    type: "text", inputmode: "decimal", class: "number", value: view.get(key), "data-key": key,
  });
  const [target, velocity, acceleration, deceleration, jerk] =
    ["target", "velocity", "acceleration", "deceleration", "jerk"].map(input);
  for (const each of [acceleration, deceleration, jerk]) each.placeholder = "as set";
  const inputs = [how, target, velocity, acceleration, deceleration, jerk];
  const targetName = h("span");
  const targetField = h("label", { class: "field" }, targetName, target, unitMark());
  const wrong = h("p", { class: "bad", role: "status" });
  const dynamics = [
    field("Velocity", velocity, unitMark("/s")), field("Acceleration", acceleration, unitMark("/s²")),
    field("Deceleration", deceleration, unitMark("/s²")), field("Jerk", jerk, unitMark("/s³")),
  ];
  const draw = () => {
    targetField.hidden = how.value === "velocity";
    for (const each of dynamics) each.hidden = how.value === "here";
    show(targetName, how.value === "by" ? "Distance" : "Position");
  };
  const keep = () => {
    draw();
    view.set({ move: how.value === "to" ? "" : how.value,
      ...Object.fromEntries(inputs.slice(1).map((each) => [each.dataset.key, each.value.trim()])) });
  };
  for (const each of inputs) each.addEventListener("change", keep);

  const start = () => {
    const kind = how.value;
    const optional = [["acceleration", acceleration.value, false],
      ["deceleration", deceleration.value, false], ["jerk", jerk.value, false]];
    const aim = kind === "velocity" ? [] : [[kind === "by" ? "distance" : "to", target.value, true]];
    const rest = kind === "here" ? [] : [["velocity", velocity.value, true], ...optional];
    const { wrong: name, values } = motion([...aim, ...rest], parsed);
    for (const each of inputs.slice(1)) mark(each, "aria-invalid", null);
    if (name) {
      const bad = { to: target, distance: target, velocity, acceleration, deceleration, jerk }[name];
      mark(bad, "aria-invalid", "true");
      show(wrong, `${name === "to" ? "position" : name}: a number is needed`);
      bad.focus();
      return;
    }
    show(wrong, "");
    if (kind === "here") {
      send("set_position", values, "Position: set.");
    } else if (kind === "velocity") {
      send("velocity", { ...values, velocity: Math.abs(values.velocity),
        direction: values.velocity < 0 ? -1 : 1 }, "Move: sent.");
    } else {
      send("move", values, "Move: sent.");
    }
  };
  const form = h("form", { class: "stack" },
    h("div", { class: "row" }, how),
    h("div", { class: "fields" }, targetField, dynamics),
    wrong,
    h("div", { class: "row" }, h("button", { type: "submit", class: "main" }, "Start (F5)")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    start();
  });
  draw();
  return { element: form, inputs, button: form.querySelector("button"), start };
}
