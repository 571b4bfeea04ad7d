/**
 * The newest samples of a scope. Each column is a Float64Array of twice the capacity: it fills up,
 * then its newest half moves to the front. So what is kept is always one piece, and memory stays
 * as it was allotted. A gap is a row of NaN.
 */
export class Ring {
  /** `width`: columns with that of time; `capacity`: rows that are kept at least. */
  constructor(width, capacity) {
    if (!(width >= 1) || !(capacity >= 1)) {
      throw new RangeError(`a ring needs a column and a row, got ${width} and ${capacity}`);
    }
    this.capacity = Math.trunc(capacity);
    this.columns = Array.from({ length: width }, () => new Float64Array(2 * this.capacity));
    this.end = 0;
    this.total = 0; // rows ever appended: the number of the row behind the newest
  }

  get width() {
    return this.columns.length;
  }

  /** Rows that can be read now. */
  get size() {
    return Math.min(this.end, this.capacity);
  }

  /** Where in the columns the oldest row that can be read stands. */
  get start() {
    return this.end - this.size;
  }

  get first() {
    return this.size ? this.columns[0][this.start] : null;
  }

  get last() {
    return this.size ? this.columns[0][this.end - 1] : null;
  }

  /** Append columns of equal length; of more rows than fit the newest are kept. */
  append(columns) {
    if (columns.length !== this.width) {
      throw new RangeError(`${columns.length} columns for a ring of ${this.width}`);
    }
    let rows = columns[0].length;
    this.total += rows;
    const skipped = Math.max(rows - this.capacity, 0);
    rows -= skipped;
    if (this.end + rows > 2 * this.capacity) {
      const kept = Math.min(this.end, this.capacity);
      for (const column of this.columns) column.copyWithin(0, this.end - kept, this.end);
      this.end = kept;
    }
    for (let n = 0; n < this.width; n += 1) {
      this.columns[n].set(skipped ? columns[n].subarray(skipped) : columns[n], this.end);
    }
    this.end += rows;
  }

  /** Rows are missing here: one row without values at the time of the newest. */
  gap() {
    if (!this.size) return;
    const last = this.last;
    this.append(this.columns.map((_, n) => Float64Array.of(n ? NaN : last)));
  }

  /** Where in the columns the first row at this time or later stands; `end` if all are before. */
  find(time) {
    const times = this.columns[0];
    let [low, high] = [this.start, this.end];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The values of a column from one place to another, without a copy. */
  part(column, from, to) {
    return this.columns[column].subarray(Math.max(from, this.start), Math.min(to, this.end));
  }

  /** The value of a column at a time: that of the nearest row; null outside and in gaps. */
  at(column, time) {
    if (!this.size || !(time >= this.first) || time > this.last) return null;
    const right = this.find(time);
    const left = Math.max(right - 1, this.start);
    const times = this.columns[0];
    const near = time - times[left] < times[right] - time ? left : right;
    const value = this.columns[column][near];
    return Number.isNaN(value) ? null : value;
  }

  /** A copy for other columns: `from[n]` is the column that becomes column n, or -1 for none. */
  rebuilt(from, capacity) {
    const next = new Ring(from.length, capacity);
    const begin = Math.max(this.start, this.end - next.capacity);
    const rows = this.end - begin;
    next.append(from.map((n) =>
      n < 0 ? new Float64Array(rows).fill(NaN) : this.columns[n].subarray(begin, this.end)));
    next.total = this.total;
    return next;
  }
}
