/** Overview: the station, its cycle, devices, clients, faults at work. */

import { code, h, panel } from "./dom.js";
import { count, elapsed, number, percent, seconds, word } from "./format.js";
import { Facts, LiveTable, column, lamp } from "./table.js";
import { fragment } from "./view.js";

const NO_LOAD_BEYOND = 1;

export function mount(element, session) {
  const station = new Facts();
  const cycle = new Facts();
  const axes = new Facts();
  const load = h("meter", { min: 0, max: 1, high: 0.7, low: 0.5, optimum: 0, "aria-label": "Cycle load" });
  const devices = new LiveTable({
    caption: "Devices", key: ({ port }) => port, empty: ["No device answers yet. Is it running? ", code("achse ads state"), " says it too."],
    columns: [
      column("Port", ({ port }) => String(port), { numeric: true }),
      column("Device", ({ name }) => name, { head: true }),
      { title: "State", make: stateLamp },
      column("Requests", ({ requests }) => count(requests), { numeric: true }),
      column("Errors", ({ errors }) => count(errors),
        { numeric: true, kind: ({ errors }) => (errors > 0 ? "warn" : "") }),
      column("Clients", ({ clients }) => count(clients), { numeric: true, quiet: true }),
    ],
  });
  const clients = new LiveTable({
    caption: "Clients", key: ({ address, name, peer }) => `${address ?? name}|${peer}`,
    columns: [
      column("Client", ({ name, address }) => name ?? address ?? "–", { head: true }),
      column("From", ({ peer }) => peer ?? "–", { quiet: true }),
      column("Requests", ({ requests }) => count(requests), { numeric: true }),
      column("Subscriptions", ({ subscriptions }) => count(subscriptions), { numeric: true }),
    ],
  });
  const faults = new LiveTable({
    caption: "Faults at work", key: (fault) => fault.number,
    empty: ["No fault is set. ", session.has("faults") && session.control
      ? h("a", { href: fragment("faults") }, "Set one") : false],
    columns: [
      column("No.", (fault) => String(fault.number), { numeric: true }),
      column("Fault", ({ text, kind }) => text ?? kind, { head: true }),
      column("State", ({ state }) => word(state)),
      column("Hits", ({ hits }) => count(hits), { numeric: true }),
    ],
  });
  const clientPanel = panel("Clients", clients.element);
  clientPanel.hidden = true;
  const { hello } = session;
  element.append(
    h("div", { class: "grid" },
      panel("Station", station.element),
      panel("Cycle", cycle.element, load),
      panel("Axes", axes.element,
        session.has("axes") ? h("p", {}, h("a", { href: fragment("axes") }, "Show the axes")) : null),
      h("div", { class: "two" }, panel("Devices", devices.element)),
      h("div", { class: "column" }, clientPanel, panel("Faults", faults.element)),
    ),
  );
  if (!hello.control) {
    element.prepend(h("p", { class: "dim" }, "This page may look only: nothing can be changed."));
  }

  session.draw("overview", { every: 0.5 }, (now) => {
    const speed = now.speed ?? hello.speed;
    station.update([
      ["Name", hello.name || "–"],
      ["Target", hello.target || "–"],
      ["Version", hello.version || "–"],
      ["Runs for", elapsed(now.time)],
      ...(typeof now.connections === "number" ? [["Connections", count(now.connections)]] : []),
      ["Speed", typeof speed === "number" ? `${number(speed, 2)} ×` : "–"],
    ]);
    const { tick, load: ratio, late, lost, longest } = now.cycle ?? {};
    cycle.update([
      ["Cycle", seconds(tick)],
      ["Load", percent(ratio), ratio > NO_LOAD_BEYOND ? "bad" : ""],
      ["Longest", seconds(longest)],
      ["Late cycles", count(late), late > 0 ? "warn" : ""],
      ["Lost time", typeof lost === "number" && lost > 0 ? seconds(lost) : "none", lost > 0 ? "warn" : ""],
    ]);
    load.hidden = typeof ratio !== "number";
    if (!load.hidden) load.value = Math.min(1, ratio);
    axes.update([
      ["Axes", count(now.axes?.count)],
      ["Moving", count(now.axes?.moving)],
      ["With an error", count(now.axes?.error), now.axes?.error > 0 ? "bad" : ""],
    ]);
    devices.update(now.devices ?? []);
    clients.update(now.clients ?? []);
    clientPanel.hidden = clients.size === 0; // not every target tells who they are
    faults.update(now.faults ?? []);
  });
}

function stateLamp() {
  const [element, show] = lamp();
  return [element, ({ state }) => show(KINDS[String(state).toUpperCase()] ?? "off", word(state))];
}

const KINDS = {
  RUN: "on", START: "on", IDLE: "on", STOP: "warn", CONFIG: "warn", RECONFIG: "warn",
  ERROR: "bad", EXCEPTION: "bad", INVALID: "bad",
};
