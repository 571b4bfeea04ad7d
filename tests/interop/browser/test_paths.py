"""Cams and paths in a real browser: curves, a part program with its tool moving."""

import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

WIDE, PHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}

STATION = """
name = "mill"
[[axis]]
id = 1
name = "X"
[[axis]]
id = 2
name = "Y"
[[axis]]
id = 3
name = "Z"
[[table]]
id = 7
name = "press"
kind = "cam"
points = [[0, 0], [90, 20], [180, 60], [270, 20], [360, 0]]
[[channel]]
id = 1
name = "Mill"
programs = "."
[[group]]
id = 11
channel = 1
axes = [1, 2, 3]
"""
PROGRAM = (
    "N10 G0 X5 Y5 Z5\nN20 G1 Z1 F6000\nN30 G1 X25\nN40 G3 X30 Y10 I0 J5\nN50 G1 Y30 F600\nM30\n"
)

PAINTED = """canvas => {
  const copy = Object.assign(document.createElement('canvas'),
    {width: canvas.width, height: canvas.height}).getContext('2d', {willReadFrequently: true});
  copy.drawImage(canvas, 0, 0);
  const {data} = copy.getImageData(0, 0, canvas.width, canvas.height);
  let painted = 0;
  for (let n = 3; n < data.length; n += 4) painted += data[n] > 0;
  return painted;
}"""
"""How many pixels of a canvas have a colour."""

Show = Callable[..., AbstractContextManager[Any]]


@pytest.fixture(scope="module")
def mill(
    serve_pages: Callable[..., AbstractContextManager[Any]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Any]:
    """A station with a cam table and a channel, and its pages."""
    folder = tmp_path_factory.mktemp("mill")
    (folder / "mill.toml").write_text(STATION, encoding="utf-8")
    (folder / "plate.nc").write_text(PROGRAM, encoding="utf-8")
    with serve_pages(str(folder / "mill.toml")) as running:
        yield running


def check(tab: Any, name: str) -> None:
    """axe-core finds nothing serious in both themes; a phone is wide enough; pictures are kept."""
    for theme in ("light", "dark"):
        tab.page.emulate_media(color_scheme=theme)
        assert tab.serious_findings() == [], theme
        tab.page.evaluate("scrollTo(0, 0)")
        tab.picture(f"{name}-{theme}")
    tab.page.set_viewport_size(PHONE)
    assert tab.page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    tab.picture(f"{name}-phone")


def test_a_cam_is_three_curves_and_a_table(
    show: Show, mill: Any, until: Any, witness: Callable[[str], None]
) -> None:
    witness("axe-core")
    with show(mill.url, viewport=WIDE) as tab:
        page = tab.open("paths?table=7")
        page.get_by_text("Table 7, 500 points").wait_for()
        curves = page.locator("canvas.curve")
        assert curves.count() == 3
        for n in range(3):
            until(lambda n=n: curves.nth(n).evaluate(PAINTED) > 500)
        rows = page.get_by_role("region", name="Values of the cam table").locator("tbody tr")
        assert rows.count() == 73
        assert rows.first.locator("th").inner_text() == "0.000"
        assert rows.last.locator("th").inner_text() == "360.000"
        curves.first.focus()
        for _ in range(50):
            page.keyboard.press("ArrowRight")
        until(lambda: "master 180." in page.locator("output").first.inner_text())
        assert "position 59.8397" in page.locator("output").first.inner_text()
        check(tab, "paths")


def test_a_part_program_is_started_and_its_way_drawn(show: Show, mill: Any, until: Any) -> None:
    with show(mill.url, viewport=WIDE) as tab:
        page = tab.open("axes")
        for axis in "XYZ":
            button = page.get_by_role("button", name=re.compile(f"(En|Dis)able {axis}"))
            if button.inner_text() == "Enable":
                button.click()
            page.get_by_role("button", name=f"Disable {axis}").wait_for()
        tab.open("paths?view=XY")
        page.get_by_label("Program to load").fill("plate.nc")
        page.get_by_role("button", name="Load").click()
        facts = page.locator("dl.facts")
        until(lambda: "ready" in facts.inner_text())
        picture = page.get_by_role("img", name="Path of Mill")
        # what it will take, before anything moves
        until(lambda: re.search(r"\d+\.\d mm", facts.inner_text()))
        assert "30.000" not in facts.inner_text()
        tab.picture("paths-planned")
        seen = picture.evaluate("canvas => canvas.toDataURL()")
        page.get_by_role("button", name="Start").click()
        until(lambda: re.search(r"\d+\.\d of \d+\.\d mm", facts.inner_text()))
        until(lambda: "30.000" in facts.inner_text())
        until(lambda: picture.evaluate("canvas => canvas.toDataURL()") != seen)
        picture.focus()
        seen = picture.evaluate("canvas => canvas.toDataURL()")
        page.keyboard.press("ArrowLeft")
        until(lambda: picture.evaluate("canvas => canvas.toDataURL()") != seen)
        tab.picture("paths-driven")


def test_a_machine_is_drawn_and_moves(
    show: Show, portal: Any, until: Any, witness: Callable[[str], None]
) -> None:
    witness("axe-core")
    with show(portal.url, viewport=WIDE) as tab:
        page = tab.open("scene")
        picture = page.get_by_role("img", name="The machine")
        picture.wait_for()
        until(lambda: picture.evaluate(PAINTED) > 2000)
        until(lambda: page.locator("dl.facts dt").count() == len("XYZ") + 1)  # and the clamp
        still = picture.evaluate("canvas => canvas.toDataURL()")
        tab.open("axes?axis=1")
        page.get_by_role("button", name="Enable", exact=True).click()
        page.get_by_role("button", name="Disable", exact=True).wait_for()
        form = page.locator("form").filter(has=page.get_by_role("button", name="Start (F5)"))
        form.get_by_label("Position").fill("50")
        form.get_by_label("Velocity").fill("500")
        form.get_by_role("button", name="Start (F5)").click()
        tab.open("scene")
        until(lambda: "50.000" in page.locator("dl.facts").inner_text())
        until(lambda: picture.evaluate("canvas => canvas.toDataURL()") != still)
        check(tab, "scene")
