/**
 * What a picture shows of a trace: for each column of pixels the lowest and the highest value of
 * the line through its samples. A peak of one sample is in it, however many samples a column has;
 * between samples that are columns apart the line is straight.
 */

/** Where samples stand: `times` and `columns` from `begin` to `end`, in the order of time. */
export function rowAt({ times, begin, end }, time) {
  let [low, high] = [begin, end];
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (times[middle] < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/**
 * The columns of a picture that rolls: number `n` is from `origin + n · step` seconds for one step.
 * They are kept where `n` leaves a remainder by the width, so that nothing moves while it rolls.
 */
export class Grid {
  constructor(width) {
    this.width = width;
    this.step = 0;
    this.origin = 0;
    this.first = 0; // number of the left column
    this._from = 0; // columns that are known and stay: from … to - 1
    this._to = 0;
  }

  /** Show this range, as far as whole columns can; true if what was known is of no use then. */
  place([from, to]) {
    const step = (to - from) / this.width;
    const other = !(Math.abs(step - this.step) <= 1e-9 * step);
    if (other) {
      this.step = step;
      this.origin = from;
      this.forget();
    }
    this.first = Math.round((from - this.origin) / this.step);
    return other;
  }

  forget() {
    this._from = this._to = 0;
  }

  /** Seconds at the edges of the picture. */
  get range() {
    const at = (number) => this.origin + number * this.step;
    return [at(this.first), at(this.first + this.width)];
  }

  slot(number) {
    const rest = number % this.width;
    return rest < 0 ? rest + this.width : rest;
  }

  /**
   * The columns that must be found out now, as [from, to, from, to]; `last` is the time of the
   * newest sample, behind which columns are not whole.
   */
  missing(last) {
    const [begin, end] = [this.first, this.first + this.width];
    let parts;
    if (this._to <= begin || this._from >= end) parts = [begin, end, end, end];
    else parts = [begin, Math.max(this._from, begin), Math.max(this._to, begin), end];
    const whole = Math.floor((last - this.origin) / this.step);
    this._from = begin;
    this._to = Math.max(Math.min(whole, end), begin);
    return parts;
  }
}

/** Lowest and highest values of one trace by slots of a grid; Infinity and -Infinity for none. */
export class Columns {
  constructor(grid) {
    this._grid = grid;
    this.low = new Float64Array(grid.width).fill(Infinity);
    this.high = new Float64Array(grid.width).fill(-Infinity);
  }

  /** Find out columns `from` … `to - 1` of `source.times` and `values`. */
  find(source, values, from, to) {
    const grid = this._grid;
    const { origin, step, width } = grid;
    const { times } = source;
    const { low, high } = this;
    for (let n = from, slot = grid.slot(from); n < to; n += 1) {
      low[slot] = Infinity;
      high[slot] = -Infinity;
      slot = slot + 1 === width ? 0 : slot + 1;
    }
    const base = grid.slot(from);
    const count = to - from;
    const first = Math.max(rowAt(source, origin + from * step) - 1, source.begin);
    let [place, value, known] = [0, 0, false]; // the row before
    for (let row = first; row < source.end; row += 1) {
      const here = (times[row] - origin) / step - from;
      const now = values[row];
      const column = Math.floor(here);
      const there = now - now === 0; // neither NaN nor infinite
      if (known && there && column >= 0 && place < count) {
        const slope = (now - value) / (here - place);
        const [least, most] = value < now ? [value, now] : [now, value];
        // the line crosses into each column up to this one
        for (let n = Math.max(Math.floor(place), -1) + 1; n <= column && n <= count; n += 1) {
          const at = Math.min(Math.max(value + (n - place) * slope, least), most);
          if (n > 0) this._take((base + n - 1) % width, at);
          if (n < count) this._take((base + n) % width, at);
        }
      }
      if (there && column >= 0 && column < count) this._take((base + column) % width, now);
      if (column >= count) break;
      [place, value, known] = [here, now, there];
    }
  }

  _take(slot, value) {
    if (value < this.low[slot]) this.low[slot] = value;
    if (value > this.high[slot]) this.high[slot] = value;
  }
}

/** The lowest and the highest value of all columns of these traces, or [null, null]. */
export function extent(all) {
  let [least, most] = [Infinity, -Infinity];
  for (const { low, high } of all) {
    for (let n = 0; n < low.length; n += 1) {
      if (low[n] < least) least = low[n];
      if (high[n] > most) most = high[n];
    }
  }
  return least <= most ? [least, most] : [null, null];
}
