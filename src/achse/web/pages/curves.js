/** Curves of a value over another: scales, ticks, and the picture of one. */

import { number } from "./format.js";

/** [least, greatest] of the finite values, with room for a line that does not change; null without one. */
export function extent(values) {
  let least = Infinity;
  let greatest = -Infinity;
  for (const value of values ?? []) {
    if (!Number.isFinite(value)) continue;
    if (value < least) least = value;
    if (value > greatest) greatest = value;
  }
  if (least > greatest) return null;
  if (least === greatest) {
    const room = Math.abs(least) * 0.1 || 1;
    return [least - room, greatest + room];
  }
  return [least, greatest];
}

/** Round values between the ends, about `wanted` of them: steps of 1, 2 or 5 times a power of ten. */
export function ticks([least, greatest], wanted = 5) {
  const span = greatest - least;
  if (!(span > 0) || !Number.isFinite(span)) return [];
  const power = 10 ** Math.floor(Math.log10(span / wanted));
  const rest = span / wanted / power;
  const step = power * (rest > 5 ? 10 : rest > 2 ? 5 : rest > 1 ? 2 : 1);
  const first = Math.ceil(least / step - 1e-9);
  const last = Math.floor(greatest / step + 1e-9);
  return Array.from({ length: Math.max(0, Math.min(last - first + 1, 50)) }, (_, n) => {
    const value = (first + n) * step;
    return value === 0 ? 0 : value;
  });
}

/** Every so manieth row, so that at most `most` remain; the first and the last are among them. */
export function thinned(count, most) {
  if (count <= most) return Array.from({ length: count }, (_, n) => n);
  return Array.from({ length: most }, (_, n) => Math.round((n * (count - 1)) / (most - 1)));
}

/** The index of the value that is nearest; values ascend. */
export function nearest(values, wanted) {
  let low = 0;
  let high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle;
    else high = middle;
  }
  return Math.abs(values[high] - wanted) < Math.abs(values[low] - wanted) ? high : low;
}

export const LEFT = 62;
const [TOP, RIGHT, BOTTOM] = [8, 12, 24];

/** Draw y over x with a grid; `at` is the index of the value under the cursor or null. */
export function drawCurve(context, width, height, colours, { x, y, kind, at = null }) {
  const across = extent(x);
  const up = extent(y);
  context.font = `12px ${colours.font}`;
  if (across === null || up === null) {
    context.fillStyle = colours.dim;
    context.fillText("no values", LEFT, height / 2);
    return;
  }
  const px = (value) => LEFT + ((value - across[0]) / (across[1] - across[0])) * (width - LEFT - RIGHT);
  const py = (value) => height - BOTTOM - ((value - up[0]) / (up[1] - up[0])) * (height - TOP - BOTTOM);
  drawGrid(context, width, height, colours, { across, up, px, py });
  context.strokeStyle = colours[kind];
  context.lineWidth = 1.75;
  context.beginPath();
  let drawn = false;
  for (let n = 0; n < x.length; n += 1) {
    if (!Number.isFinite(x[n]) || !Number.isFinite(y[n])) {
      drawn = false;
    } else {
      if (drawn) context.lineTo(px(x[n]), py(y[n]));
      else context.moveTo(px(x[n]), py(y[n]));
      drawn = true;
    }
  }
  context.stroke();
  if (at === null || !Number.isFinite(y[at])) return;
  context.strokeStyle = colours.edge;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(px(x[at]), TOP);
  context.lineTo(px(x[at]), height - BOTTOM);
  context.stroke();
  context.fillStyle = colours[kind];
  context.beginPath();
  context.arc(px(x[at]), py(y[at]), 4, 0, 2 * Math.PI);
  context.fill();
}

function drawGrid(context, width, height, colours, { across, up, px, py }) {
  context.strokeStyle = colours.line;
  context.fillStyle = colours.dim;
  context.lineWidth = 1;
  context.textBaseline = "middle";
  context.beginPath();
  context.textAlign = "right";
  for (const value of ticks(up, 4)) {
    context.moveTo(LEFT, py(value));
    context.lineTo(width - RIGHT, py(value));
    context.fillText(shortly(value), LEFT - 6, py(value));
  }
  context.textAlign = "center";
  for (const value of ticks(across, Math.max(2, width / 110))) {
    context.moveTo(px(value), TOP);
    context.lineTo(px(value), height - BOTTOM);
    context.fillText(shortly(value), px(value), height - BOTTOM / 2);
  }
  context.stroke();
  context.textAlign = "left";
}

/** The value that belongs to a place in the picture, 0…1 over the width of the curve. */
export function place(x, width) {
  return Math.min(1, Math.max(0, (x - LEFT) / Math.max(1, width - LEFT - RIGHT)));
}

function shortly(value) {
  const size = Math.abs(value);
  return size !== 0 && (size >= 1e6 || size < 1e-3)
    ? value.toExponential(1) : String(Number(number(value, 4)));
}
