/**
 * Where the right edge of a picture is that follows the newest sample. Samples come in blocks; the
 * edge follows them evenly, so each frame shows a little more, and it comes to rest on the newest.
 */

const BEHIND = 80; // ms that it is behind while samples come
const LONGEST = 100; // ms of one step, however late a frame is

export class Roll {
  constructor() {
    this.edge = null;
    this._at = 0;
  }

  /** The edge at `now` (ms) with the newest sample at `last`, for a window of `width` seconds. */
  step(last, now, width, even = true) {
    const back = this.edge === null ? Infinity : last - this.edge;
    const passed = Math.min(Math.max(now - this._at, 0), LONGEST);
    this._at = now;
    // a window has some thousand columns: less than that is the same picture
    if (!even || back < 0 || back > width / 2 || back < width / 10_000) this.edge = last;
    else this.edge += back * (1 - Math.exp(-passed / BEHIND));
    return this.edge;
  }
}
