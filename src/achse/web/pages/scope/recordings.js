import { h, panel } from "../dom.js";

/**
 * Traces to compare with: what is seen can be held, a recording opened or laid over the live one.
 *
 * `means`: open(recording), hold(held), drop(), now() gives what is seen now.
 */
export class Recordings {
  constructor(session, recorder, means) {
    this._session = session;
    this._recorder = recorder;
    this._means = means;
    this.shown = "";
    this._choice = h("select", { "aria-label": "Recording" });
    const button = (text, run) => {
      const each = h("button", { type: "button" }, text);
      each.addEventListener("click", run);
      return each;
    };
    const keep = h("input", { type: "checkbox" });
    keep.addEventListener("change", () => {
      recorder.record = keep.checked;
      if (recorder.wanted) recorder.start();
    });
    this._choice.addEventListener("focus", () => this.refresh());
    this._drops = button("Drop the held", means.drop);
    this.holds = false;
    this._uses = [button("Open", () => this._load(means.open)),
      button("Compare with it", () => this._load((recording) => means.hold(held(recording))))];
    this.element = panel("Compare",
      h("div", { class: "row" },
        button("Hold what is seen", () => this._hold()), this._drops,
        h("label", { class: "check" }, keep, " Keep as a recording when it stops"),
        this._choice, this._uses));
    this.refresh();
  }

  /** Is something held that can be dropped? */
  set holds(held) {
    this._drops.disabled = !held;
  }

  close() {
    this.shown = "";
  }

  async refresh() {
    let rows = [];
    try {
      rows = await this._session.call("scope.recordings");
    } catch {
      // a target without them: the list stays empty
    }
    const chosen = this._choice.value;
    this._choice.replaceChildren(...(rows.length
      ? rows.map(({ name }) => h("option", { value: name }, name))
      : [h("option", { value: "" }, "no recording")]));
    if (rows.some(({ name }) => name === chosen)) this._choice.value = chosen;
    for (const each of this._uses) each.disabled = rows.length === 0;
  }

  _hold() {
    const seen = this._means.now();
    if (seen === null) {
      this._session.say("Nothing is seen yet that could be held.");
      return;
    }
    this._means.hold(seen);
    this._session.say("Held: drawn dashed in the charts.");
  }

  async _load(use) {
    const name = this._choice.value;
    if (!name) return;
    try {
      const recording = await this._recorder.load(name);
      if (use === this._means.open) this.shown = name;
      use(recording);
    } catch (error) {
      this._session.fail(error);
    }
  }
}

function held({ ring, columns, trigger }) {
  return { times: ring.part(0, ring.start, ring.end), anchor: trigger ?? ring.last,
    values: new Map(columns.map((name, n) => [name, ring.part(n + 1, ring.start, ring.end)])) };
}
