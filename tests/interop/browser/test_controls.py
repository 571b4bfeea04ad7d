"""Every button, field and key of every page does something, and nothing stands on the console."""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from tests.interop.browser.test_paths import PROGRAM, STATION

EXAMPLES = Path(__file__).parents[3] / "examples"
FULL_AFTER = 10
"""Round trips to the server without another control."""

IDLE_AFTER = 40
"""Round trips without anything done or shown, after a control that does nothing."""

WIDE = {"width": 1280, "height": 1000}
TRACES = "traces=Axes.X.ActPos~1|Axes.X.ActVelo~2&width=1"

LISTEN = """
globalThis.done = 0;
const TRIP = 1e9;
globalThis.trip = async () => {
  await new Promise((resolve) => {
    globalThis.arrived = resolve;
    send.call(globalThis.line, JSON.stringify({ id: TRIP, call: "hello", with: {} }));
  });
  await new Promise((resolve) => setTimeout(resolve, 20)); // the page draws
};
globalThis.asked = new Set();
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  const { id, call } = JSON.parse(text);
  if (call !== "hello") globalThis.done += 1;
  globalThis.asked.add(id);
  if (globalThis.line !== this) this.addEventListener("message", ({ data }) => {
    if (typeof data !== "string") return;
    const { id: answered } = JSON.parse(data);
    globalThis.asked.delete(answered);
    if (answered === TRIP) globalThis.arrived();
  });
  globalThis.line = this;
  return send.call(this, text);
};
const paper = new OffscreenCanvas(160, 120).getContext("2d", { willReadFrequently: true });
globalThis.small = (sheet) => {
  paper.clearRect(0, 0, 160, 120);
  paper.drawImage(sheet, 0, 0, 160, 120);
  let sum = 0;
  for (const each of new Uint32Array(paper.getImageData(0, 0, 160, 120).data.buffer)) {
    sum = (Math.imul(sum, 31) + each) | 0;
  }
  return sum;
};
const click = HTMLAnchorElement.prototype.click;
HTMLAnchorElement.prototype.click = function () {
  globalThis.done += 1;
  return click.call(this);
};
"""
"""Count what the page asks its server for and the files that it saves; `trip()` is a round trip."""

MARK = """() => {
  const names = new Set();
  for (const each of document.querySelectorAll("[data-control]")) delete each.dataset.control;
  const kinds = "a[href], button, input, select, summary, canvas[tabindex], [role=treeitem]";
  for (const each of document.querySelectorAll(kinds)) {
    if (!each.checkVisibility() || each.disabled || !each.closest("#page, dialog")) continue;
    const row = each.closest("tbody tr, [role=treeitem], .found li");
    if (row && row.parentElement.querySelector(`:scope > ${row.tagName}`) !== row) continue;
    const label = each.getAttribute("aria-label") || each.closest("label")?.innerText
      || (each.matches("[role=treeitem]") ? "first" : each.innerText) || each.name;
    const words = label.split(/[:;.] /)[0].trim().replace(/\\s+/g, " ");
    const name = `${each.getAttribute("role") ?? each.tagName.toLowerCase()} ${words}`;
    if (names.has(name)) continue;
    names.add(name);
    each.dataset.control = name;
  }
  return [...names];
}"""
"""Give each control that is seen and not off its name; of equal rows the first counts."""

SEEN = """() => {
  const told = [location.hash, globalThis.done, JSON.stringify(localStorage)];
  const walk = (node) => {
    if (node.nodeType === Node.TEXT_NODE) told.push(node.data.replace(/[-−\\d.,:e%]+/g, ""));
    if (node.nodeType !== Node.ELEMENT_NODE || node.matches(".lines li, #connection")) return;
    told.push(node.tagName, node.className, node.hidden, node.disabled, node.open, node.checked);
    for (const name of node.getAttributeNames()) {
      const value = node.getAttribute(name);
      if (name.startsWith("aria-") && !/\\d/.test(value)) told.push(value);
    }
    if (node.matches("canvas.sheet")) told.push(globalThis.small(node));
    if (node.matches("form select, form input")) told.push(node.value);
    node.childNodes.forEach(walk);
  };
  walk(document.body);
  return told.join("\\n");
}"""
"""What the page shows and has done, without numbers: they move by themselves."""

