import { field, h } from "../dom.js";
import { parsed, plain } from "../format.js";
import { KINDS } from "./address.js";
import { sources } from "./derive.js";

/** The form of the trigger. `changed(trigger)` is called with each whole wish. */
export class TriggerForm {
  constructor(first, changed) {
    this.value = { ...first };
    this._changed = changed;
    const option = ([value, text]) => h("option", { value }, text);
    const select = (label, options) => h("select", { "aria-label": label }, options.map(option));
    this._mode = select("Trigger",
      [["off", "off (roll)"], ["normal", "normal"], ["single", "single"]]);
    this._channel = select("Channel of the trigger", []);
    this._kind = select("Kind of trigger", KINDS);
    const entry = (label) => h("input", { type: "text", class: "number narrow", inputmode: "decimal",
      "aria-label": label });
    this._numbers = {
      level: entry("Level"), low: entry("Lower bound"), high: entry("Upper bound"),
      before: entry("Part before the trigger in percent"),
    };
    this._level = field("at", this._numbers.level);
    this._low = field("from", this._numbers.low);
    this._high = field("to", this._numbers.high);
    this.element = h("fieldset", { class: "row trigger" }, h("legend", {}, "Trigger"),
      this._mode, this._channel, this._kind, this._level, this._low, this._high,
      field("before", this._numbers.before, h("i", {}, "%")));
    for (const each of this.element.querySelectorAll("select, input")) {
      each.addEventListener("change", () => this._read());
    }
    this._show();
  }

  /** The traces of the scope: a trigger watches one of their channels. */
  offer(texts) {
    const names = sources(texts);
    this._channel.replaceChildren(...names.map((name) => h("option", { value: name }, name)));
    this._channel.disabled = names.length === 0;
    if (!names.includes(this.value.channel)) this.value.channel = names[0] ?? "";
    this._show();
  }

  /** Off, or as it was before it was off. */
  toggle() {
    const { mode } = this.value;
    this._mode.value = mode === "off" ? (this._before ?? "normal") : "off";
    if (mode !== "off") this._before = mode;
    this._read();
  }

  _read() {
    const next = { ...this.value, mode: this._mode.value, kind: this._kind.value,
      channel: this._channel.value || this.value.channel };
    for (const [key, input] of Object.entries(this._numbers)) {
      const value = parsed(input.value);
      const wrong = value === null || (key === "before" && (value < 0 || value > 100));
      if (wrong) input.setAttribute("aria-invalid", "true");
      else {
        input.removeAttribute("aria-invalid");
        next[key] = value;
      }
    }
    this.value = next;
    this._hide();
    this._changed(next);
  }

  _show() {
    const { mode, kind, channel } = this.value;
    this._mode.value = mode;
    this._kind.value = kind;
    this._channel.value = channel;
    for (const [key, input] of Object.entries(this._numbers)) input.value = plain(this.value[key]);
    this._hide();
  }

  _hide() {
    const band = KINDS.find(([kind]) => kind === this.value.kind)[2];
    this._level.hidden = band;
    this._low.hidden = this._high.hidden = !band;
  }
}
