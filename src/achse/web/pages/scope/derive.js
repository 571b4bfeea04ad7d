/**
 * Traces by their texts, as they stand in the address: `Axes.X.ActPos` is a channel, `rate NAME`
 * its derivative over time, `diff NAME OTHER` the difference of two.
 */

/** @returns {{kind: "channel" | "rate" | "diff", names: string[]}} */
export function parse(text) {
  const words = text.trim().split(/\s+/);
  if (words.length === 2 && words[0] === "rate") return { kind: "rate", names: [words[1]] };
  if (words.length === 3 && words[0] === "diff") return { kind: "diff", names: words.slice(1) };
  return { kind: "channel", names: [text.trim()] };
}

/** The channels that these traces need, each once. */
export function sources(texts) {
  return [...new Set(texts.flatMap((text) => parse(text).names))].filter(Boolean);
}

/** As people read it. */
export function title(text) {
  const { kind, names } = parse(text);
  if (kind === "rate") return `d/dt ${names[0]}`;
  return kind === "diff" ? `${names[0]} − ${names[1]}` : names[0];
}

/** The unit of a trace by those of its channels. */
export function unitOf(text, units) {
  const { kind, names } = parse(text);
  const unit = units.get(names[0]) ?? "";
  if (kind !== "rate" || unit === "") return unit;
  const known = { "": "/s", "/s": "/s²", "/s²": "/s³" };
  const [, base, over] = /^(.*?)(\/s²|\/s|)$/.exec(unit);
  return base + known[over];
}

/**
 * A derived column of a block. `before` is the row before the block, or null: [time, value] of the
 * trace's channel.
 */
export function derive(text, times, columnOf, before = null) {
  const { kind, names } = parse(text);
  const values = columnOf(names[0]);
  if (kind === "diff") {
    const other = columnOf(names[1]);
    return values.map((value, n) => value - other[n]);
  }
  return values.map((value, n) => {
    const [time, last] = n ? [times[n - 1], values[n - 1]] : (before ?? [NaN, NaN]);
    const span = times[n] - time;
    return span > 0 ? (value - last) / span : NaN;
  });
}
