/** Keys that work without Ctrl: who speaks to his computer, or types by chance, switches them off. */

const PLACE = "achse.keys";
let single = true;
try {
  single = localStorage.getItem(PLACE) !== "off";
} catch {
  // without storage: on
}

/** May letters, digits and signs without Ctrl do something? */
export function singleKeys() {
  return single;
}

export function setSingleKeys(on) {
  single = on;
  try {
    localStorage.setItem(PLACE, on ? "on" : "off");
  } catch {
    // without storage it holds until the page is closed
  }
}

/** Is one of the keys held that make another key of it? */
export function withModifier({ ctrlKey, altKey, metaKey }) {
  return ctrlKey || altKey || metaKey;
}