CHANGED = f"""async ([before, trips]) => {{
  const seen = {SEEN};
  for (let trip = 0; trip < trips || globalThis.asked.size > 0; trip += 1) {{
    if (seen() !== before) return true;
    await globalThis.trip();
  }}
  return seen() !== before;
}}"""
"""Whether something is done or shown within so many round trips, and until all is answered."""

FULL = f"""async (trips) => {{
  const mark = {MARK};
  let count = -1;
  for (let same = 0; same < trips || globalThis.asked.size > 0 || count <= 0; same += 1) {{
    const now = mark().length;
    if (now !== count) same = 0;
    count = now;
    await globalThis.trip();
  }}
  return mark();
}}"""
"""Names of the controls of a page when no more of them come, and there is one."""

LOOK = f"""async ([name, hash, trips, patience]) => {{
  const seen = {SEEN};
  if (hash !== null) {{
    for (const each of document.querySelectorAll("dialog[open]")) each.close();
    location.hash = hash;
    let before = "";
    for (let trip = 0; trip < trips; trip += 1) {{
      await globalThis.trip();
      const now = seen();
      if (now === before && globalThis.asked.size === 0) break;
      before = now;
    }}
  }}
  const find = () => {{
    ({MARK})();
    return [...document.querySelectorAll("[data-control]")]
      .find(({{ dataset }}) => dataset.control === name);
  }};
  let each = find();
  for (let trip = 0; !each && trip < patience; trip += 1) {{
    await globalThis.trip();
    each = find();
  }}
  if (!each) return null;
  const place = {{
    kind: each.type || each.tagName.toLowerCase(),
    role: each.getAttribute("role"),
    row: each.closest("[role=treeitem]") !== null,
    window: each.target === "_blank" ? each.href : null,
    others: each.options ? [...each.options].map(({{ value }}) => value) : [],
    value: each.value,
  }};
  return [place, seen()];
}}"""
"""Kind of a control and what the page shows; null if the page does not have the control.

With an address the page goes back there first, until nothing is shown or asked any more. The
control may come so many round trips later.
"""

FOLLOW = "button Follow the newest samples"
FIRST = {
    "button Cursor A": ["button Cursor B"],
    FOLLOW: ["button Zoom in"],
    "button Earlier": [FOLLOW],
    "button Later": [FOLLOW],
    "button Drop the held": ["button Hold what is seen"],
    "tab Log": ["tab Traffic"],
    "button 3D": ["button XZ"],
    "button Zoom in": ["button Load", FOLLOW],
    "button Zoom out": ["button Load", FOLLOW],
    "select Kind of trigger": ["select Trigger"],
    "input Level": ["select Trigger"],
    "input Part before the trigger in percent": ["select Trigger"],
}
"""Controls to use before a control has anything to do, as far as the page has them."""

KEEPS = {"select Add to", "select Recording"}
"""What is chosen here is used by the button beside it."""

Show = Callable[..., AbstractContextManager[Any]]


@pytest.fixture(scope="module")
def used() -> dict[str, set[str]]:
    """Controls that were used before, by page: with other options a page has most of them again."""
    return {}


