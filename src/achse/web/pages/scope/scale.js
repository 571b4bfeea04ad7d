/** Scales of values: fitted to what is seen, and kept while that still fills them well. */

const ROOM = 0.06;
const LEAST = 0.7; // of the height that is to be filled

/** A little room above and below, and never of no height. */
export function fitted(low, high) {
  if (low === null || high === null) return [0, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (!Number.isFinite(4 * (high - low))) return [-Number.MAX_VALUE / 4, Number.MAX_VALUE / 4];
  if (!(high - low > size * 1e-9)) return [low - (size || 1) / 2, high + (size || 1) / 2];
  const room = Math.max(ROOM * (high - low), size * 1e-9, 1e-9);
  return [low - room, high + room];
}

/** The scale as it is while everything seen is in it and fills it; else a fitted one. */
export function kept(before, low, high) {
  if (before === null || low === null) return fitted(low, high);
  const [bottom, top] = before;
  const fills = high - low >= LEAST * (top - bottom);
  return low >= bottom && high <= top && fills ? before : fitted(low, high);
}
