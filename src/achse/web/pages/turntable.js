/** A picture of space that the user turns: by mouse, finger, keys, or a list of views. */

import { Sheet } from "./canvas.js";
import { h } from "./dom.js";
import { Camera, VIEWS } from "./projection.js";

const PER_PIXEL = 0.008;

/** `draw(context, width, height, colours, camera)`; `element` holds the picture and its controls. */
export class Turntable {
  constructor(label, session, draw) {
    this.camera = new Camera(session.view.get("view", "3D"));
    this.sheet = new Sheet(`${label}. Arrow keys turn, plus and minus zoom, 0 shows all.`,
      (context, width, height, colours) => draw(context, width, height, colours, this.camera),
      { keys: true });
    const views = Object.keys(VIEWS).map((name) => {
      const button = h("button", { type: "button", class: "small", "aria-pressed": String(name === this.camera.view) }, name);
      button.addEventListener("click", () => {
        this.camera.look(name);
        session.view.set({ view: name === "3D" ? null : name });
        for (const each of views) each.setAttribute("aria-pressed", String(each === button));
        this.sheet.draw();
      });
      return button;
    });
    const zoom = [["Zoom in", "+", 1.25], ["Zoom out", "−", 0.8]].map(([name, sign, factor]) => {
      const button = h("button", { type: "button", class: "small", "aria-label": name }, sign);
      button.addEventListener("click", () => {
        this.camera.magnify(factor);
        this.sheet.draw();
      });
      return button;
    });
    this._listen();
    this.element = h("div", { class: "stack" },
      h("div", { class: "row", role: "group", "aria-label": "View" }, views, zoom), this.sheet.element,
      h("p", { class: "dim" }, "Drag or arrow keys turn, + and − zoom, 0 shows all."));
  }

  draw() {
    this.sheet.draw();
  }

  end() {
    this.sheet.end();
  }

  _listen() {
    const canvas = this.sheet.element;
    let from = null;
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !this.camera.key(event.key)) return;
      event.preventDefault();
      event.stopPropagation(); // digits go to pages elsewhere
      this.sheet.draw();
    });
    canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (from === null) return;
      this.camera.move((event.clientX - from[0]) * PER_PIXEL, (event.clientY - from[1]) * PER_PIXEL);
      from = [event.clientX, event.clientY];
      this.sheet.draw();
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, () => { from = null; });
    }
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return; // the page is scrolled
      event.preventDefault();
      this.camera.magnify(event.deltaY < 0 ? 1.1 : 1 / 1.1);
      this.sheet.draw();
    }, { passive: false });
  }
}
