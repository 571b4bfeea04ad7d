import { Columns, Grid, extent } from "./columns.js";
import { Raster, wordOf } from "./raster.js";

/**
 * The lines of a chart as a picture that rolls: of each frame only the columns are found out and
 * painted that are new. The left column stands anywhere in the picture, the rest goes round.
 */
export class Strip {
  /** `looks`: [{colour, width, opacity, dash, unit}], one for each column of its sources. */
  constructor(width, height, looks) {
    this.grid = new Grid(width);
    this._raster = null;
    this._canvas = null;
    this._height = height;
    this._looks = looks.map((each) => ({ ...each, word: wordOf(each.colour) }));
    this._columns = looks.map(() => new Columns(this.grid));
    this._times = null;
    this._parts = [0, 0, 0, 0];
    this._painted = "";
    this._shown = NaN;
  }

  get height() {
    return this._height;
  }

  /** Show `range` of `source`: {times, begin, end, columns}. True if the scale is to be fitted. */
  place(source, range) {
    const other = this.grid.place(range);
    if (source.times !== this._times) {
      this._times = source.times;
      this.grid.forget();
    }
    const last = source.end > source.begin ? source.times[source.end - 1] : -Infinity;
    const parts = this._parts = this.grid.missing(last);
    this._columns.forEach((each, n) => {
      if (parts[1] > parts[0]) each.find(source, source.columns[n], parts[0], parts[1]);
      if (parts[3] > parts[2]) each.find(source, source.columns[n], parts[2], parts[3]);
    });
    return other;
  }

  /** The lowest and the highest value that is seen of a unit. */
  extent(unit) {
    return extent(this._columns.filter((_, n) => this._looks[n].unit === unit));
  }

  /** Paint what is new; `rangeOf(unit)` is [low, high]. False if the picture is as it was. */
  paint(rangeOf) {
    const { grid } = this;
    const key = [...new Set(this._looks.map(({ unit }) => unit))].map(rangeOf).join("|");
    let parts = this._parts;
    if (key !== this._painted) parts = [grid.first, grid.first, grid.first, grid.first + grid.width];
    const moved = grid.first !== this._shown;
    this._painted = key;
    this._shown = grid.first;
    if (parts[1] <= parts[0] && parts[3] <= parts[2]) return moved;
    this._part(parts[0], parts[1], rangeOf);
    this._part(parts[2], parts[3], rangeOf);
    this._parts = [0, 0, 0, 0];
    return true;
  }

  _part(begin, end, rangeOf) {
    if (end <= begin) return;
    const { grid } = this;
    const raster = this._raster ?? this._make();
    const wide = this._looks.reduce((most, { width }) => Math.max(most, Math.floor((width - 1) / 2)), 0);
    const from = Math.max(begin - wide, grid.first);
    const to = Math.min(end + wide, grid.first + grid.width);
    if (to - from === grid.width) raster.pixels.fill(0);
    else for (let n = from; n < to; n += 1) raster.clear(grid.slot(n));
    this._looks.forEach((look, n) =>
      raster.trace(grid, this._columns[n], rangeOf(look.unit), look, from, to));
    const slot = grid.slot(from);
    const tail = Math.min(to - from, grid.width - slot);
    this._ctx.putImageData(this._image, 0, 0, slot, 0, tail, this._height);
    if (to - from > tail) {
      this._ctx.putImageData(this._image, 0, 0, 0, 0, to - from - tail, this._height);
    }
  }

  _make() {
    const { width } = this.grid;
    this._canvas = document.createElement("canvas");
    this._canvas.width = width;
    this._canvas.height = this._height;
    this._ctx = this._canvas.getContext("2d");
    this._image = this._ctx.createImageData(width, this._height);
    this._raster = new Raster(width, this._height, new Uint32Array(this._image.data.buffer));
    return this._raster;
  }

  /** Put the picture at this place of another. */
  show(ctx, left, top) {
    if (this._canvas === null) return;
    const { width } = this.grid;
    const slot = this.grid.slot(this.grid.first);
    const put = (from, count, at) =>
      ctx.drawImage(this._canvas, from, 0, count, this._height, left + at, top, count, this._height);
    put(slot, width - slot, 0);
    if (slot > 0) put(0, slot, width - slot);
  }
}
