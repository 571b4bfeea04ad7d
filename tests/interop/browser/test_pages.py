"""The pages of a station in a real browser: what an engineer does there, checked by pyads."""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

PAGES = (
    "overview",
    "axes",
    "axes?axis=1&find=velocity",
    "scope?traces=Axes.X.ActPos~1|Axes.X.ActVelo~2",
    "symbols",
    "log",
    "log?show=traffic",
    "faults",
)
DRIVES = Path(__file__).parents[3] / "examples" / "drives" / "station.toml"
WIDE, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
THEMES: dict[Any, dict[str, str]] = {"light": {}, "dark": {"runOnly": "color-contrast"}}
FIRST_PAGE_BYTES = 300_000

Show = Callable[..., AbstractContextManager[Any]]


@pytest.fixture
def station(web_station: Any) -> Any:
    """The station with pages, for the fixtures that ask for a station."""
    return web_station


@pytest.fixture(scope="module")
def drives(serve_pages: Callable[..., AbstractContextManager[Any]]) -> Iterator[Any]:
    """A station with drives on a bus, and its pages."""
    with serve_pages(str(DRIVES)) as running:
        yield running


@pytest.fixture
def nc(station: Any, pyads_connection: Callable[..., Any]) -> Any:
    """pyads on the station's NC."""
    return pyads_connection(station, 500)


@pytest.fixture
def shown(show: Show, station: Any) -> Iterator[Any]:
    """A tab on the station's pages."""
    with show(station.url) as tab:
        yield tab


def position(nc: Any, axis: str) -> float:
    """What pyads reads."""
    return float(nc.read_by_name(f"Axes.{axis}.ActPos", pyads.PLCTYPE_LREAL))


def start(page: Any, target: str | None, velocity: str) -> None:
    """Fill the form of moves and start."""
    form = page.locator("form").filter(has=page.get_by_role("button", name="Start (F5)"))
    if target is not None:
        form.get_by_label("Position").fill(target)
    form.get_by_label("Velocity").fill(velocity)
    form.get_by_role("button", name="Start (F5)").click()


# every page -----------------------------------------------------------------------------------


def test_every_page_is_accessible(show: Show, station: Any, witness: Callable[[str], None]) -> None:
    """No complaint on the console, no serious finding of axe-core; pictures are kept.

    In the dark theme only colours are others than in the light one.
    """
    witness("axe-core")
    with show(station.url, color_scheme="light", viewport=WIDE) as tab:
        for name in PAGES:
            page = tab.open(name)
            label = name.split("&")[0].translate(str.maketrans("?=", "--"))
            for theme, rules in THEMES.items():
                page.emulate_media(color_scheme=theme)
                assert tab.serious_findings(**rules) == [], f"{name}, {theme}"
                tab.picture(f"{label}-{theme}")
                page.set_viewport_size(PHONE)
                wider = page.evaluate("document.documentElement.scrollWidth - innerWidth")
                assert wider <= 0, f"{name}: wider than a phone"
                tab.picture(f"{label}-{theme}-phone")
                page.set_viewport_size(WIDE)


@pytest.mark.parametrize(
    ("name", "table", "cells"),
    [
        ("axes?axis=1&find=velocity", "Parameters", ["Value", "Unit", "Range", "Meaning"]),
        (
            "scope?traces=Axes.X.ActPos~1|Axes.X.ActVelo~2",
            "Numbers of the traces",
            ["Unit", "Chart"],
        ),
    ],
)
def test_tables_are_cards_on_a_phone(
    show: Show, station: Any, until: Any, name: str, table: str, cells: list[str]
) -> None:
    with show(station.url, viewport=PHONE) as tab:
        page = tab.open(name)
        region = page.locator(f".scroll[aria-label='{table}']")
        region.locator("tbody tr").first.wait_for()
        labels = """each => [...each.querySelectorAll("tbody td")]
            .filter((cell) => cell.checkVisibility())
            .map((cell) => getComputedStyle(cell, "::before").content.replaceAll('"', ""))"""
        until(lambda: set(cells) <= set(region.evaluate(labels)))
        assert not region.locator("thead").is_visible()
        assert region.evaluate("each => each.scrollWidth - each.clientWidth") <= 0
        tab.picture(f"cards-{table.split()[0].lower()}")


def test_the_row_of_pages_shows_the_open_one_on_a_phone(show: Show, station: Any) -> None:
    with show(station.url, viewport=PHONE) as tab:
        for name in ("log", "overview"):
            page = tab.open(name)
            link, row = (page.locator(each).bounding_box() for each in ("[aria-current]", "#nav"))
            assert -1 < link["x"] - row["x"] < row["width"] - link["width"] + 1, name


