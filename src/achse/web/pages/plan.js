/** The path that a loaded program takes: points [x, y, z, rapid, block], and where the tool is on it. */

export class Plan {
  constructor(points = [], state = "whole") {
    this.points = points;
    this.state = state;
    this._lengths = [0];
    for (let n = 1; n < points.length; n += 1) {
      this._lengths.push(this._lengths[n - 1] + apart(points[n - 1], points[n]));
    }
  }

  /** Length of all of it. */
  get length() {
    return this._lengths.at(-1);
  }

  /**
   * Where a tool is that drives a block: {piece, length} by the place of that block which is
   * nearest to it; null without a tool or such a block. The piece ends at `points[piece]`.
   */
  find(tool, block) {
    if (!tool || !block) return null;
    let best = null;
    for (let n = this._first(block); n < this.points.length && this.points[n][4] === block; n += 1) {
      const { share, far } = foot(this.points[n - 1], this.points[n], tool);
      if (best !== null && far >= best.far) continue;
      const length = this._lengths[n - 1] + share * (this._lengths[n] - this._lengths[n - 1]);
      best = { piece: n, length, far };
    }
    return best;
  }

  /** The first piece of a block; blocks ascend. */
  _first(block) {
    let [low, high] = [1, this.points.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.points[middle][4] < block) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

function apart(a, b) {
  return Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
}

/** The place between a and b that is nearest to a point: its share of the way, and how far it is. */
function foot(a, b, point) {
  const way = [0, 1, 2].map((n) => b[n] - a[n]);
  const square = way.reduce((sum, each) => sum + each * each, 0);
  const along = way.reduce((sum, each, n) => sum + each * (point[n] - a[n]), 0);
  const share = square > 0 ? Math.min(1, Math.max(0, along / square)) : 0;
  return { share, far: apart(a.map((from, n) => from + share * (way[n] ?? 0)), point) };
}

/**
 * Draw lines between points [x, y, z, rapid] by `onto`: rapid ones dashed in the second colour.
 * `from` and `until` are the numbers of the first and last piece.
 */
export function drawLines(context, onto, points, [solid, dashed], from = 1, until = points.length - 1) {
  for (const [rapid, colour, dash] of [[false, solid, []], [true, dashed, [4, 4]]]) {
    context.strokeStyle = colour;
    context.setLineDash(dash);
    context.beginPath();
    let last = -1;
    for (let n = from; n <= until; n += 1) {
      if (Boolean(points[n][3]) !== rapid) continue;
      if (last !== n - 1) context.moveTo(...onto(points[n - 1]).slice(0, 2));
      context.lineTo(...onto(points[n]).slice(0, 2));
      last = n;
    }
    context.stroke();
  }
  context.setLineDash([]);
}
