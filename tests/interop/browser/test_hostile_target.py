"""A target whose names and texts are scripts and markup: all of it is shown as text.

The server of these tests is played by the test: the page's WebSocket ends here.
"""

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

EVIL = "<img src=/x onerror=\"document.title='bad'\"><script>document.title='bad'</script>'\"&amp;"
LINK = "javascript:document.title='bad'"
LONG = "W" * 5000
"""Nothing to break a line at."""

AXIS = {
    "id": 1,
    "name": EVIL,
    "unit": EVIL,
    "state": EVIL,
    "error": 1,
    "error_text": EVIL,
    "error_link": LINK,
    "position": 1e300,
    "velocity": None,
    "following_error": -0.0,
    "enabled": True,
    "moving": True,
    "override": 1,
    "enable": {},
}
ROW = {"key": EVIL, "name": EVIL, "value": EVIL, "unit": EVIL, "meaning": EVIL, "link": LINK}
SYMBOL = {
    "name": EVIL,
    "path": EVIL,
    "type": EVIL,
    "comment": LONG,
    "size": 1,
    "writable": True,
    "children": True,
    "methods": True,
}
FAULT = {"number": 1, "state": EVIL, "hits": 1, "kind": EVIL, "text": LONG}
SLAVE = {"station": 1, "name": EVIL, "state": EVIL, "faults": [EVIL, LONG], "vendor": EVIL}

ANSWERS: dict[str, Any] = {
    "hello": {
        "version": EVIL,
        "target": EVIL,
        "name": EVIL,
        "control": True,
        "time": None,
        "features": ["overview", "axes", "symbols", "drives", "bus", "log", "traffic", "faults"],
    },
    "axes.parameters": [{"group": EVIL, "rows": [{**ROW, "writable": True}]}],
    "symbols.list": {"rows": [SYMBOL], "more": 3},
    "symbols.methods": [
        {"name": EVIL, "returns": EVIL, "parameters": [{"name": EVIL, "type": EVIL}]}
    ],
    "drives.objects": [ROW],
    "faults.list": [{"kind": EVIL, "meaning": EVIL, "fields": [{"name": EVIL, "type": EVIL}]}],
}

VALUES: dict[str, Any] = {
    "overview": {
        "devices": [{"name": EVIL, "port": 1, "state": EVIL, "requests": EVIL}],
        "clients": [{"address": LONG, "peer": EVIL}],
        "faults": [FAULT],
        "cycle": {"tick": EVIL},
        "axes": {},
    },
    "axes": [AXIS],
    "axis": {"axis": AXIS, "details": [{"group": EVIL, "rows": [ROW]}]},
    "symbols": {EVIL: {"text": EVIL}, LONG: {"error": LONG}},
    "drives": [{"drive": 1, "name": EVIL, "state": EVIL, "error": EVIL, "error_link": LINK}],
    "bus": [{"name": EVIL, "net_id": LONG, "state": EVIL, "faults": [EVIL], "slaves": [SLAVE]}],
    "faults": [FAULT],
    "log": [{"time": 1, "level": "error", "source": EVIL, "text": LONG + EVIL}],
    "traffic": [
        {"time_ns": 1, "peer": EVIL, "device": EVIL, "command": EVIL, "items": [{"text": EVIL}]}
    ],
}

TOO_WIDE = """() => document.documentElement.scrollWidth <= innerWidth ? [] :
    [...document.querySelectorAll("body *")]
        .filter(each => !each.closest(".scroll, .nav, .lines, .tree"))
        .filter(each => each.getBoundingClientRect().right > innerWidth + 1)
        .map(each => `${each.tagName}.${each.className}`).slice(0, 5)"""

PAGES = (
    "overview",
    "axes",
    "axes?axis=1",
    "symbols",
    "drives",
    "log",
    "log?show=traffic",
    "faults",
)


