"""Curves against the points they are made of, and splines against their definition and SciPy."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from achse.motion.control.curves import CurveSpan, Points, linear, span_at, spline, value_at

Join = Callable[[Points], list[CurveSpan]]

POINTS = [(-1.0, -0.6), (-0.2, -0.3), (0.0, 0.0), (0.3, 0.5), (1.0, 1.0)]


@st.composite
def points(draw: st.DrawFn) -> list[tuple[float, float]]:
    steps = draw(st.lists(st.floats(0.01, 10.0), min_size=2, max_size=12))
    places = [sum(steps[:n]) - 20.0 for n in range(len(steps) + 1)]
    values = st.lists(st.floats(-10.0, 10.0), min_size=len(places), max_size=len(places))
    return list(zip(places, draw(values), strict=True))


@pytest.mark.parametrize("join", [linear, spline])
def test_a_curve_goes_through_its_points_and_stays_at_the_outermost(join: Join) -> None:
    spans = join(POINTS)
    for place, value in POINTS:
        assert value_at(spans, 0, len(spans), place) == pytest.approx(value, abs=1e-12)
    assert value_at(spans, 0, len(spans), -7.0) == -0.6
    assert value_at(spans, 0, len(spans), 7.0) == 1.0


def test_between_points_lines_are_straight() -> None:
    spans = linear(POINTS)
    for place, value in ((-0.6, -0.45), (-0.1, -0.15), (0.15, 0.25), (0.65, 0.75)):
        assert value_at(spans, 0, len(spans), place) == pytest.approx(value)


@given(points())
def test_a_spline_is_the_natural_cubic_one(points: list[tuple[float, float]]) -> None:
    spans = spline(points)
    places, values = zip(*points, strict=True)
    oracle = CubicSpline(places, values, bc_type="natural")
    for before, after in pairwise(places):
        for part in (0.1, 0.5, 0.9):
            place = before + part * (after - before)
            assert value_at(spans, 0, len(spans), place) == pytest.approx(
                float(oracle(place)), rel=1e-6, abs=1e-6
            )


@given(points(), st.floats(-30.0, 130.0))
def test_the_span_is_the_last_that_has_begun(
    points: list[tuple[float, float]], place: float
) -> None:
    others, spans = linear(POINTS), linear(points)
    index = span_at([*others, *spans], len(others), len(spans), place) - len(others)
    begun = [n for n, span in enumerate(spans) if span.begin <= place]
    assert index == (begun[-1] if begun else 0)
