"""Every key that the help names does what it says, on the page where it says so."""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

Show = Callable[..., AbstractContextManager[Any]]

WIDE = {"width": 1280, "height": 1000}
TRACES = "traces=Axes.X.ActPos~1|Axes.X.ActVelo~2&width=1"

TOLD = {
    "F6 or Ctrl+.", "1 … 9", "?", "/", "F1 F2 F3 F4", "F5", "F8, F9", "↑ ↓ ← →", "Space", "T, C",
    "← →", "+ −", "Esc", "↑ ↓ ← → + − 0",
}  # fmt: skip
"""The keys of the help; each has a test here."""

RECORD = """
globalThis.sent = [];
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  const { call, with: values } = JSON.parse(text);
  if (call === "axes.do") globalThis.sent.push(values);
  return send.call(this, text);
};
"""
"""Keep what the page asks of axes."""

JOGS = [("F1", -1, True), ("F2", -1, False), ("F3", 1, False), ("F4", 1, True)]


@pytest.fixture
def shown(show: Show, web_station: Any) -> Iterator[Any]:
    """A tab on the demo station, which keeps what it asks of axes."""
    with show(web_station.url, viewport=WIDE, script=RECORD) as tab:
        yield tab


def sent(page: Any) -> list[dict[str, Any]]:
    """What axes were asked since this was called before."""
    calls: list[dict[str, Any]] = json.loads(
        page.evaluate("JSON.stringify(globalThis.sent.splice(0))")
    )
    return calls


def ready(page: Any) -> None:
    """The page of an axis knows its state."""
    page.wait_for_function(
        "() => [...document.querySelectorAll('button')]"
        ".some(({textContent, disabled}) => /^(En|Dis)able$/.test(textContent) && !disabled)"
    )


DRAWN = """() => new Promise((drawn) => {
  requestAnimationFrame(() => requestAnimationFrame(drawn));
})"""
"""Wait until the page has drawn what it knows."""


def press(page: Any, key: str) -> None:
    """A key that belongs to the page: no field has the focus."""
    page.evaluate("document.activeElement?.blur()")
    page.keyboard.press(key)


def test_the_help_has_the_keys_that_are_tested(shown: Any) -> None:
    page = shown.open("overview")
    press(page, "?")
    page.get_by_role("dialog").wait_for()
    assert set(page.locator("dialog kbd").all_inner_texts()) == TOLD
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="hidden")


def test_digits_go_to_pages_and_slash_to_their_search(shown: Any) -> None:
    page = shown.open("overview")
    titles = page.locator("#nav a").all_inner_texts()
    assert len(titles) >= 6
    searches = 0
    for number, title in enumerate(titles[:9], 1):
        press(page, str(number))
        page.wait_for_function(
            "title => document.querySelector('#title').textContent === title", arg=title
        )
        search = page.locator("#page input[type=search]")
        if search.count():
            searches += 1
            press(page, "/")
            assert search.first.evaluate("each => each === document.activeElement")
            page.keyboard.type("1/2?")  # a field that is typed into keeps these keys
            assert search.first.input_value() == "1/2?"
            assert page.locator("#title").inner_text() == title
    assert searches >= 3


def test_stop_is_sent_from_every_page(shown: Any) -> None:
    page = shown.open("overview")
    for name in page.locator("#nav a").evaluate_all("all => all.map((a) => a.dataset.page)"):
        shown.open(name)
        sent(page)
        for key in ("F6", "Control+."):
            press(page, key)
            page.wait_for_function("() => globalThis.sent.length > 0")
            assert sent(page) == [{"axis": None, "action": "stop"}], (name, key)


def test_stop_that_cannot_be_sent_is_reported(show: Show, serve_pages: Any) -> None:
    with serve_pages("--web-read-only") as running, show(running.url) as tab:
        page = tab.open("overview")
        assert page.locator("#stop").is_disabled()
        page.keyboard.press("F6")
        page.get_by_text("Stop was not sent: these pages may only look.").wait_for()


