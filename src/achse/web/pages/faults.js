/** Faults on demand: what is at work, and a form that sets another. */

import { field, h, mark, show } from "./dom.js";
import { count, parsed, word } from "./format.js";
import { LiveTable, column } from "./table.js";

export function mount(element, session) {
  const active = new LiveTable({
    caption: "Faults that wait or are at work", key: ({ number }) => number,
    empty: "No fault is set. Choose a kind below and set it: it begins at once, or at its time.",
    columns: [
      column("No.", ({ number }) => String(number), { numeric: true }),
      column("Fault", ({ text, kind, fault }) => text ?? kind ?? fault ?? "", { head: true }),
      column("State", ({ state }) => word(state)),
      column("Hits", ({ hits }) => count(hits), { numeric: true }),
      { title: "Clear", hidden: true, make: ({ number }) => {
        const button = h("button", { type: "button", class: "small", "aria-label": `Clear fault ${number}` }, "Clear");
        button.addEventListener("click", () =>
          session.do("faults.clear", { number }, `Fault ${number}: cleared.`));
        return [button, () => { button.disabled = !session.control; }];
      } },
    ],
  });
  const all = h("button", { type: "button", class: "small" }, "Clear all");
  all.disabled = !session.control;
  all.addEventListener("click", () => session.do("faults.clear", { number: null }, "All faults: cleared."));

  const kind = h("select", { "aria-label": "Kind of fault" });
  const meaning = h("p", { class: "dim" });
  const fields = h("div", { class: "fields" });
  const wrong = h("p", { class: "bad", role: "status" });
  const set = h("button", { type: "submit", class: "main" }, "Set the fault");
  set.disabled = true;
  const form = h("form", { class: "stack" },
    h("div", { class: "row" }, field("Kind", kind)), meaning, fields, wrong, h("div", { class: "row" }, set));
  let kinds = [];
  const chosen = () => kinds.find((each) => each.kind === kind.value);
  const draw = () => {
    show(meaning, chosen()?.meaning ?? "");
    show(wrong, "");
    const wanted = fieldsOf(chosen());
    fields.replaceChildren(...wanted.map(({ name, type, unit, meaning: about, default: otherwise }) =>
      field(name, h("input", {
        type: "text", name, class: type === "string" ? "mono" : "number", "data-type": type,
        "data-unit": unit || null, title: about ?? null,
        placeholder: otherwise === null || otherwise === undefined ? "" : String(otherwise),
      }), unit ? h("i", {}, unit) : null)));
  };
  kind.addEventListener("change", () => {
    session.view.set({ kind: kind.value });
    draw();
  });
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const { values, bad } = valuesOf([...fields.querySelectorAll("input")].map(
      ({ name, value, dataset }) => ({ name, value, type: dataset.type, unit: dataset.unit })));
    for (const input of fields.querySelectorAll("input")) mark(input, "aria-invalid", input.name === bad ? "true" : null);
    show(wrong, bad ? `${bad}: a number is needed` : "");
    if (bad) return;
    const answer = await session.do("faults.set", { kind: kind.value, ...values });
    if (answer !== undefined) session.say(`Fault ${answer.number ?? ""}: set.`);
  });
  element.append(h("div", { class: "grid" },
    h("section", { class: "panel wide", "aria-label": "Faults at work" },
      h("div", { class: "row between" }, h("h2", {}, "Waiting and at work"), all), active.element),
    h("section", { class: "panel wide", "aria-label": "Set a fault" }, h("h2", {}, "Set a fault"), form)));

  session.draw("faults", { every: 0.5 }, (rows) => {
    active.update(rows ?? []);
    all.hidden = active.size === 0;
  });
  session.call("faults.list").then((answer) => {
    kinds = answer;
    const families = [...new Set(kinds.map(({ family }) => family ?? ""))];
    kind.replaceChildren(...families.flatMap((family) => {
      const options = kinds.filter((each) => (each.family ?? "") === family)
        .map((each) => h("option", { value: each.kind }, each.kind));
      return families.length > 1 ? [h("optgroup", { label: family }, options)] : options;
    }));
    const wanted = session.view.get("kind");
    if (kinds.some((each) => each.kind === wanted)) kind.value = wanted;
    set.disabled = !session.control;
    draw();
  }, session.fail);
}

/** Fields of a kind: objects, or names alone. */
export function fieldsOf(kind) {
  return (kind?.fields ?? kind?.parameters ?? []).map((each) =>
    typeof each === "string" ? { name: each, type: "string" } : each);
}

/** {values} as the server takes them, or {bad}: the name of the field that is not a number. */
export function valuesOf(inputs) {
  const values = {};
  for (const { name, value, type, unit } of inputs) {
    const text = value.trim();
    if (text === "") continue;
    if (type === "string") {
      values[name] = text;
      continue;
    }
    // codes are typed as 0x706
    const number = /^0x[0-9a-f]+$/i.test(text) ? Number.parseInt(text, 16)
      : unit === "s" ? seconds(text) : parsed(text);
    if (number === null || (type === "integer" && !Number.isInteger(number))) return { values, bad: name };
    values[name] = number;
  }
  return { values };
}

/** Seconds of a text with a unit or without one, as station.toml has them: "2", "50ms"; null for others. */
function seconds(text) {
  const [, value, unit] = /^(.*?)\s*(ms|us|µs|s)?$/.exec(text);
  const number = parsed(value);
  return number === null ? null : number / { s: 1, ms: 1e3, us: 1e6, "µs": 1e6 }[unit ?? "s"];
}
