/** Drives and bus: drives with their CiA 402 state, their objects, the slaves of each bus. */

import { machine } from "./drive_machine.js";
import { code as line, h, link, quiet, show } from "./dom.js";
import { NONE, code, count, number, percent, plain, range, word } from "./format.js";
import { valueCell } from "./parameters.js";
import { Facts, LiveTable, column, lamp } from "./table.js";
import { fragment } from "./view.js";

const DRIVE_LAMPS = {
  OPERATION_ENABLED: "on", FAULT: "bad", FAULT_REACTION_ACTIVE: "bad", QUICK_STOP_ACTIVE: "warn",
};
/** Modes of operation after CiA 402 (object 6060h). */
const MODES = { 1: "pp", 2: "vl", 3: "pv", 4: "tq", 6: "hm", 7: "ip", 8: "csp", 9: "csv", 10: "cst" };
const BUS_LAMPS = { OP: "on", SAFEOP: "warn", PREOP: "warn", INIT: "off", BOOT: "warn" };

export function mount(element, session) {
  if (session.has("drives")) mountDrives(element, session);
  if (session.has("bus")) mountBuses(element, session);
}

function mountDrives(element, session) {
  let chosen = session.view.get("drive");
  let shownObjects = "";
  const picture = machine();
  const objects = objectTable(session);
  const pick = (drive) => {
    chosen = String(drive);
    session.view.set({ drive: chosen });
  };
  const table = new LiveTable({
    caption: "Drives", key: ({ drive }) => drive, cards: true,
    empty: ["No slave answers as a drive (CiA 402). A station has those of its station.toml: ",
      line("[[bus]]"), ", ", line("[[drive]]"), ", ", line('axis = "X"'), "."],
    columns: [
      { title: "Drive", head: true, make: ({ drive, name }) => {
        const button = h("button", { type: "button", class: "plain small" }, name ?? `drive ${drive}`);
        button.addEventListener("click", () => pick(drive));
        return [button, (row) => {
          show(button, row.name ?? `drive ${row.drive}`);
          button.setAttribute("aria-pressed", String(String(row.drive) === chosen));
        }];
      } },
      { title: "Axis", make: axisCell },
      { title: "State", make: () => lampOf(({ state }) => [DRIVE_LAMPS[state] ?? "off", word(state)]) },
      column("Mode", ({ mode }) => MODES[mode] ?? plain(mode)),
      column("Position", positionOf, { numeric: true }),
      column("Velocity", velocityOf, { numeric: true }),
      column("Torque", ({ torque }) => percent(torque === null ? null : torque / 1000), { numeric: true, quiet: true }),
      { title: "Alarm", make: () => {
        const place = h("span", { class: "bad" });
        let known = null;
        return [place, ({ error, error_text: text, error_link: address }) => {
          const now = `${error}${text}`;
          if (known === now) return;
          known = now;
          place.replaceChildren(...(error ? [link(address, typeof error === "number" ? code(error) : error),
            ` ${text ?? ""}`] : []));
        }];
      } },
    ],
  });
  const facts = new Facts();
  const detail = h("section", { class: "panel", "aria-label": "State of the drive" },
    h("h2", {}, "State machine"), picture.element, facts.element);
  element.append(h("div", { class: "grid" },
    h("section", { class: "panel wide", "aria-label": "Drives" }, h("h2", {}, "Drives"), table.element),
    detail, objects.element));
  session.draw("drives", { every: Math.max(session.every, 0.2) }, (rows) => {
    const known = rows ?? [];
    if (!known.some(({ drive }) => String(drive) === chosen)) chosen = known.length ? String(known[0].drive) : "";
    table.update(known);
    const row = known.find(({ drive }) => String(drive) === chosen);
    detail.hidden = objects.element.hidden = row === undefined;
    if (row === undefined) return;
    picture.show(row.state);
    facts.update([
      ["Drive", row.name ?? String(row.drive)],
      ["Statusword", hex(row.statusword)],
      ["Controlword", hex(row.controlword)],
      ["Counter", increments(row.position, "inc")],
      ["Rate", increments(row.velocity, "inc/s")],
      ["Bus", word(row.bus_state)],
    ]);
    if (shownObjects !== chosen) {
      shownObjects = chosen;
      objects.load(row.drive);
    }
  });
}