def test_first_page_is_light_and_requests_from_no_other_host(show: Show, station: Any) -> None:
    with show(station.url, fresh=True) as tab:
        urls: list[str] = []
        tab.page.on("request", lambda request: urls.append(request.url))
        tab.open("overview")
        sizes = tab.page.evaluate(
            "[...performance.getEntriesByType('navigation'),"
            " ...performance.getEntriesByType('resource')].map(each => each.transferSize)"
        )
        assert len(sizes) > 3
        assert sum(sizes) < FIRST_PAGE_BYTES
        assert all(url.startswith(station.url) for url in urls), urls


# axes -----------------------------------------------------------------------------------------


def test_an_axis_is_enabled_moved_and_stopped(shown: Any, nc: Any, until: Any) -> None:
    page = shown.open("axes?axis=1")
    page.get_by_role("button", name="Enable", exact=True).click()
    page.get_by_role("button", name="Disable", exact=True).wait_for()
    start(page, "25", "500")
    until(lambda: position(nc, "X") == pytest.approx(25, abs=1e-3))
    readout = page.locator("output.big")
    until(lambda: float(readout.inner_text()) == pytest.approx(position(nc, "X"), abs=2e-3))

    # without an end, until Stop
    page.get_by_label("Kind of move").select_option("velocity")
    start(page, None, "-50")
    until(lambda: position(nc, "X") < 20)
    page.keyboard.press("F6")
    page.get_by_text("Stop sent to every axis.").wait_for()
    readout_state = page.locator(".readout .lamp-text")
    until(lambda: "motion" not in readout_state.inner_text())
    until(lambda: position(nc, "X") == pytest.approx(position(nc, "X"), abs=1e-6))
    page.get_by_role("button", name="Disable", exact=True).click()
    page.get_by_role("button", name="Enable", exact=True).wait_for()


def test_an_axis_jogs_while_the_button_is_held(shown: Any, nc: Any, until: Any) -> None:
    page = shown.open("axes?axis=2")
    page.get_by_role("button", name="Enable", exact=True).click()
    page.get_by_role("button", name="Disable", exact=True).wait_for()
    before = position(nc, "Y")
    button = page.get_by_role("button", name="Jog forward")
    button.hover()
    page.mouse.down()
    until(lambda: position(nc, "Y") > before + 1)
    page.mouse.up()
    state = page.locator(".readout .lamp-text")
    until(lambda: state.inner_text() == "standstill")
    page.keyboard.down("F2")
    until(lambda: "motion" in state.inner_text())
    page.keyboard.up("F2")
    until(lambda: state.inner_text() == "standstill")
    page.get_by_role("button", name="Disable", exact=True).click()


def test_a_refusal_is_shown_with_its_code(shown: Any) -> None:
    page = shown.open("axes?axis=3")
    start(page, "10", "10")
    notice = page.get_by_role("alert").locator(".notice")
    notice.wait_for()
    assert "0x" in notice.inner_text()
    page.get_by_role("button", name="Close this message").click()
    notice.wait_for(state="detached")


def test_a_parameter_is_changed_within_its_range(shown: Any, nc: Any, until: Any) -> None:
    page = shown.open("axes?axis=2")
    page.get_by_label("Search parameters").fill("jog_velocity_fast")
    until(lambda: "find=jog_velocity_fast" in page.evaluate("location.hash"))
    value = page.get_by_role("button", name="jog_velocity_fast: ")
    value.click()
    page.get_by_label("New value of").fill("123.5")
    page.get_by_role("button", name="Write").click()
    until(lambda: "123.5" in value.inner_text())
    # 0x4000 + axis: 0x9 is the velocity of fast jogs
    assert nc.read(0x4000 + 2, 0x9, pyads.PLCTYPE_LREAL) == 123.5


ENTERING = """() => {
    const rows = document.querySelector("[role=tabpanel] tbody");
    globalThis.entered = 0;
    new MutationObserver((changes) => {
        for (const { addedNodes } of changes) globalThis.entered += addedNodes.length;
    }).observe(rows, { childList: true });
}"""


def test_a_row_that_is_edited_stays_where_it_is_while_others_go(shown: Any, until: Any) -> None:
    """A row that is taken out and put back loses what is typed or pressed at that moment."""
    page = shown.open("axes?axis=2")
    page.get_by_label("Search parameters").fill("velocity")
    until(lambda: "find=velocity" in page.evaluate("location.hash"))
    page.get_by_role("button", name="jog_velocity_fast: ").click()
    page.get_by_label("New value of").fill("77")
    page.evaluate(ENTERING)
    page.get_by_label("Search parameters").fill("jog_velocity_fast")
    until(lambda: "find=jog_velocity_fast" in page.evaluate("location.hash"))
    assert page.evaluate("globalThis.entered") == 0
    assert page.get_by_label("New value of").input_value() == "77"


