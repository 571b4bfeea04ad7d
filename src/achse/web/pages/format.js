/** Numbers and times as a control engineer reads them. What is missing is a dash. */

export const NONE = "–";

/** A physical value with so many decimals; huge and tiny ones as 1.234e+12. */
export function number(value, decimals = 3) {
  if (typeof value !== "number" || Number.isNaN(value)) return NONE;
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "-∞";
  if (Math.abs(value) >= 1e10) return value.toExponential(4);
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

/** A parameter in the shortest exact form. */
export function plain(value) {
  if (value === null || value === undefined) return NONE;
  if (typeof value === "boolean") return value ? "TRUE" : "FALSE";
  if (typeof value === "number") {
    const [plainly, shortly] = [String(value), value.toExponential()];
    return plainly.length > shortly.length + 4 ? shortly : plainly; // 1e+20, not twenty zeros
  }
  return typeof value === "string" ? value : JSON.stringify(value);
}

/** A count with thin spaces between thousands. */
export function count(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return NONE;
  return String(Math.trunc(value)).replace(/\B(?=(\d{3})+$)/g, "\u2009");
}

/** A ratio as percent: 0.034 is 3.4 %. */
export function percent(ratio, decimals = 1) {
  return typeof ratio === "number" && Number.isFinite(ratio)
    ? `${(100 * ratio).toFixed(decimals)} %`
    : NONE;
}

/** A duration in seconds with the unit that suits it. */
export function seconds(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return NONE;
  const size = Math.abs(value);
  const [factor, unit] = size >= 1 || size === 0 ? [1, "s"] : size >= 1e-3 ? [1e3, "ms"] : [1e6, "µs"];
  return `${Number((value * factor).toPrecision(3))} ${unit}`;
}

/** How long a station runs: 1:02:03. */
export function elapsed(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return NONE;
  const whole = Math.floor(value);
  const two = (part) => String(part).padStart(2, "0");
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

/** The time of day here of seconds since 1970: 12:34:56.789. */
export function clock(value) {
  if (typeof value !== "number" || !Number.isFinite(value)) return NONE;
  const at = new Date(1000 * value);
  const two = (part) => String(part).padStart(2, "0");
  const milliseconds = String(at.getMilliseconds()).padStart(3, "0");
  return `${two(at.getHours())}:${two(at.getMinutes())}:${two(at.getSeconds())}.${milliseconds}`;
}

/** An error code: 0x4655. */
export function code(value) {
  return typeof value === "number" ? `0x${value.toString(16).toUpperCase().padStart(4, "0")}` : NONE;
}

/** A word in capitals as people write it: "IN_MOTION" is "in motion". */
export function word(text) {
  return text ? String(text).replaceAll("_", " ").toLowerCase() : NONE;
}

/** What may be written: "0 … 100", "at most 5", or nothing. */
export function range({ minimum = null, maximum = null }) {
  if (minimum !== null && maximum !== null) return `${plain(minimum)} … ${plain(maximum)}`;
  if (minimum !== null) return `from ${plain(minimum)}`;
  return maximum !== null ? `to ${plain(maximum)}` : "";
}

/** The number that somebody typed ("1,5" too), or null. */
export function parsed(text) {
  const trimmed = String(text).trim().replace(/^([+-]?\d*),(\d+)$/, "$1.$2");
  if (trimmed === "") return null;
  const value = Number(trimmed);
  return Number.isFinite(value) ? value : null;
}
