"""The scope's page in a real browser: traces, cursors and triggers, checked by pyads."""

import csv
import json
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

CHANNEL = "Axes.X.ActPos"
PAGE_BYTES = 300_000
WIDE, PHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}


@pytest.fixture
def station(web_station: Any) -> Any:
    """The station with pages, for the fixtures that ask for a station."""
    return web_station


@pytest.fixture
def nc(station: Any, pyads_connection: Callable[..., Any]) -> Any:
    """pyads on the station's NC."""
    return pyads_connection(station, 500)


@pytest.fixture
def shown(show: Callable[..., AbstractContextManager[Any]], station: Any) -> Iterator[Any]:
    """A tab on the station's pages."""
    with show(station.url, viewport=WIDE) as tab:
        yield tab


def position(nc: Any) -> float:
    """What pyads reads."""
    return float(nc.read_by_name(CHANNEL, pyads.PLCTYPE_LREAL))


def move(shown: Any, nc: Any, target: float, until: Any) -> None:
    """Axis X goes there, by the page's own form, and stands."""
    page = shown.open("axes?axis=1")
    enable = page.get_by_role("button", name=re.compile("^(Enable|Disable)$"))
    enable.wait_for()
    if enable.inner_text() == "Enable":
        enable.click()
        page.get_by_role("button", name="Disable", exact=True).wait_for()
    form = page.locator("form").filter(has=page.get_by_role("button", name="Start (F5)"))
    form.get_by_label("Position").fill(str(target))
    form.get_by_label("Velocity").fill("500")
    form.get_by_role("button", name="Start (F5)").click()
    until(lambda: position(nc) == pytest.approx(target, abs=1e-3))


def painted(page: Any) -> int:
    """Pixels of the charts that have a colour of their own. A flat line may lie between two rows
    of them."""
    return int(
        page.evaluate("""() => [...document.querySelectorAll('.chart canvas')].reduce((sum, c) => {
        const copy = new OffscreenCanvas(c.width, c.height);
        const ctx = copy.getContext('2d', {willReadFrequently: true});
        ctx.drawImage(c, 0, 0);
        const data = ctx.getImageData(0, 0, c.width, c.height).data;
        let n = 0;
        for (let k = 0; k < data.length; k += 4) {
          if (data[k + 3] > 100 && Math.max(data[k], data[k + 1], data[k + 2])
              - Math.min(data[k], data[k + 1], data[k + 2]) > 60) n += 1;
        }
        return sum + n;
    }, 0)""")
    )


def newest(page: Any) -> float:
    """The time of the newest sample."""
    head = page.locator("#scope-readout thead th").nth(2).inner_text()
    match = re.fullmatch(r"Last, (\S+) s", head)
    return float(match[1]) if match else 0.0


def number_in(page: Any, column: int) -> float | None:
    """A number in the row of the first trace; None for a dash."""
    text = page.locator("#scope-readout tbody tr").first.locator("td").nth(column).inner_text()
    return None if text == "–" else float(text)


def test_a_channel_is_found_and_shows_what_pyads_reads(shown: Any, nc: Any, until: Any) -> None:
    page = shown.open("scope")
    page.keyboard.press("/")
    page.keyboard.type(CHANNEL)
    page.get_by_role("button", name=f"500:{CHANNEL}", exact=True).click()
    until(lambda: number_in(page, 1) is not None)
    assert CHANNEL in page.url
    until(lambda: painted(page) > 100)

    other = page.context.new_page()
    other.goto(f"{shown.url}#axes?axis=1")
    tab = type(shown)(other, shown.url, shown.artefacts)
    move(tab, nc, 12.5, until)
    move(tab, nc, 40.0, until)
    other.close()
    until(lambda: number_in(page, 1) == pytest.approx(position(nc), abs=1e-5))
    sizes = page.evaluate(
        "[...performance.getEntriesByType('navigation'),"
        " ...performance.getEntriesByType('resource')].map(each => each.encodedBodySize)"
    )
    assert sum(sizes) < PAGE_BYTES


def test_an_empty_scope_starts_with_an_axis_at_one_click(shown: Any, until: Any) -> None:
    page = shown.open("scope")
    start = page.get_by_text("Start with position and velocity of")
    page.locator("#scope-charts").get_by_role("button", name="Y", exact=True).click()
    until(lambda: number_in(page, 1) is not None and newest(page) > 0)
    assert "traces=Axes.Y.ActPos~1|Axes.Y.ActVelo~2" in unquote(page.url)
    assert not start.is_visible()
    removers = page.get_by_role("button", name="Remove Axes")
    for left in (1, 0):
        removers.first.click()
        until(lambda left=left: removers.count() == left)
    start.wait_for()


