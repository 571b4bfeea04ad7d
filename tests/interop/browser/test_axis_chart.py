"""The chart on the page of an axis: it draws what moves, and samples only while it can be seen."""

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

from tests.interop.browser.test_scope import painted

TALL = {"width": 1280, "height": 1400}

RECORD = """
globalThis.scopes = [];
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  const { call, with: values } = JSON.parse(text);
  if (/^scope\\.(start|stop)$/.test(call)) globalThis.scopes.push([call, values.channels ?? null]);
  return send.call(this, text);
};
"""
"""Keep what the page asks of scopes."""

HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""
"""As a browser does when another tab is shown."""

CHANNELS = [f"Axes.X.{name}" for name in ("ActPos", "ActVelo", "PosDiff")]
START: list[Any] = ["scope.start", CHANNELS]
STOP: list[Any] = ["scope.stop", None]


@pytest.fixture
def shown(show: Callable[..., AbstractContextManager[Any]], web_station: Any) -> Iterator[Any]:
    """A tab that keeps what it asks of scopes."""
    with show(web_station.url, viewport=TALL, script=RECORD) as tab:
        yield tab


def scope_calls(page: Any) -> list[Any]:
    """Calls about scopes so far."""
    calls: list[Any] = json.loads(page.evaluate("JSON.stringify(globalThis.scopes)"))
    return calls


def test_chart_of_an_axis_samples_while_it_is_seen(shown: Any, until: Any) -> None:
    page = shown.open("axes?axis=1")
    until(lambda: painted(page) > 50)
    chart = page.get_by_role("img", name="Chart over time of Position in mm, Velocity in mm/s")
    assert chart.count() == 1
    assert page.get_by_role("img", name="Following error in mm").count() == 1
    expected = [START]
    assert scope_calls(page) == expected
    steps: list[tuple[Callable[[], Any], Callable[[], Any]]] = [
        (lambda: page.evaluate(HIDE, True), lambda: page.evaluate(HIDE, False)),
        (
            lambda: page.set_viewport_size({"width": 1280, "height": 200}),
            lambda: page.set_viewport_size(TALL),
        ),
        (
            lambda: page.get_by_role("button", name="Hide the chart").click(),
            lambda: page.get_by_role("button", name="Show the chart").click(),
        ),
    ]
    for hide, show in steps:
        hide()
        expected.append(STOP)
        until(lambda: scope_calls(page) == expected)
        show()
        expected.append(START)
        until(lambda: scope_calls(page) == expected)
    shown.open("axes")
    until(lambda: scope_calls(page) == [*expected, STOP])


def test_hidden_chart_of_an_axis_stays_hidden(shown: Any, until: Any) -> None:
    page = shown.open("axes?axis=1&chart=off")
    page.get_by_role("button", name="Show the chart").wait_for()
    assert page.locator(".chart").count() == 0
    assert scope_calls(page) == []