# symbols --------------------------------------------------------------------------------------


def test_a_symbol_is_found_watched_and_written(shown: Any, plc: Any, until: Any) -> None:
    page = shown.open("symbols")
    page.keyboard.press("/")
    page.keyboard.type("GVL.nDint")
    tree = page.get_by_role("tree")
    item = tree.get_by_role("treeitem").first
    until(lambda: "GVL.nDint" in (item.text_content() or ""))
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    value = page.get_by_role("button", name="GVL.nDint: ")
    value.click()
    page.get_by_label("New value of GVL.nDint").fill("-4711")
    page.get_by_role("button", name="Write").click()
    until(lambda: plc.read_by_name("GVL.nDint", pyads.PLCTYPE_DINT) == -4711)
    plc.write_by_name("GVL.nDint", 1234, pyads.PLCTYPE_DINT)
    until(lambda: value.inner_text() == "1234")
    # the address shows the same to a colleague
    assert "GVL.nDint" in page.url
    page.reload()
    until(lambda: value.is_visible() and value.inner_text() == "1234")


def test_enter_in_the_search_watches_the_first_match(shown: Any) -> None:
    page = shown.open("symbols")
    page.keyboard.press("/")
    # Enter at once: the rows that are shown are still those from before
    page.keyboard.type("actpos")
    page.keyboard.press("Enter")
    page.get_by_role("row", name="500:Axes.").wait_for()
    assert "watch=500:Axes." in unquote(page.url)
    names = page.get_by_role("tree").locator(".name").all_inner_texts()
    assert {"500:Axes.X.ActPos", "500:Axes.Y.ActPos"} <= set(names[:6])
    page.keyboard.type("no such symbol")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Show all symbols").wait_for()
    assert page.get_by_role("row", name="500:Axes.").count() == 1


def test_empty_lists_lead_on(shown: Any, until: Any) -> None:
    """A search without a match offers the way back, an empty page the way to its content."""
    for name, button, rows in (
        ("axes?search=nope&only=error", "Show all axes", "#page tbody tr"),
        ("symbols?search=no such symbol", "Show all symbols", "[role=treeitem]"),
    ):
        page = shown.open(name)
        page.get_by_role("button", name=button).click()
        until(lambda page=page, rows=rows: page.locator(rows).count() >= 3)
        assert not re.search("(search|only)=", page.url)
        assert page.evaluate("document.activeElement.type") == "search"
    page = shown.open("overview")
    page.get_by_role("link", name="Set one").click()
    page.get_by_role("heading", name="Set a fault").wait_for()
    page.goto(f"{shown.url}#nope")
    page.get_by_role("link", name="Go to the first page").click()
    page.get_by_role("heading", name="Station").wait_for()


def test_a_wrong_value_is_refused_and_kept_for_mending(shown: Any, plc: Any) -> None:
    before = plc.read_by_name("GVL.nSint", pyads.PLCTYPE_SINT)
    page = shown.open("symbols?watch=GVL.nSint")
    page.get_by_role("button", name="GVL.nSint: ").click()
    entry = page.get_by_label("New value of GVL.nSint")
    entry.fill("300")
    page.get_by_role("button", name="Write").click()
    page.get_by_role("alert").locator(".notice").wait_for()
    assert entry.input_value() == "300"
    assert plc.read_by_name("GVL.nSint", pyads.PLCTYPE_SINT) == before


def test_the_tree_goes_by_keys(shown: Any, until: Any) -> None:
    page = shown.open("symbols")
    gvl = page.get_by_role("treeitem", name="GVL").first
    gvl.focus()
    page.keyboard.press("ArrowRight")
    until(lambda: page.locator("[role=group] > [role=treeitem]").count() > 20)
    page.keyboard.press("ArrowRight")
    assert page.evaluate("document.activeElement.getAttribute('aria-level')") == "2"
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    assert gvl.get_attribute("aria-expanded") == "false"


def test_strings_of_a_plc_are_text(shown: Any, plc: Any, until: Any) -> None:
    evil = "<img src=x onerror=document.title=1>"
    plc.write_by_name("GVL.sString", evil, pyads.PLCTYPE_STRING)
    page = shown.open("symbols?watch=GVL.sString")
    value = page.get_by_role("button", name="GVL.sString: ")
    until(lambda: evil in value.inner_text())
    assert page.locator("main img").count() == 0
    assert page.title() != "1"


# faults, log, traffic -------------------------------------------------------------------------