def test_enter_adds_the_first_match_of_what_is_typed(shown: Any, until: Any) -> None:
    page = shown.open("scope")
    page.keyboard.press("/")
    page.keyboard.type("actvelo")
    page.locator(".found button").first.wait_for()
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type("axes.y.actpos")
    page.keyboard.press("Enter")  # the matches of ActVelo are still shown
    until(lambda: page.locator("#scope-readout tbody tr").count() == 1)
    assert "traces=500:Axes.Y.ActPos~1" in unquote(page.url)


def test_it_stops_and_its_numbers_are_exported(shown: Any, nc: Any, until: Any) -> None:
    page = shown.open(f"scope?traces={CHANNEL}~1|rate {CHANNEL}~2&width=0.05")
    until(lambda: newest(page) > 0)
    begin = newest(page)
    until(lambda: newest(page) > begin + 0.2)
    page.locator("h1").click()
    page.keyboard.press(" ")
    page.get_by_role("button", name="Run", exact=True).wait_for()
    chart = page.locator(".chart .u-over").first
    chart.click(position={"x": 200, "y": 50})
    page.keyboard.press("c")
    page.keyboard.press("ArrowRight")
    until(lambda: number_in(page, 2) is not None and number_in(page, 3) is not None)
    assert number_in(page, 2) == pytest.approx(position(nc), abs=1e-5)
    assert page.get_by_role("columnheader", name=re.compile("Δt")).count() == 1
    with page.expect_download() as download:
        page.get_by_role("button", name="CSV", exact=True).click()
    with Path(download.value.path()).open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][0] == "time in s"
    assert rows[0][1].startswith(CHANNEL)
    assert float(rows[-1][1]) == pytest.approx(position(nc), abs=1e-9)
    times = [float(row[0]) for row in rows[1:]]
    assert times == sorted(times)
    with page.expect_download() as download:
        page.get_by_role("button", name="PNG").click()
    assert Path(download.value.path()).read_bytes().startswith(b"\x89PNG")


def test_a_trigger_stops_the_scope(shown: Any, nc: Any, until: Any) -> None:
    # it fires at once: the position is above the level; the window is whole soon after
    page = shown.open(
        f"scope?traces={CHANNEL}~1&width=0.2&trigger=single~{CHANNEL}~above~-1000~~~20"
    )
    until(lambda: "Stopped by the trigger" in page.locator("#scope-state").inner_text())
    page.get_by_role("button", name="Run", exact=True).wait_for()
    until(lambda: painted(page) > 100)


def test_form_of_a_trigger_that_is_off_leaves_the_recording_alone(shown: Any) -> None:
    starts: list[dict[str, Any]] = []

    def note(text: str) -> bool:
        """Return true for the start with a trigger."""
        message = json.loads(text)
        if message["call"] == "scope.start":
            starts.append(message["with"])
        return message["call"] == "scope.start" and "trigger" in message["with"]

    with shown.page.expect_websocket() as opened:
        page = shown.open(f"scope?traces={CHANNEL}~1")
    page.locator("#scope-state[data-state=running]").wait_for()
    with opened.value.expect_event("framesent", note):
        page.get_by_label("Level", exact=True).fill("7")
        page.get_by_label("Level", exact=True).press("Tab")
        page.get_by_label("Trigger", exact=True).select_option("normal")
    assert [start.get("trigger", {}).get("level") for start in starts] == [7]


def test_wrong_channel_is_reported(shown: Any) -> None:
    page = shown.open("scope?traces=Axes.X.NoSuch~1")
    page.get_by_role("alert").locator(".notice").wait_for()
    page.get_by_role("button", name="Run", exact=True).wait_for()


def test_scope_is_accessible(shown: Any, until: Any, witness: Callable[[str], None]) -> None:
    witness("axe-core")
    names = f"traces={CHANNEL}~1|Axes.X.ActVelo~2|diff Axes.X.SetPos {CHANNEL}~3"
    page = shown.open(f"scope?{names}&more=fft&first={CHANNEL}")
    until(lambda: painted(page) > 100)
    page.get_by_label("What to draw of them").select_option("xy")
    for theme, rules in (("light", {}), ("dark", {"runOnly": "color-contrast"})):
        page.emulate_media(color_scheme=theme)
        assert shown.serious_findings(**rules) == [], theme
        shown.picture(f"scope-{theme}")
        page.set_viewport_size(PHONE)
        assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
        shown.picture(f"scope-{theme}-phone")
        page.set_viewport_size(WIDE)