def answer(text: str, send: Callable[[str], None]) -> None:
    """What the hostile server says to a message of the page."""
    message = json.loads(text)
    name, number = message["call"], message["id"]
    if name == "watch":
        send(json.dumps({"id": number, "result": {"watch": number}}))
        value = VALUES[message["with"]["topic"]]
        send(json.dumps({"event": "data", "watch": number, "value": value, "lost": 0}))
    elif name in ANSWERS:
        send(json.dumps({"id": number, "result": ANSWERS[name]}))
    elif name == "unwatch":
        send(json.dumps({"id": number, "result": {}}))
    else:
        error = {"text": EVIL, "code": 1, "name": EVIL, "link": LINK}
        send(json.dumps({"id": number, "error": error}))


class Played:
    """A tab whose WebSocket ends here."""

    def __init__(self, tab: Any) -> None:
        self.tab = tab
        self.send: Callable[[str], None]
        tab.page.route_web_socket("**/ws*", self.serve)

    def serve(self, ws: Any) -> None:
        self.send = ws.send
        ws.on_message(lambda text: answer(text, ws.send))

    def tell(self, message: dict[str, Any]) -> None:
        self.send(json.dumps(message))


@pytest.fixture(scope="module")
def played(show: Callable[..., AbstractContextManager[Any]], web_station: Any) -> Iterator[Played]:
    """One for the tests of this file: a route stays until its tab is closed."""
    with show(web_station.url, viewport={"width": 390, "height": 844}, fresh=True) as tab:
        yield Played(tab)


@pytest.fixture
def shown(played: Played) -> Iterator[Any]:
    """The tab, judged after each test."""
    yield played.tab
    assert played.tab.complaints == []
    played.tab.leave()


@pytest.mark.parametrize("name", PAGES)
def test_everything_is_text(shown: Any, name: str) -> None:
    page = shown.open(name)
    page.wait_for_function("() => document.querySelector('#page').textContent.includes('onerror')")
    if name == "symbols":
        page.get_by_role("treeitem").first.press("ArrowRight")
        page.get_by_role("button", name="Methods").first.click()
        page.get_by_role("dialog").wait_for()
        page.keyboard.press("Escape")
        page.get_by_role("treeitem").first.press("Enter")
    if name.startswith("axes"):
        page.get_by_role("button", name="Disable").click()
        page.locator(".notice").wait_for()
    assert page.locator("img, #page script, a[href^='javascript']").count() == 0
    assert page.title().count("bad") == EVIL.count("bad")
    wide = page.evaluate(TOO_WIDE)
    assert wide == [], "texts without spaces make the page wider than the screen"


def test_a_hostile_server_does_not_break_the_page(shown: Any, played: Played) -> None:
    """Unknown events, answers that nobody asked for, values of another kind."""
    page = shown.open("overview")
    for message in (
        {"event": "new kind of event", "value": EVIL},
        {"event": "data", "watch": 99, "value": {}},
        {"id": 12345, "result": None},
        {"id": "x", "error": {"text": EVIL}},
    ):
        played.tell(message)
    page.get_by_role("link", name="Axes").first.click()
    page.wait_for_function("() => document.title.startsWith('Axes')")


def test_target_that_does_not_answer_is_reported(shown: Any, played: Played) -> None:
    """The server is there, what it shows is not: an error of a watch stays until values come."""
    page = shown.open("overview")
    page.locator("#page tbody tr").first.wait_for()
    played.tell({"event": "connection", "state": "lost", "text": "the cable"})
    page.get_by_text("Target does not answer: the cable").wait_for()
    watch = 2  # the second call of the page: hello, watch
    data = {"event": "data", "watch": watch}
    played.tell({**data, "value": None, "error": {"text": "no link"}})
    page.get_by_role("alert").get_by_text("no link").wait_for()
    played.tell({"event": "connection", "state": "back", "text": ""})
    page.get_by_text("Connected", exact=True).wait_for()
    played.tell({**data, "value": VALUES["overview"]})
    page.get_by_text("no link").wait_for(state="detached")
