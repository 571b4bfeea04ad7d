/** A canvas in the colours of the theme, as sharp as the screen, drawn again only when it must. */

import { h } from "./dom.js";

const COLOURS = ["panel", "line", "edge", "ink", "dim", "accent", "good", "warn", "bad", "raised"];

/** The page's colours now, by the names of the style sheet. */
export function colours(element) {
  const style = getComputedStyle(element);
  // a probe resolves light-dark(), which a custom property keeps as it was written
  const probe = h("span", { hidden: true });
  element.parentElement?.append(probe);
  const found = Object.fromEntries(COLOURS.map((name) => {
    probe.style.color = `var(--${name})`;
    return [name, getComputedStyle(probe).color];
  }));
  probe.remove();
  return { ...found, font: style.fontFamily };
}

/**
 * `new Sheet("what it shows", (context, width, height, colours) => …)`; `sheet.draw()` asks for a
 * picture in the next frame; `sheet.end()` when the page is left. Widths are in CSS pixels.
 */
export class Sheet {
  constructor(label, draw, { keys = false } = {}) {
    this.element = h("canvas", {
      class: "sheet", role: "img", "aria-label": label, tabindex: keys ? "0" : null,
    });
    this._draw = draw;
    this._due = null;
    this._colours = null;
    this._sizes = new ResizeObserver(() => this.draw());
    this._sizes.observe(this.element);
    const fresh = () => {
      this._colours = null;
      this.draw();
    };
    this._theme = new MutationObserver(fresh);
    this._theme.observe(document.documentElement, { attributeFilter: ["data-theme"] });
    this._dark = matchMedia("(prefers-color-scheme: dark)");
    this._dark.addEventListener("change", fresh);
    this._fresh = fresh;
  }

  draw() {
    this._due ??= requestAnimationFrame(() => {
      this._due = null;
      this._paint();
    });
  }

  end() {
    if (this._due !== null) cancelAnimationFrame(this._due);
    this._due = -1; // nothing is drawn any more
    this._sizes.disconnect();
    this._theme.disconnect();
    this._dark.removeEventListener("change", this._fresh);
  }

  _paint() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 3);
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.element.width !== wide || this.element.height !== high) {
      this.element.width = wide;
      this.element.height = high;
    }
    this._colours ??= colours(this.element);
    const context = this.element.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    this._draw(context, width, height, this._colours);
  }
}
