/** Colours of traces (Okabe and Ito's, by theme) and those of the page, as texts for a canvas. */

import { h } from "../dom.js";

const LIGHT = ["#0072b2", "#c24f00", "#00795a", "#a3477f", "#8a6200", "#1f6f9c", "#13181c", "#6b4fa0"];
const DARK = ["#56b4e9", "#ff8a4c", "#2fd0a0", "#e79cc6", "#f0b73e", "#a8dcff", "#e7ebee", "#c3a9f5"];
const DASHES = [[], [7, 4], [2, 3], [10, 4, 2, 4]];

export class Colours {
  /** `probe`: an element with the class of the same name, whose colours follow the theme. */
  constructor(probe) {
    this._probe = probe;
    this.read();
  }

  read() {
    const style = getComputedStyle(this._probe);
    this.ink = style.color;
    this.ground = style.backgroundColor;
    this.line = style.borderTopColor;
    this.dim = style.outlineColor;
    const [r, g, b] = (this.ground.match(/[\d.]+/g) ?? [255, 255, 255]).map(Number);
    this.dark = r + g + b < 384;
  }

  /** Read them again and call `changed` when the theme is another. Gives the function that ends it. */
  follow(changed) {
    const again = () => {
      this.read();
      changed();
    };
    const scheme = matchMedia("(prefers-color-scheme: dark)");
    const theme = new MutationObserver(again);
    scheme.addEventListener("change", again);
    theme.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    return () => {
      scheme.removeEventListener("change", again);
      theme.disconnect();
    };
  }

  trace(number) {
    return (this.dark ? DARK : LIGHT)[number % LIGHT.length];
  }

  dash(number) {
    return DASHES[Math.floor(number / LIGHT.length) % DASHES.length];
  }
}

/** What `Colours` reads: it has the colours of the theme and is not seen. */
export function probe() {
  return h("span", { class: "scope-colours", "aria-hidden": "true" });
}

/** The plot's own rules, loaded with the first chart. */
export function useStyle() {
  const address = new URL("../vendor/uPlot.min.css", import.meta.url).href;
  if ([...document.styleSheets].some(({ href }) => href === address)) return;
  document.head.append(h("link", { rel: "stylesheet", href: address }));
}
