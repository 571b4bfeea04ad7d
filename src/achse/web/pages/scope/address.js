/** What a scope shows, as texts for the address of the page, and back. */

const BETWEEN = "|";
const INSIDE = "~";
const MOST_TRACES = 64;

/** `[{text, chart}]` as "Axes.X.ActPos~1|rate MAIN.f~2". */
export function tracesText(traces) {
  return traces.map(({ text, chart }) => `${text}${INSIDE}${chart}`).join(BETWEEN);
}

export function tracesOf(text) {
  const seen = new Set();
  const traces = [];
  for (const each of text.split(BETWEEN)) {
    const [name, place = "1"] = each.split(INSIDE);
    const chart = Math.min(Math.max(Math.trunc(Number(place)) || 1, 1), 8);
    if (!name.trim() || seen.has(name) || traces.length >= MOST_TRACES) continue;
    seen.add(name);
    traces.push({ text: name.trim(), chart });
  }
  return traces;
}

const KEYS = ["mode", "channel", "kind", "level", "low", "high", "before"];

export function triggerText(trigger) {
  return trigger.mode === "off" ? "" : KEYS.map((key) => trigger[key] ?? "").join(INSIDE);
}

/** A trigger; what is missing or wrong has the usual value. */
export function triggerOf(text) {
  const parts = text.split(INSIDE);
  const given = Object.fromEntries(KEYS.map((key, n) => [key, parts[n] ?? ""]));
  const real = (value, otherwise) =>
    (value !== "" && Number.isFinite(Number(value)) ? Number(value) : otherwise);
  return {
    mode: ["normal", "single"].includes(given.mode) ? given.mode : "off",
    channel: given.channel,
    kind: KINDS.some(([kind]) => kind === given.kind) ? given.kind : "rising",
    level: real(given.level, 0),
    low: real(given.low, -1),
    high: real(given.high, 1),
    before: Math.min(Math.max(real(given.before, 20), 0), 100),
  };
}

/** Kinds of triggers: as the server calls them, as people do, and whether they take a band. */
export const KINDS = [
  ["rising", "edge up", false], ["falling", "edge down", false], ["edge", "edge up or down", false],
  ["above", "level above", false], ["below", "level below", false],
  ["enters", "enters the window", true], ["leaves", "leaves the window", true],
  ["inside", "inside the window", true], ["outside", "outside the window", true],
];

/** The trigger as `scope.start` takes it; null for none. */
export function requestedTrigger({ mode, channel, kind, level, low, high }) {
  if (mode === "off" || !channel) return null;
  const band = KINDS.find(([name]) => name === kind)?.[2];
  return { channel, kind, ...(band ? { low, high } : { level }) };
}
