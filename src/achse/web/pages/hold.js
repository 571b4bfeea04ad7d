/**
 * A button that works while it is held: `begin` when it goes down, `again` every quarter of a
 * second, `end` once when it is let go, the pointer leaves, the window loses the focus or the
 * connection goes. The server ends a jog too when no repeat comes.
 */

const REPEAT = 250;

export class Hold {
  constructor({ begin, again, end, repeat = REPEAT }) {
    this._means = { begin, again, end };
    this._repeat = repeat;
    this._timer = null;
  }

  get held() {
    return this._timer !== null;
  }

  press() {
    if (this.held) return;
    this._timer = setInterval(() => this._means.again(), this._repeat);
    this._means.begin();
  }

  release() {
    if (!this.held) return;
    clearInterval(this._timer);
    this._timer = null;
    this._means.end();
  }

  /** Pointer and keys of a button. Gives the function that takes the listeners on window away. */
  attach(button) {
    const release = () => this.release();
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || button.disabled) return;
      button.setPointerCapture?.(event.pointerId);
      this.press();
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) {
      button.addEventListener(name, release);
    }
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => {
      if (event.key !== " " && event.key !== "Enter") return;
      event.preventDefault();
      if (!event.repeat && !button.disabled) this.press();
    });
    button.addEventListener("keyup", (event) => {
      if (event.key === " " || event.key === "Enter") release();
    });
    addEventListener("blur", release);
    document.addEventListener("visibilitychange", release);
    return () => {
      removeEventListener("blur", release);
      document.removeEventListener("visibilitychange", release);
      release();
    };
  }
}