def test_a_fault_is_set_and_cleared(shown: Any, plc: Any, until: Any) -> None:
    page = shown.open("faults?kind=error")
    kind = page.get_by_label("Kind of fault")
    until(lambda: kind.input_value() == "error")
    assert page.locator(".field").filter(has_text="lasting").inner_text().split() == [
        "lasting", "s",
    ]  # fmt: skip
    page.get_by_label("code").fill("0x710")
    page.get_by_label("port").fill("851")
    page.get_by_label("command").fill("read_write")
    page.get_by_role("button", name="Set the fault").click()
    row = page.get_by_role("button", name="Clear fault")
    row.wait_for()
    with pytest.raises(pyads.ADSError) as refusal:
        plc.read_by_name("MAIN.nCounter", pyads.PLCTYPE_UDINT)
    assert refusal.value.err_code == 0x710
    row.click()
    page.get_by_text("No fault is set. Choose a kind below").wait_for()
    assert plc.read_by_name("MAIN.nCounter", pyads.PLCTYPE_UDINT) > 0


def test_the_log_has_the_lines_of_the_level_that_is_chosen(shown: Any, until: Any) -> None:
    page = shown.open("log")
    lines = page.get_by_role("log").locator("li")
    # the page itself comes as a client: the station says so at level info
    until(lambda: lines.filter(has_text="info").count() > 0)
    level = page.get_by_label("from level")
    assert level.locator("option").all_inner_texts() == ["info", "warning", "error"]
    level.select_option("error")
    until(lambda: lines.count() == 0)
    page.get_by_role("button", name="Show all lines").click()
    until(lambda: lines.count() > 0)


def test_traffic_is_seen(shown: Any, plc: Any, until: Any) -> None:
    page = shown.open("log?show=traffic")
    page.get_by_label("Filter lines").fill("nDword")
    lines = page.get_by_role("log").locator("li")

    def seen() -> bool:
        plc.read_by_name("GVL.nDword", pyads.PLCTYPE_DWORD)
        return bool(lines.count())

    until(seen)
    assert "nDword" in lines.first.inner_text()


# drives and bus --------------------------------------------------------------------------------


def test_drives_and_their_bus_are_seen(show: Show, drives: Any, until: Any) -> None:
    with show(drives.url, viewport=WIDE) as tab:
        page = tab.open("drives")
        row = page.get_by_role("row").filter(has_text="Drive 1")
        until(lambda: "csp" in row.first.inner_text())
        active = page.locator("svg .active")
        page.wait_for_function("() => document.querySelectorAll('svg .active').length === 1")
        before = active.text_content()
        tab.open("axes?axis=1").get_by_role("button", name="Enable", exact=True).click()
        page.get_by_role("button", name="Disable", exact=True).wait_for()
        tab.open("drives")
        until(lambda: active.text_content() == "operation enabled")
        assert before != "operation enabled"
        assert re.search(r"-?\d+\.\d{3} mm\s+-?\d+\.\d{3} mm/s", row.first.inner_text())
        page.get_by_label("Search objects").fill("6041")
        page.get_by_role("row").filter(has_text="6041:00").wait_for()
        assert page.get_by_role("row").filter(has_text="1004").count() >= 1
        tab.picture("drives-light")


def test_an_object_of_a_drive_is_written_and_set_back(show: Show, drives: Any, until: Any) -> None:
    with show(drives.url, viewport=WIDE) as tab:
        page = tab.open("drives?search=6065:00")
        value = page.get_by_role("button", name="Following error window: ")
        value.wait_for()
        before = value.inner_text()
        value.click()
        entry = page.get_by_label("New value of Following error window")
        entry.fill("-5")
        page.get_by_role("button", name="Write").click()
        page.get_by_text("expected 0 …").or_(page.get_by_text("expected ≥ 0")).or_(
            page.get_by_text(re.compile("expected 0"))
        ).first.wait_for()
        entry.fill("4711")
        page.get_by_role("button", name="Write").click()
        until(lambda: value.inner_text() == "4711")
        page.get_by_role("button", name=f"Undo: Following error window = {before}").click()
        until(lambda: value.inner_text() == before)


# keys -----------------------------------------------------------------------------------------


def test_everything_is_reached_by_keys(shown: Any, until: Any) -> None:
    page = shown.open("overview")
    until(page.locator("#stop").is_enabled)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "stop"
    page.keyboard.press("?")
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="hidden")
    page.keyboard.press("2")
    until(lambda: page.locator("h1").inner_text() == "Axes")
    assert json.loads(page.evaluate("JSON.stringify(document.title)")).startswith("Axes")


def test_the_theme_is_chosen_and_kept(shown: Any) -> None:
    page = shown.open("overview")
    button = page.get_by_role("button", name="Theme")
    button.click()
    button.click()
    ground = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(ground)
    page.reload()
    assert page.evaluate(ground) == dark
    button.click()
    assert page.evaluate(ground) != dark
