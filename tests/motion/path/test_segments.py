"""Arcs and helices by centre, by radius and through three points."""

from itertools import pairwise
from math import cos, dist, pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.path.segments import (
    PLANE_XY,
    PLANE_YZ,
    PLANE_ZX,
    ArcGeometry,
    PathError,
    arc_through,
    plane_arc,
    rapid_feed,
)


def test_the_examples_of_the_facts() -> None:
    half = plane_arc((0, 0, 0), (10, 0, 0), clockwise=True, centre=(5, 0))
    assert half.length == pytest.approx(15.707963268, abs=1e-9)
    short = plane_arc((0, 0, 0), (10, 0, 0), clockwise=True, radius=10)
    assert short.centre == pytest.approx((5, -8.660254038, 0), abs=1e-9)
    assert short.length == pytest.approx(10.471975512, abs=1e-9)
    long = plane_arc((0, 0, 0), (10, 0, 0), clockwise=True, radius=-10)
    assert long.centre == pytest.approx((5, 8.660254038, 0), abs=1e-9)
    assert long.length == pytest.approx(52.359877560, abs=1e-9)
    helix = plane_arc((0, 0, 0), (10, 0, 5), clockwise=True, centre=(5, 0))
    assert helix.length == pytest.approx(16.484541547, abs=1e-9)


@given(
    st.sampled_from([PLANE_XY, PLANE_YZ, PLANE_ZX]),
    st.booleans(),
    st.floats(0.01, 1e3),
    st.floats(-180, 180),
    st.floats(1, 359),
    st.floats(-50, 50),
    st.integers(0, 3),
)
def test_arcs_end_where_they_shall(plane, clockwise, radius, begin, angle, rise, turns) -> None:  # type: ignore[no-untyped-def]
    centre = (3.0, -7.0)
    sign = -1 if clockwise else 1
    points = []
    for place in (radians(begin), radians(begin) + sign * radians(angle)):
        point = [1.0] * 3
        point[plane.first] = centre[0] + radius * cos(place)
        point[plane.second] = centre[1] + radius * sin(place)
        points.append(point)
    points[1][plane.normal] += rise
    arc = plane_arc(*points, plane=plane, clockwise=clockwise, centre=centre, turns=turns)
    assert arc.start == pytest.approx(points[0], abs=1e-9)
    assert arc.end == pytest.approx(points[1], abs=1e-9)
    assert arc.angle == pytest.approx(radians(angle) + 2 * pi * turns, abs=1e-8)
    assert arc.radius == pytest.approx(radius, abs=1e-9)


def test_a_full_circle_ends_where_it_begins() -> None:
    arc = plane_arc((10, 0, 0), (10, 0, 0), clockwise=False, centre=(0, 0))
    assert arc.angle == 2 * pi
    assert dist(arc.start, arc.end) < 1e-9


def test_an_arc_in_space_goes_through_three_points() -> None:
    start, middle, end = (1.0, 2.0, 3.0), (4.0, -1.0, 5.0), (0.0, 7.0, -2.0)
    arc = arc_through(start, middle, end)
    assert arc.start == pytest.approx(start, abs=1e-12)
    assert arc.end == pytest.approx(end, abs=1e-12)
    assert dist(arc.centre, middle) == pytest.approx(arc.radius)


@pytest.mark.parametrize(
    ("end", "values"),
    [
        ((10, 0, 0), {"radius": 4.9}),
        ((0, 0, 0), {"radius": 5.0}),
        ((10, 0, 0), {"centre": (4, 0)}),
        ((10, 0, 0), {}),
        ((10, 0, 0), {"radius": 5.0, "centre": (5, 0)}),
        ((float("nan"), 0, 0), {"radius": 5.0}),
    ],
)
def test_arcs_that_cannot_be_are_refused(end: tuple[float, ...], values: dict[str, float]) -> None:
    with pytest.raises(PathError):
        plane_arc((0, 0, 0), end, clockwise=True, **values)  # type: ignore[arg-type]


def test_points_in_a_line_are_refused() -> None:
    with pytest.raises(PathError):
        arc_through((0, 0, 0), (1, 1, 1), (2, 2, 2))


def test_a_centre_that_is_a_little_off_is_corrected() -> None:
    arc = plane_arc((0, 0, 0), (10, 0, 0), clockwise=True, centre=(5.01, 0))
    assert arc.centre == pytest.approx((5, 0, 0))
    with pytest.raises(PathError):
        plane_arc((0, 0, 0), (10, 0, 0), clockwise=True, centre=(5.01, 0), correct_centre=False)


@given(st.floats(0.1, 9.0), st.floats(-5.0, 5.0), st.integers(1, 20))
def test_parts_of_an_arc_are_the_arc(angle: float, rise: float, count: int) -> None:
    whole = ArcGeometry((1.0, 2.0, 3.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0), angle, (0.0, 0.0, rise))
    parts = [whole.part(n, count) for n in range(count)]
    assert parts[0].start == pytest.approx(whole.start)
    assert parts[-1].end == pytest.approx(whole.end)
    assert sum(part.length for part in parts) == pytest.approx(whole.length)
    for before, after in pairwise(parts):
        assert before.end == pytest.approx(after.start)


def test_rapid_feed_is_that_of_the_first_axis_at_its_velocity() -> None:
    begin, end = (0.0, 0.0, 0.0, 5.0), (300.0, 400.0, 0.0, 5.0)
    assert rapid_feed(begin, end, (200.0, 200.0, 200.0, 1.0)) == pytest.approx(250.0)
    assert rapid_feed(begin, end, (90.0, None, None)) == pytest.approx(150.0)
    assert rapid_feed(begin, (0.0, 0.0, 0.0, 9.0), (9.0, 9.0, 9.0, 2.0)) == 2.0
    assert rapid_feed(begin, begin, (9.0, 9.0, 9.0, 2.0)) == 1.0