function objectTable(session) {
  const search = h("input", {
    type: "search", placeholder: "Search objects", "aria-label": "Search objects", value: session.view.get("search"),
  });
  const again = h("button", { type: "button", class: "small" }, "Read again");
  const table = new LiveTable({
    caption: "Objects of the drive", key: ({ key }) => key, empty: "No object has this number, name or meaning: empty the search to see all.",
    columns: [
      column("Object", ({ key }) => key, { kind: () => "mono" }),
      { title: "Name", head: true, make: (row) => [h("span", {}, link(row.link, row.name)), () => {}] },
      { title: "Value", make: (row) => valueCell(row, { write, control: session.control }) },
      column("Unit", ({ unit }) => unit ?? ""),
      column("Range", (row) => (row.writable ? range(row) : ""), { quiet: true, kind: () => "nowrap dim" }),
      column("Meaning", ({ meaning }) => meaning ?? "", { quiet: true }),
    ],
  });
  const state = h("p", { class: "dim", role: "status" });
  const back = h("button", { type: "button", class: "small" });
  back.hidden = true;
  let rows = [];
  let drive = null;
  let undo = () => {};
  back.addEventListener("click", () => undo());
  /** What was written, what the drive made of it, and the way back. */
  async function write(row, value) {
    const answer = await session.do("drives.write", { drive, key: row.key, value });
    if (answer === undefined) return false;
    const { value: now, before } = answer;
    session.say(now === value ? `${row.name}: ${plain(now)}, it was ${plain(before)}.`
      : `${row.name}: the drive has ${plain(now)} instead of ${plain(value)}.`);
    back.hidden = before === null || before === now;
    const written = drive;
    undo = () => drive === written && write(row, before);
    show(back, `Undo: ${row.name} = ${plain(before)}`);
    await load(drive);
    return true;
  }
  const draw = () => {
    const text = search.value.trim().toLowerCase();
    session.view.set({ search: search.value.trim() });
    table.update(rows.filter((row) =>
      `${row.key} ${row.name} ${row.meaning ?? ""}`.toLowerCase().includes(text)));
  };
  const load = async (wanted) => {
    if (drive !== wanted) back.hidden = true;
    drive = wanted;
    show(state, "Reading the objects…");
    try {
      const answer = await session.call("drives.objects", { drive: wanted });
      if (drive !== wanted) return;
      rows = answer;
      show(state, "");
    } catch (error) {
      rows = [];
      show(state, error.message);
    }
    draw();
  };
  search.addEventListener("input", quiet(draw, 150));
  again.addEventListener("click", () => drive !== null && load(drive));
  return {
    element: h("section", { class: "panel two", "aria-label": "Objects" },
      h("div", { class: "row between" }, h("h2", {}, "Objects"), h("div", { class: "row" }, search, again, back)),
      state, h("div", { class: "tall" }, table.element)),
    load,
  };
}

function mountBuses(element, session) {
  const place = h("div", { class: "grid buses" });
  const known = new Map();
  element.append(place);
  session.draw("bus", { every: 0.5 }, (buses) => {
    for (const bus of buses ?? []) {
      let shown = known.get(bus.net_id ?? bus.name);
      if (shown === undefined) {
        shown = busPanel(bus);
        known.set(bus.net_id ?? bus.name, shown);
        place.append(shown.element);
      }
      shown.update(bus);
    }
  });
}

function busPanel({ name }) {
  const facts = new Facts();
  const table = new LiveTable({
    caption: `Slaves of ${name}`, key: ({ station }) => station, empty: "No slave answers: look at the cable or the faults of the bus, and at its state above.",
    columns: [
      column("Address", ({ station }) => String(station), { numeric: true }),
      column("Slave", (slave) => slave.name, { head: true }),
      { title: "State", make: () => lampOf(({ state }) => [BUS_LAMPS[state] ?? "bad", word(state)]) },
      column("Faults", ({ faults }) => (faults?.length ? faults.join(", ") : "none"),
        { kind: ({ faults }) => (faults?.length ? "bad" : "") }),
      column("Vendor", ({ vendor }) => hex(vendor, 8), { quiet: true, kind: () => "mono" }),
      column("Product", ({ product }) => hex(product, 8), { quiet: true, kind: () => "mono" }),
      column("Revision", ({ revision }) => hex(revision, 8), { quiet: true, kind: () => "mono" }),
      column("Errors", ({ errors }) => count(errors), { numeric: true, kind: ({ errors }) => (errors ? "warn" : "") }),
    ],
  });
  return {
    element: h("section", { class: "panel wide", "aria-label": `Bus ${name}` },
      h("h2", {}, `Bus ${name}`), facts.element, table.element),
    update({ net_id: netId, state, faults, cycles, lost, slaves }) {
      facts.update([
        ["NetId", netId ?? "–"],
        ["State", word(state), BUS_LAMPS[state] === "on" ? "good" : "warn"],
        ["Faults", faults?.length ? faults.join(", ") : "none", faults?.length ? "bad" : ""],
        ["Cycles", count(cycles)],
        ["Lost frames", count(lost), lost > 0 ? "warn" : ""],
      ]);
      table.update(slaves ?? []);
    },
  };
}

function lampOf(of) {
  const [element, update] = lamp();
  return [element, (row) => update(...of(row))];
}

/** A position in the unit of the axis; a drive without an axis has only increments. */
export function positionOf({ position, scaled_position: scaled, unit }) {
  return typeof scaled === "number" ? `${number(scaled)} ${unit ?? ""}`.trim() : increments(position, "inc");
}

export function velocityOf({ velocity, scaled_velocity: scaled, unit }) {
  return typeof scaled === "number" ? `${number(scaled)} ${unit ? `${unit}/s` : ""}`.trim()
    : increments(velocity, "inc/s");
}

function increments(value, unit) {
  return typeof value === "number" ? `${count(value)} ${unit}` : NONE;
}

function axisCell() {
  const place = h("span", {});
  let known = null;
  return [place, ({ axis, axis_id: id }) => {
    if (known === `${id} ${axis}`) return;
    known = `${id} ${axis}`;
    place.replaceChildren(axis ? h("a", { href: fragment("axes", { axis: id }) }, axis) : NONE);
  }];
}

function hex(value, digits = 4) {
  return typeof value === "number"
    ? `0x${(value >>> 0).toString(16).toUpperCase().padStart(digits, "0")}` : plain(value);
}