def test_keys_of_an_axis(shown: Any) -> None:
    page = shown.open("axes?axis=1&target=3&velocity=10")
    ready(page)
    sent(page)
    for key, direction, fast in JOGS:
        page.keyboard.down(key)
        page.keyboard.up(key)
        page.wait_for_function("() => globalThis.sent.length > 1")
        first, *_, last = sent(page)
        assert first == {"axis": 1, "action": "jog", "direction": direction, "fast": fast}
        assert last == {"axis": 1, "action": "jog", "direction": 0}
    page.wait_for_timeout(100)
    sent(page)
    calls_by_key: dict[str, dict[str, Any]] = {
        "F5": {"action": "move", "to": 3, "velocity": 10},
        "F8": {"action": "reset"},
        "F9": {"action": "home"},
    }
    for key, wanted in calls_by_key.items():
        page.keyboard.press(key)
        assert sent(page) == [{"axis": 1, **wanted}]
    # with another key they are those of the browser and of the window
    for other in ("Alt+F4", "Control+F4", "Shift+F3", "Alt+F1", "Control+F8", "Shift+F9"):
        page.keyboard.press(other)
        assert sent(page) == [], other
    page.evaluate("globalThis.sent.length = 0")
    page.get_by_role("button", name="Halt").click()
    page.get_by_text("Halt: sent.").wait_for()


def test_a_jog_ends_when_its_key_is_let_go_whatever_is_open(shown: Any) -> None:
    page = shown.open("axes?axis=1")
    ready(page)
    page.get_by_role("button", name="Enable", exact=True).click()
    page.get_by_role("button", name="Disable", exact=True).wait_for()
    page.keyboard.down("F3")
    page.wait_for_function(
        "() => globalThis.sent.filter(({action}) => action === 'jog').length > 1"
    )
    page.get_by_role("button", name="Help").focus()
    page.keyboard.press("?")
    page.get_by_role("dialog").wait_for()
    page.keyboard.up("F3")
    page.wait_for_function("() => globalThis.sent.at(-1).direction === 0")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Disable", exact=True).click()
    page.get_by_role("button", name="Enable", exact=True).wait_for()


def test_an_axis_whose_state_is_not_known_gets_nothing(show: Show, web_station: Any) -> None:
    """Values of the axis do not come: what a button would do is not known."""

    def between(socket: Any) -> None:
        server = socket.connect_to_server()
        server.on_message(
            lambda text: None if '"event":"data"' in str(text)[:40] else socket.send(text)
        )

    with show(web_station.url, viewport=WIDE, script=RECORD, fresh=True) as tab:
        tab.page.route_web_socket(re.compile("/ws"), between)
        page = tab.open("axes?axis=1&target=3&velocity=10")
        names = ["Power", "Reset", "Home", "Halt", "Stop axis", "Start (F5)", "Jog forward (F3)"]
        for name in names:
            assert page.get_by_role("button", name=name, exact=True).is_disabled(), name
        sent(page)
        for key in ("F1", "F2", "F3", "F4", "F5", "F8", "F9"):
            page.keyboard.press(key)
            page.get_by_text("The state of the axis is not known: nothing was sent.").wait_for()
            assert sent(page) == [], key
        assert page.evaluate("performance.getEntriesByType('navigation')[0].type") == "navigate"


def test_keys_of_the_scope(shown: Any, until: Any) -> None:
    page = shown.open(f"scope?{TRACES}")
    run = page.locator("button[aria-keyshortcuts=Space]")
    state = page.locator("#scope-state")
    until(lambda: "Running" in state.inner_text())
    press(page, " ")
    until(lambda: run.inner_text() == "Run" and "Stopped" in state.inner_text())
    press(page, " ")
    until(lambda: run.inner_text() == "Stop" and "Running" in state.inner_text())

    mode = page.get_by_label("Trigger", exact=True)
    for key, wanted in (("t", "normal"), ("T", "off")):
        press(page, key)
        assert mode.input_value() == wanted
    for key, chosen in (("c", "B"), ("C", "A")):
        press(page, key)
        button = page.get_by_role("button", name=f"Cursor {chosen}")
        assert button.get_attribute("aria-pressed") == "true"

    until(lambda: "Running" in state.inner_text())
    head = page.locator("#scope-readout thead th").nth(3)

    def cursor() -> float:
        match = re.fullmatch(r"A, (\S+) s", head.inner_text())
        return float(match[1]) if match else 0.0

    def is_placed() -> bool:
        return re.fullmatch(r"A, \S+ s", head.inner_text()) is not None

    def places_a_cursor() -> bool:
        """Press the key; before the first samples are there it does nothing."""
        press(page, "ArrowLeft")
        page.evaluate(DRAWN)
        return is_placed()

    until(places_a_cursor)
    assert "stands still" in state.inner_text()
    press(page, "Escape")  # forgets every press of before, also one that is not drawn yet
    until(lambda: head.inner_text() == "A")
    press(page, "ArrowLeft")
    until(is_placed)
    for key, step in (("ArrowLeft", -0.01), ("ArrowRight", 0.01), ("Shift+ArrowLeft", -0.002)):
        before = cursor()
        press(page, key)
        until(lambda before=before: cursor() != before)
        assert cursor() - before == pytest.approx(step, abs=1e-4), key
    follow = page.get_by_role("button", name="Follow the newest samples")
    press(page, "Escape")
    until(lambda: head.inner_text() == "A" and follow.get_attribute("aria-pressed") == "true")
    for key in ("+", "-"):
        press(page, key)
        until(lambda: follow.get_attribute("aria-pressed") == "false")
        press(page, "Escape")
        until(lambda: follow.get_attribute("aria-pressed") == "true")


