"""Smoothing: where the curves are, and how smooth they end."""

from math import dist, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.path.geometry import point_at
from achse.motion.path.record import ElementKind, element_record, state_record
from achse.motion.path.smoothing import (
    Smoothing,
    SmoothingSubtype,
    round_corner,
    smoothing_radius,
)

APEX = {
    Smoothing.BEZIER: 0.353553391,
    Smoothing.PARABOLA: 0.353553391,
    Smoothing.CUBIC: 0.353553391,
    Smoothing.BIQUADRATIC: 0.265165043,
    Smoothing.QUINTIC: 0.265165043,
}


@pytest.mark.parametrize("kind", APEX)
def test_the_apex_of_a_right_corner(kind: Smoothing) -> None:
    state, before, curve, after = (
        state_record(),
        element_record(),
        element_record(),
        element_record(),
    )
    state.smoothing, state.smoothing_subtype, state.smoothing_radius = int(kind), 1, 1.0
    for element, direction in ((before, 0), (after, 1)):
        element.kind, element.length, element.whole = int(ElementKind.LINE), 10.0, 10.0
        element.slope[direction] = 1.0
    after.begin[0] = before.end[0] = 10.0
    assert round_corner(before, curve, after, state, 10.0) == 1.0
    point_at(curve, 0.5 * curve.length, state.point)
    assert dist(state.point.position[:2], (10.0, 0.0)) == pytest.approx(APEX[kind], abs=1e-9)
    for way, tangent in ((0.0, (1.0, 0.0)), (curve.length, (0.0, 1.0))):
        point_at(curve, way, state.point)
        assert state.point.tangent[:2] == pytest.approx(tangent, abs=1e-12)
        if kind in (Smoothing.BIQUADRATIC, Smoothing.QUINTIC):
            assert state.point.bend[:2] == pytest.approx((0.0, 0.0), abs=1e-9)


@given(st.sampled_from(list(APEX)), st.floats(0.001, 100.0), st.floats(0.1, 3.0))
def test_distance_is_kept(kind: Smoothing, distance: float, angle: float) -> None:
    radius = smoothing_radius(kind, SmoothingSubtype.DISTANCE, distance, angle, 1e9, 1e9)
    if kind == Smoothing.BEZIER:
        assert radius == distance
    else:
        apex = 0.25 if kind in (Smoothing.PARABOLA, Smoothing.CUBIC) else 0.1875
        from math import sin

        assert apex * radius * 2 * sin(angle / 2) == pytest.approx(distance)


def test_a_curve_takes_at_most_its_share() -> None:
    radius = smoothing_radius
    assert radius(Smoothing.PARABOLA, 1, 9.0, pi / 2, 6.0, 12.0) == pytest.approx(2.0)
    assert radius(Smoothing.QUINTIC, 1, 9.0, pi / 2, 6.0, 12.0) == 3.0
    assert radius(Smoothing.QUINTIC, 3, 2.0, pi / 2, 6.0, 12.0) == 2.0