@pytest.fixture
def mill(serve_pages: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A station with a cam table and a channel."""
    folder = tmp_path_factory.mktemp("mill")
    (folder / "mill.toml").write_text(STATION, encoding="utf-8")
    (folder / "plate.nc").write_text(PROGRAM, encoding="utf-8")
    with serve_pages(str(folder / "mill.toml")) as running:
        yield running


@pytest.fixture
def drives(serve_pages: Any) -> Iterator[Any]:
    """A station with drives on a bus."""
    with serve_pages(str(EXAMPLES / "drives" / "station.toml")) as running:
        yield running


def use(page: Any, name: str, control: dict[str, Any]) -> None:
    """What a user does with a control: types into it, chooses another, presses it."""
    place = page.locator(f"[data-control={json.dumps(name, ensure_ascii=False)}]").first
    kind, role = control["kind"], control["role"]
    if control["row"] and role != "treeitem":
        place.locator("xpath=ancestor::*[@role='treeitem'][1]").hover()  # it is seen then
    if kind in ("text", "search"):
        place.fill("7")
        place.press("Tab")
    elif kind == "select-one":
        now = control["value"]
        if control["others"]:
            place.select_option(next((each for each in control["others"] if each != now), now))
    elif kind == "range":
        place.press("ArrowLeft")
    elif kind == "canvas":
        place.press("ArrowRight")  # a cursor is at the left first
    else:
        place.click()
        if role == "treeitem":  # the place itself may be gone now
            page.keyboard.press("Enter")


def anew(tab: Any, name: str) -> Any:
    """The page as it is when it is opened first."""
    tab.leave()
    return tab.open(name)


def does_something(page: Any, control: str, trips: int, address: str | None = None) -> bool | None:
    """Use a control, and return true if something is seen or asked for; None if it is not there.

    With an address the page is brought back there first.
    """
    for name in (*FIRST.get(control, []), control):
        patience = FULL_AFTER if name == control and address is not None else 0
        state = page.evaluate(LOOK, [name, address, FULL_AFTER, patience])
        address = None
        if not state:
            continue
        place, before = state
        if place["window"] is not None:
            return re.match("https?://", place["window"]) is not None
        use(page, name, place)
        changed = bool(page.evaluate(CHANGED, [before, trips]))
    return changed if state else None


def is_idle(tab: Any, name: str, address: str, control: str) -> bool:
    """Return true if a control does nothing: on the page as it is, shown again, and loaded anew."""
    if does_something(tab.page, control, FULL_AFTER, address):
        return False
    tab.page.evaluate("location.hash = '#none'")
    if does_something(tab.page, control, FULL_AFTER, address):
        return False
    for trips in (1, FULL_AFTER, 10 * FULL_AFTER):  # some controls need samples, which come later
        page = anew(tab, name)
        while control not in page.evaluate(FULL, trips):
            pass
        if does_something(page, control, IDLE_AFTER):
            return False
    return True


@pytest.mark.parametrize(
    ("station", "name"),
    [
        ("web_station", "overview"),
        ("web_station", "axes"),
        ("web_station", "axes?axis=1&move=velocity"),
        ("web_station", "axes?axis=1&find=jog_velocity"),
        ("web_station", "scope"),
        ("web_station", f"scope?{TRACES}"),
        ("web_station", f"scope?{TRACES}&more=fft"),
        ("web_station", f"scope?{TRACES}&more=xy"),
        ("web_station", "symbols"),
        ("web_station", "symbols?watch=GVL.nDint&search=nDint"),
        ("web_station", "log"),
        ("web_station", "log?show=traffic"),
        ("web_station", "faults?kind=error"),
        ("drives", "drives"),
        ("mill", "paths?file=plate.nc"),
        ("portal", "scene"),
    ],
)
def test_every_control_does_something(
    show: Show,
    station: str,
    name: str,
    used: dict[str, set[str]],
    request: pytest.FixtureRequest,
) -> None:
    running = request.getfixturevalue(station)
    with show(running.url, viewport=WIDE, script=LISTEN) as tab:
        controls = tab.open(name).evaluate(FULL, FULL_AFTER)
        address = f"#{tab.page.url.partition('#')[2]}"
        seen = used.setdefault(tab.page.url.partition("?")[0], set(KEEPS))
        idle = [each for each in controls if each not in seen and is_idle(tab, name, address, each)]
        seen.update(controls)
        assert len(controls) > 0
        assert idle == []
