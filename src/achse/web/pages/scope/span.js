/** What part of time is seen: it follows the newest sample, or stays where somebody put it. */

const SHORTEST = 1e-6;

export class Span {
  /** `width`: seconds that are seen while it follows. */
  constructor(width) {
    this.width = width;
    this.fixed = null;
  }

  /** [from, to] in seconds, with the newest sample at `last`. */
  at(last) {
    return this.fixed ?? [last - this.width, last];
  }

  follow() {
    this.fixed = null;
  }

  fix([from, to]) {
    if (to - from >= SHORTEST && Number.isFinite(to - from)) this.fixed = [from, to];
  }

  /** Wider (factor over 1) or closer about a place: 0 is the left edge, 1 the right one. */
  zoom(factor, at, last) {
    const [from, to] = this.at(last);
    const about = from + at * (to - from);
    this.fix([about - (about - from) * factor, about + (to - about) * factor]);
  }

  /** By a part of the width; later for positive ones. */
  pan(part, last) {
    const [from, to] = this.at(last);
    const way = part * (to - from);
    this.fix([from + way, to + way]);
  }

  /** About a trigger, so many percent of the width before it. */
  about(time, before) {
    const left = time - (this.width * before) / 100;
    return [left, left + this.width];
  }
}
