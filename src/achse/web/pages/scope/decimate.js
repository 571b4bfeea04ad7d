/**
 * What a picture needs of many rows: per pixel the lowest and the highest value of each column, in
 * the order in which they came. Without it a peak of one row could be left out.
 */

/**
 * `[times, values, values …]` as plain arrays for the plot, gaps as null.
 *
 * @param {ArrayLike<number>[]} columns of equal length, the first is time
 * @param {number} pixels how many pairs of points at most (one more for the first, cut pair)
 * @param {number} number that the first row has since the beginning: pairs begin at multiples of
 *   their length, so the picture does not shimmer while it rolls
 */
export function decimate(columns, pixels, number = 0) {
  const rows = columns[0].length;
  if (rows <= 2 * pixels) return columns.map((column) => Array.from(column, plain));
  const step = bucket(rows, pixels);
  const out = columns.map(() => []);
  let begin = 0;
  while (begin < rows) {
    const end = Math.min(begin + step - ((number + begin) % step), rows);
    out[0].push(columns[0][begin], columns[0][end - 1]);
    for (let n = 1; n < columns.length; n += 1) pair(columns[n], begin, end, out[n]);
    begin = end;
  }
  return out;
}

/** Rows of a pair: a power of two, so that it seldom changes. */
function bucket(rows, pixels) {
  return 2 ** Math.ceil(Math.log2(rows / pixels));
}

function pair(values, begin, end, out) {
  let [low, high] = [-1, -1];
  let broken = false;
  for (let n = begin; n < end; n += 1) {
    const value = values[n];
    if (Number.isNaN(value)) broken = true;
    else {
      if (low < 0 || value < values[low]) low = n;
      if (high < 0 || value > values[high]) high = n;
    }
  }
  if (low < 0) out.push(null, null);
  else if (broken) out.push(values[Math.abs(values[high]) > Math.abs(values[low]) ? high : low], null);
  else if (low <= high) out.push(values[low], values[high]);
  else out.push(values[high], values[low]);
}

function plain(value) {
  return Number.isNaN(value) ? null : value;
}