def test_what_run_and_stop_say_is_what_they_do(shown: Any, until: Any) -> None:
    """Pressed twice at once: the second time before the server has answered the first."""
    page = shown.open(f"scope?{TRACES}")
    run = page.locator("button[aria-keyshortcuts=Space]")
    state = page.locator("#scope-state")
    until(lambda: "Running" in state.inner_text())
    for _ in range(4):
        said = run.evaluate(
            "each => [0, 1].map(() => {"
            " const said = each.textContent; each.click(); return said; })"
        )
        wanted = ("Run", "Stopped") if said[-1] == "Stop" else ("Stop", "Running")
        until(
            lambda wanted=wanted: run.inner_text() == wanted[0] and wanted[1] in state.inner_text()
        )
        page.wait_for_timeout(100)
        assert run.inner_text() == wanted[0]


def test_keys_without_ctrl_can_be_switched_off(shown: Any, until: Any) -> None:
    page = shown.open(f"scope?{TRACES}")
    press(page, "?")
    page.get_by_label("Keys without Ctrl").uncheck()
    page.keyboard.press("Escape")
    mode = page.get_by_label("Trigger", exact=True)
    follow = page.get_by_role("button", name="Follow the newest samples")
    until(lambda: follow.get_attribute("aria-pressed") == "true")
    for key in ("t", "c", "+", "1", "?", "/"):
        press(page, key)
    assert mode.input_value() == "off"
    assert page.get_by_role("button", name="Cursor A").get_attribute("aria-pressed") == "true"
    assert follow.get_attribute("aria-pressed") == "true"
    assert page.locator("#title").inner_text() == "Scope"
    assert page.locator("dialog[open]").count() == 0
    sent(page)
    press(page, "F6")
    page.wait_for_function("() => globalThis.sent.length > 0")
    assert sent(page) == [{"axis": None, "action": "stop"}]


def test_keys_of_the_tree(shown: Any, until: Any) -> None:
    page = shown.open("symbols")
    items = page.get_by_role("treeitem")
    until(lambda: items.count() > 1)
    items.first.focus()
    focused = "document.activeElement.getAttribute('aria-label')"
    top = page.evaluate(focused)
    page.keyboard.press("ArrowDown")
    second = page.evaluate(focused)
    assert second != top
    page.keyboard.press("ArrowUp")
    assert page.evaluate(focused) == top
    page.keyboard.press("End")
    last = page.evaluate(focused)
    assert last != top
    page.keyboard.press("Home")
    assert page.evaluate(focused) == top
    gvl = page.get_by_role("treeitem", name="GVL").first
    gvl.focus()
    page.keyboard.press("ArrowRight")
    until(lambda: gvl.locator("[role=treeitem]").count() > 5)
    page.keyboard.press("ArrowRight")
    inside = page.evaluate(focused)
    page.keyboard.press("Enter")
    path = f"GVL.{inside.split(',')[0]}".replace("GVL.GVL.", "GVL.")
    until(lambda: path in page.url)
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    assert gvl.get_attribute("aria-expanded") == "false"


def test_keys_of_a_picture(show: Show, portal: Any) -> None:
    with show(portal.url, viewport=WIDE) as tab:
        page = tab.open("scene")
        canvas = page.locator("canvas.sheet")
        canvas.focus()
        page.wait_for_function("() => document.querySelector('canvas.sheet').width > 400")
        first = canvas.evaluate("each => each.toDataURL()")
        for key in ("ArrowLeft", "ArrowUp", "+", "ArrowRight", "-", "ArrowDown", "+", "0"):
            before = canvas.evaluate("each => each.toDataURL()")
            page.keyboard.press(key)
            page.wait_for_function(
                "before => document.querySelector('canvas.sheet').toDataURL() !== before",
                arg=before,
            )
        assert canvas.evaluate("each => each.toDataURL()") == first
