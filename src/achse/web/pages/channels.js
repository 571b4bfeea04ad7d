/** Channels with an interpreter: state, program line, and the path with the tool moving. */

import { h, mark, panel, show } from "./dom.js";
import { NONE, code, number, word } from "./format.js";
import { Facts } from "./table.js";
import { Plan, drawLines } from "./plan.js";
import { boundsOf } from "./projection.js";
import { Turntable } from "./turntable.js";

const MOST = 5000;
const AXES = ["X", "Y", "Z"];
const LENGTHS = { X: [1, 0, 0], Y: [0, 1, 0], Z: [0, 0, 1] };

/** What is known of a path: points as they come, the oldest go. */
export class Path {
  constructor(most = MOST) {
    this._most = most;
    this.points = [];
  }

  fill(points) {
    this.points = points.filter(finite).slice(-this._most);
  }

  add(point) {
    const last = this.points.at(-1);
    if (!finite(point) || (last && AXES.every((_, n) => last[n] === point[n]))) return false;
    this.points.push(point);
    if (this.points.length > this._most) this.points.splice(0, this.points.length - this._most);
    return true;
  }

  clear() {
    this.points = [];
  }
}

function finite(point) {
  return Array.isArray(point) && AXES.every((_, n) => Number.isFinite(point[n]));
}

/** Gives the function that ends it. */
export function mountChannels(element, session) {
  const place = h("div", {});
  let end = () => {};
  const pick = h("select", { "aria-label": "Channel" });
  const choice = h("label", { class: "field above" }, h("span", {}, "Channel"), pick);
  choice.hidden = true;
  element.append(choice, place);
  const open = (row) => {
    end();
    place.replaceChildren();
    end = mountChannel(place, session, row);
  };
  session.do("channels.list").then((rows) => {
    if (!rows?.length) {
      place.append(h("p", { class: "dim" }, "There is no channel with an interpreter. "
        + "A station has those of its station.toml: ", h("code", {}, "[[channel]]"), "."));
      return;
    }
    for (const { channel, name } of rows) {
      pick.append(h("option", { value: String(channel) }, name ? `${channel} ${name}` : String(channel)));
    }
    const wanted = rows.find(({ channel }) => String(channel) === session.view.get("channel")) ?? rows[0];
    pick.value = String(wanted.channel);
    choice.hidden = rows.length < 2;
    pick.addEventListener("change", () => {
      session.view.set({ channel: pick.value });
      open(rows.find(({ channel }) => String(channel) === pick.value));
    });
    open(wanted);
  });
  return () => end();
}

