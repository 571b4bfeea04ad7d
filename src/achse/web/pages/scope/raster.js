/**
 * Lines as pixels, column by column: each pixel has as much of the colour as the line covers of it.
 * Words are 0xAABBGGRR, as image data has them on every processor that runs browsers.
 */

const STEEP = 4; // pixels, in widths of the line: what rises more has no breaks

/** "#rrggbb" as a word without opacity. */
export function wordOf(colour) {
  const value = Number.parseInt(colour.slice(1), 16);
  return ((value & 0xff) << 16) | (value & 0xff00) | (value >>> 16);
}

/** `share` (0 to 1) of a colour over what is there. */
export function over(there, word, share) {
  const before = (there >>> 24) / 255;
  const left = before * (1 - share);
  const opacity = share + left;
  if (!(opacity > 0)) return there;
  if (left === 0) return ((Math.round(255 * share) << 24) | word) >>> 0;
  const mixed = (bits) =>
    Math.round((share * ((word >>> bits) & 0xff) + left * ((there >>> bits) & 0xff)) / opacity);
  return ((Math.round(255 * opacity) << 24) | (mixed(16) << 16) | (mixed(8) << 8) | mixed(0)) >>> 0;
}

export class Raster {
  /** `pixels`: width × height words, row by row. */
  constructor(width, height, pixels = new Uint32Array(width * height)) {
    this.width = width;
    this.height = height;
    this.pixels = pixels;
  }

  /** Nothing in columns of this slot. */
  clear(slot) {
    const { pixels, width } = this;
    for (let at = slot; at < pixels.length; at += width) pixels[at] = 0;
  }

  /** A line from `top` to `bottom` (pixels from above, as real numbers) in the column of a slot. */
  line(slot, top, bottom, word, opacity = 1) {
    const { pixels, width, height } = this;
    if (!(bottom > 0) || !(top < height)) return;
    const from = Math.max(top, 0);
    const to = Math.min(bottom, height);
    const [first, last] = [Math.floor(from), Math.ceil(to) - 1];
    for (let y = first; y <= last; y += 1) {
      const share = opacity * (Math.min(to, y + 1) - Math.max(from, y));
      const at = y * width + slot;
      if (share >= 1) pixels[at] = (0xff000000 | word) >>> 0;
      else if (share > 0) pixels[at] = over(pixels[at], word, share);
    }
  }

  /**
   * Columns `from` … `to - 1` of a trace. `look`: {word, width, opacity, dash}; the dash counts
   * columns by their numbers, so it rolls with the trace. A peak is never in a break of it.
   */
  trace(grid, columns, [low, high], look, from, to) {
    const { height } = this;
    const { word, width, opacity, dash } = look;
    const scale = height / (high - low);
    const half = width / 2;
    const period = dash.reduce((sum, each) => sum + each, 0);
    const wide = Math.floor((width - 1) / 2); // thick lines are as thick where they are steep
    for (let n = from; n < to; n += 1) {
      const slot = grid.slot(n);
      let [least, most] = [columns.low[slot], columns.high[slot]];
      for (let near = Math.max(n - wide, grid.first); near <= n + wide; near += 1) {
        if (near === n || near >= grid.first + grid.width) continue;
        const other = grid.slot(near);
        if (columns.low[other] < least) least = columns.low[other];
        if (columns.high[other] > most) most = columns.high[other];
      }
      if (!(least <= most)) continue;
      const top = (high - most) * scale - half;
      const bottom = (high - least) * scale + half;
      if (period && bottom - top < STEEP * width && !inDash(n, dash, period)) continue;
      this.line(slot, top, bottom, word, opacity);
    }
  }
}

function inDash(number, dash, period) {
  let rest = ((number % period) + period) % period;
  for (let n = 0; n < dash.length; n += 1) {
    if (rest < dash[n]) return n % 2 === 0;
    rest -= dash[n];
  }
  return true;
}
