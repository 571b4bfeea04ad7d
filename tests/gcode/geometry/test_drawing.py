"""Pictures of a path: valid SVG, everything inside, rapid moves dashed, velocity as colour."""

from itertools import pairwise
from xml.etree import ElementTree

import pytest

from achse.gcode.geometry.drawing import VIEWS, WIDTH, PathSample, draw_moves, draw_velocities
from tests.gcode.programs import moves

SVG = "{http://www.w3.org/2000/svg}"
PART = "G0 X10 Z5\nG1 X40 F600\nG3 X50 Y10 I0 J10\nG18 G2 X60 Z15 I10 K0\nG0 X0 Y0 Z0"


def lines(picture: str) -> list[ElementTree.Element]:
    return ElementTree.fromstring(picture).findall(f"{SVG}polyline")


def points(line: ElementTree.Element) -> list[tuple[float, float]]:
    return [
        (float(x), float(y)) for x, y in (pair.split(",") for pair in line.attrib["points"].split())
    ]


@pytest.mark.parametrize("view", VIEWS)
def test_every_view_is_inside_of_its_sheet(view: str) -> None:
    picture = draw_moves(moves(PART), view=view, title="<part> & co")
    root = ElementTree.fromstring(picture)
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    assert max(width, height) <= WIDTH + 1
    drawn = [point for line in lines(picture) for point in points(line)]
    assert all(0 <= x <= width and 0 <= y <= height for x, y in drawn)
    assert root.findtext(f"{SVG}g/{SVG}text", "").startswith("<part> & co")


def test_rapid_moves_are_dashed_and_feed_is_one_line() -> None:
    first, middle, last = lines(draw_moves(moves(PART)))
    assert "stroke-dasharray" in first.attrib
    assert "stroke-dasharray" not in middle.attrib
    assert "stroke-dasharray" in last.attrib
    assert len(points(middle)) > 30


def test_an_arc_is_round() -> None:
    (line,) = lines(draw_moves(moves("G2 X20 Y0 I10 J0 F600")))
    xs, ys = zip(*points(line), strict=True)
    scale = (max(xs) - min(xs)) / 20.0
    assert (max(ys) - min(ys)) / scale == pytest.approx(10.0, abs=0.05)


def test_velocity_is_colour() -> None:
    samples = [PathSample((float(n), 0.0, 0.0), float(n)) for n in range(101)]
    result = lines(draw_velocities(samples, title="ramp"))
    assert len(result) == 24
    assert [result[at].attrib["stroke"] for at in (0, -1)] == ["#1111d4", "#d41111"]
    ends = [points(line) for line in result]
    assert all(a[-1] == b[0] for a, b in pairwise(ends))


@pytest.mark.parametrize(("size", "bar"), [(0.3, "0.05 mm"), (10.0, "1 mm"), (7000.0, "1000 mm")])
def test_a_length_to_compare_with_and_the_size(size: float, bar: str) -> None:
    picture = draw_moves(moves(f"G1 X{size} Y{size / 2} F600"), title="a.nc")
    assert f">{bar}</text>" in picture
    assert f"a.nc: X 0 … {size:g}, Y 0 … {size / 2:g} mm" in picture


def test_nothing_to_draw() -> None:
    assert lines(draw_moves([])) == []
    assert lines(draw_velocities([])) == []
    assert lines(draw_velocities([PathSample((1.0, 2.0, 3.0), 0.0)])) == []