function mountChannel(element, session, { channel, name }) {
  const path = new Path();
  let plan = new Plan();
  let planned = null;
  let ended = false;
  let at = null;
  let tool = null;
  const clear = h("button", { type: "button", class: "plain" }, "Clear picture");
  const facts = new Facts();
  const line = h("p", { class: "mono path" });
  const state = h("p", { class: "bad", role: "status" });
  const table = new Turntable(`Path of ${name || `channel ${channel}`}`, session,
    (context, width, height, colours, camera) => {
      clear.disabled = path.points.length === 0;
      drawPath(context, width, height, colours, camera, { points: path.points, tool, plan, at });
    });
  element.append(h("div", { class: "grid" },
    panel(name || `Channel ${channel}`, facts.element, state, line, controls()),
    h("section", { class: "panel two", "aria-label": "Path" }, h("h2", {}, "Path"), legend(), table.element)));
  const from = session.call("channels.path", { channel }).then(
    ({ points }) => {
      path.fill([...points, ...path.points]);
      table.draw();
    },
    (error) => session.fail(error),
  );
  const stop = session.draw("channel", { channel, every: session.every }, (value) => {
    if (ended || !value) return;
    const { state: now, program, line: text, error, error_text: why, positions = [] } = value;
    tool = finite(positions) && value.axes?.some(Boolean) ? positions.slice(0, 3) : null;
    learn(value.plan);
    at = plan.find(tool, value.plan?.block ?? 0);
    facts.update([
      ["State", word(now)],
      ["Program", program || NONE],
      ["Path", onPath()],
      ...AXES.map((axis, n) => [axis, value.axes?.[n] ? number(positions[n]) : NONE]),
    ]);
    show(state, error ? `${code(error)} ${why ?? ""}` : "");
    show(line, text || "No line of a program is running.");
    from.then(() => {
      if (tool && now !== "IDLE") path.add([...tool, 0]);
      table.draw();
    });
  });
  return () => {
    ended = true;
    stop();
    table.end();
  };

  /** Another plan than the one shown is asked for once. */
  function learn(newest) {
    const number = newest?.points ? newest.number : null;
    if (number === planned) return;
    planned = number;
    plan = new Plan();
    if (number === null) return;
    session.call("channels.plan", { channel }).then((answer) => {
      if (ended || planned !== number) return;
      plan = new Plan(answer.points, answer.state);
      table.draw();
    }, (error) => session.fail(error));
  }

  function onPath() {
    if (plan.points.length < 2) return NONE;
    const whole = `${number(plan.length, 1)} mm${{ cut: " and more", fault: ", then an error" }[plan.state] ?? ""}`;
    return at === null ? whole : `${number(at.length, 1)} of ${whole}`;
  }

  function controls() {
    const file = h("input", { type: "text", "aria-label": "Program to load", placeholder: "plate.nc", maxlength: "200",
      value: session.view.get("file") });
    const load = h("button", { type: "submit" }, "Load");
    const form = h("form", { class: "row" }, file, load);
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      const wanted = file.value.trim();
      mark(file, "aria-invalid", wanted ? null : "true");
      if (!wanted) {
        session.say("Name a program of the channel's folder.");
        file.focus();
        return;
      }
      const done = await session.do("channels.do", { channel, action: "load", file: wanted }, `${wanted} is loaded.`);
      if (done === undefined) return;
      session.view.set({ file: wanted });
      path.clear();
      table.draw();
    });
    const buttons = [["start", "Start", "main"], ["stop", "Stop", "danger"], ["reset", "Reset", null]]
      .map(([action, text, kind]) => {
        const button = h("button", { type: "button", class: kind }, text);
        button.addEventListener("click", () =>
          session.do("channels.do", { channel, action }, `Channel ${channel}: ${action} sent.`));
        return button;
      });
    clear.addEventListener("click", () => {
      path.clear();
      table.draw();
    });
    for (const each of [...buttons, load, file]) each.disabled = !session.control;
    return h("div", { class: "stack" }, form, h("div", { class: "row" }, buttons, clear));
  }
}

function legend() {
  return h("p", { class: "dim row" }, h("span", { class: "key ahead" }, "planned"),
    h("span", { class: "key driven" }, "driven"), "dashed: rapid");
}

/** Draw the planned path from where the tool is on it, the way so far, the tool, the directions. */
export function drawPath(context, width, height, colours, camera, { points, tool, plan = new Plan(), at = null }) {
  const all = [...plan.points, ...points];
  const onto = camera.onto(width, height, boundsOf(tool ? [...all, tool] : all));
  drawDirections(context, height, colours, camera);
  context.lineJoin = "round";
  context.lineWidth = 1;
  drawLines(context, onto, plan.points, [colours.line, colours.line], 1, at?.piece ?? 0);
  drawLines(context, onto, plan.points, [colours.dim, colours.dim], at?.piece ?? 1);
  context.lineWidth = 1.75;
  drawLines(context, onto, points, [colours.accent, colours.dim]);
  if (tool === null) return;
  const [x, y] = onto(tool);
  context.fillStyle = colours.bad;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x - 7, y - 16);
  context.lineTo(x + 7, y - 16);
  context.closePath();
  context.fill();
}

/** X, Y, Z as small arrows in the lower left corner. */
export function drawDirections(context, height, colours, camera) {
  const turned = camera.turned();
  context.font = `12px ${colours.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineWidth = 1.5;
  for (const [name, direction] of Object.entries(LENGTHS)) {
    const [right, up] = turned(direction);
    if (Math.hypot(right, up) < 0.05) continue; // it points at us
    context.strokeStyle = colours.edge;
    context.fillStyle = colours.dim;
    context.beginPath();
    context.moveTo(44, height - 44);
    context.lineTo(44 + 24 * right, height - 44 - 24 * up);
    context.stroke();
    context.fillText(name, 44 + 34 * right, height - 44 - 34 * up);
  }
  context.textAlign = "left";
}
