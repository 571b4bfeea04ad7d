/** What the numbers of an axis mean to people: lamps, words, errors. */

import { code, word } from "./format.js";

/** Filters of the table of axes. */
export const AXIS_STATES = {
  error: ({ error }) => Boolean(error),
  moving: ({ moving }) => Boolean(moving),
  enabled: ({ enabled }) => Boolean(enabled),
};

/** The kind of lamp and the words beside it. */
export function stateOf({ error, moving, enabled, state }) {
  if (error) return ["bad", "error"];
  if (moving) return ["move", word(state || "MOVING")];
  return enabled ? ["on", word(state || "STANDSTILL")] : ["off", "not enabled"];
}

/** {name, text, address} of an axis' error; empty texts when it has none. */
export function errorOf({ error, error_text: text, error_link: address }) {
  return error ? { name: code(error), text: text ?? "", address } : { name: "", text: "", address: null };
}

/** The action with its numbers as `axes.do` takes them, or the name of the field that is wrong. */
export function motion(fields, parsed) {
  const values = {};
  for (const [name, text, needed] of fields) {
    const value = parsed(text);
    if (value === null && (needed || String(text).trim() !== "")) return { wrong: name };
    if (value !== null) values[name] = value;
  }
  return { values };
}
