/** Axes: all of them in a table, or one in detail (`#axes?axis=2`). */

import { mountAxis } from "./axis.js";
import { AXIS_STATES, errorOf, stateOf } from "./axis_state.js";
import { act, code, h, link, mark, show } from "./dom.js";
import { number, percent } from "./format.js";
import { LiveTable, column, lamp } from "./table.js";
import { fragment } from "./view.js";

export function mount(element, session) {
  const axis = session.view.get("axis");
  if (axis !== "") return mountAxis(element, session, Number(axis));
  mountAll(element, session);
  return undefined;
}

function mountAll(element, session) {
  const table = new LiveTable({
    caption: "Axes", key: ({ id }) => id, cards: true,
    empty: ["This target has no axes. A station has those of its station.toml: ",
      code('[[axis]]'), ", ", code("id = 1"), ", ", code('name = "X"'), "."],
    columns: [
      { title: "Axis", head: true, make: nameCell },
      { title: "State", make: stateCell },
      column("Position", ({ position, unit }) => `${number(position)} ${unit ?? ""}`, { numeric: true }),
      column("Velocity", ({ velocity, unit }) => `${number(velocity)} ${unit ? `${unit}/s` : ""}`,
        { numeric: true }),
      column("Following error", (row) => number(row.following_error, 4), { numeric: true }),
      column("Override", ({ override }) => percent(override, 0), { numeric: true, quiet: true }),
      { title: "Error", make: errorCell },
      { title: "Actions", hidden: true, make: (row) => actions(row, session) },
    ],
  });
  const filter = h("input", {
    type: "search", placeholder: "Filter by name", "aria-label": "Filter axes by name",
    value: session.view.get("search"),
  });
  const only = h("select", { "aria-label": "Which axes" },
    h("option", { value: "" }, "all"), h("option", { value: "error" }, "with an error"),
    h("option", { value: "moving" }, "that move"), h("option", { value: "enabled" }, "enabled"));
  only.value = session.view.get("only");
  let latest = [];
  const none = h("p", { class: "dim empty" }, "No axis has this name or state. ", act("Show all axes", () => {
    filter.value = only.value = "";
    chosen();
    filter.focus();
  }));
  const draw = () => {
    const wanted = filter.value.trim().toLowerCase();
    table.update(latest.filter((row) => row.name.toLowerCase().includes(wanted)
      && (only.value === "" || AXIS_STATES[only.value](row))));
    none.hidden = latest.length === 0 || table.size > 0;
    table.element.hidden = !none.hidden;
  };
  const chosen = () => {
    session.view.set({ search: filter.value.trim(), only: only.value });
    draw();
  };
  filter.addEventListener("input", chosen);
  only.addEventListener("change", chosen);
  element.append(
    h("div", { class: "panel" }, h("div", { class: "row" }, filter, only), table.element, none),
  );
  session.draw("axes", { every: session.every }, (rows) => {
    latest = rows;
    draw();
  });
}

function nameCell({ id, name }) {
  const text = h("a", { href: fragment("axes", { axis: id }) }, name);
  return [text, (row) => show(text, row.name)];
}

function stateCell() {
  const [element, update] = lamp();
  return [element, (row) => update(...stateOf(row))];
}

function errorCell() {
  const element = h("span", { class: "bad" });
  let shown = null;
  return [element, (row) => {
    const { text, name, address } = errorOf(row);
    if (shown === `${name}${text}`) return;
    shown = `${name}${text}`;
    element.replaceChildren(...(name ? [link(address, name), ` ${text}`] : []));
  }];
}

function actions(first, session) {
  const button = (action, text, kind = "small") => {
    const element = h("button", { type: "button", class: kind }, text);
    element.addEventListener("click", () => {
      const command = element.dataset.action ?? action;
      session.do("axes.do", { axis: first.id, action: command }, `${first.name}: ${command} sent.`);
    });
    return element;
  };
  const power = button("enable", "Enable");
  const reset = button("reset", "Reset");
  const stop = button("stop", "Stop", "small danger");
  const all = [power, reset, stop];
  return [h("div", { class: "row actions" }, all), (row) => {
    const action = row.enabled ? "disable" : "enable";
    power.dataset.action = action;
    show(power, row.enabled ? "Disable" : "Enable");
    for (const each of all) {
      each.disabled = !session.control;
      mark(each, "aria-label", `${each.textContent} ${row.name}`);
    }
    reset.disabled = !session.control || !row.error;
  }];
}
