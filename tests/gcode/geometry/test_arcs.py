"""Circles: closed forms, and that turning the start always gives the end."""

from math import hypot, isclose, pi, sqrt

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.geometry.arcs import centre_of_radius, circle_in_space, corrected_centre, swept
from achse.gcode.vectors import cross, dot, turned

COORDINATES = st.floats(-1000.0, 1000.0).map(lambda value: round(value, 4))
POINTS = st.tuples(COORDINATES, COORDINATES)


def test_a_radius_gives_the_short_way_and_a_negative_one_the_long_way() -> None:
    """Figures of the facts: B10 and B-10 from (0, 0) to (10, 0)."""
    short = centre_of_radius((0.0, 0.0), (10.0, 0.0), 10.0, clockwise=True)
    long = centre_of_radius((0.0, 0.0), (10.0, 0.0), -10.0, clockwise=True)
    assert short == pytest.approx((5.0, -8.660254038))
    assert long == pytest.approx((5.0, 8.660254038))
    assert swept((0.0, 0.0), (10.0, 0.0), short, True) == pytest.approx(pi / 3.0)
    assert swept((0.0, 0.0), (10.0, 0.0), long, True) == pytest.approx(5.0 * pi / 3.0)


@given(POINTS, POINTS, st.floats(0.5, 20.0), st.booleans(), st.booleans())
def test_a_centre_of_a_radius_is_that_far_from_both_ends(
    start: tuple[float, float],
    end: tuple[float, float],
    factor: float,
    clockwise: bool,
    long: bool,
) -> None:
    chord = hypot(end[0] - start[0], end[1] - start[1])
    assume(chord > 1e-3)
    radius = chord * factor * (-1.0 if long else 1.0)
    centre = centre_of_radius(start, end, radius, clockwise)
    for point in (start, end):
        far = hypot(point[0] - centre[0], point[1] - centre[1])
        assert isclose(far, abs(radius), rel_tol=1e-9, abs_tol=1e-9)
    if factor > 0.5001:
        assert (swept(start, end, centre, clockwise) > pi) is long


def test_a_radius_that_is_too_small_or_a_full_circle_is_refused() -> None:
    with pytest.raises(WordRefused) as small:
        centre_of_radius((0.0, 0.0), (10.0, 0.0), 4.0, clockwise=True)
    with pytest.raises(WordRefused) as full:
        centre_of_radius((1.0, 1.0), (1.0, 1.0), 4.0, clockwise=True)
    assert small.value.code is full.value.code is NcError.CIRCLE_NOT_COMPUTABLE


def test_equal_ends_make_a_full_circle() -> None:
    assert swept((1.0, 0.0), (1.0, 0.0), (0.0, 0.0), clockwise=False) == 2.0 * pi


def test_a_wrong_centre_moves_to_the_middle_between_the_ends() -> None:
    assert corrected_centre((0.0, 0.0), (10.0, 0.0), (6.0, 1.0), correct=True) == (5.0, 1.0)
    with pytest.raises(WordRefused, match="CPCOF"):
        corrected_centre((0.0, 0.0), (10.0, 0.0), (6.0, 1.0), correct=False)
    with pytest.raises(WordRefused, match="radius 0"):
        corrected_centre((0.0, 0.0), (10.0, 0.0), (0.0, 0.0), correct=True)


@given(*(st.tuples(COORDINATES, COORDINATES, COORDINATES) for _ in range(3)))
def test_a_circle_in_space_goes_through_its_three_points(
    start: tuple[float, float, float],
    middle: tuple[float, float, float],
    end: tuple[float, float, float],
) -> None:
    a = tuple(x - y for x, y in zip(middle, start, strict=True))
    b = tuple(x - y for x, y in zip(end, start, strict=True))
    first, second = (a[0], a[1], a[2]), (b[0], b[1], b[2])
    area = hypot(*cross(first, second))
    assume(area > 0.05 * hypot(*a) * hypot(*b) > 1.0)
    centre, normal, angle = circle_in_space(start, middle, end)
    radius = hypot(*(x - y for x, y in zip(start, centre, strict=True)))
    assume(radius < 1e4)
    assert isclose(hypot(*normal), 1.0)
    assert turned(start, centre, normal, angle, 0.0) == pytest.approx(end, abs=1e-6)
    on_way = tuple(x - y for x, y in zip(middle, centre, strict=True))
    arm = tuple(x - y for x, y in zip(start, centre, strict=True))
    u, v = (on_way[0], on_way[1], on_way[2]), (arm[0], arm[1], arm[2])
    assert isclose(hypot(*u), radius, rel_tol=1e-6)
    assert abs(dot(u, normal)) < 1e-6 * radius + 1e-6
    assert dot(v, normal) == pytest.approx(0.0, abs=1e-6 * radius + 1e-6)


def test_three_points_on_a_line_are_no_circle() -> None:
    with pytest.raises(WordRefused, match="on one line"):
        circle_in_space((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (2.0, 2.0, 2.0))


def test_a_point_turns_right_handed_and_rises() -> None:
    quarter = turned((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), pi / 2.0, 3.0)
    assert quarter == pytest.approx((0.0, 1.0, 3.0))
    n = 1.0 / sqrt(3.0)
    third = turned((1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (n, n, n), 2.0 * pi / 3.0, 0.0)
    assert third == pytest.approx((0.0, 1.0, 0.0))
