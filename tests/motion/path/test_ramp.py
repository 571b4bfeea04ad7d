"""Ramps: they end where they shall, on the way that `stretch` says, within their limits."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.path.ramp import ramp_after, ramp_duration, reachable, rest_is_nearer, stretch

VELOCITY = st.floats(0.0, 1e3)
LIMIT = st.floats(1.0, 1e5)


@given(VELOCITY, st.floats(-1e4, 1e4), VELOCITY, LIMIT, LIMIT, st.floats(1.0, 1e7))
def test_a_ramp_ends_at_its_velocity_with_no_acceleration(  # type: ignore[no-untyped-def]
    v, a, w, up, down, jerk
) -> None:
    time = ramp_duration(v, a, w, up, down, jerk)
    _, v1, a1 = ramp_after(v, a, w, up, down, jerk, time * (1 - 1e-12))
    # a1 is within what a last moment takes away
    assert v1 == pytest.approx(w, abs=1e-5 * max(1.0, v, abs(a)))
    assert abs(a1) <= 1e-5 * max(abs(a), up, down, 1.0) + 1e-9 * time * jerk
    assert ramp_after(v, a, w, up, down, jerk, time * 1.001 + 1e-12)[1:] == (w, 0.0)


@given(VELOCITY, st.floats(-1.0, 1.0), VELOCITY, LIMIT, st.floats(1.0, 1e7))
def test_the_stretch_to_a_lower_velocity_is_that_of_the_ramp(  # type: ignore[no-untyped-def]
    v, share, w, down, jerk
) -> None:
    a = share * down
    if v + 0.5 * a * abs(a) / jerk < w:
        return
    time = ramp_duration(v, a, w, down, down, jerk)
    way, _, _ = ramp_after(v, a, w, down, down, jerk, time)
    assert stretch(v, a, w, down, jerk) == pytest.approx(way, rel=1e-6, abs=1e-6)


@given(st.floats(0.0, 100.0), st.floats(1e-2, 1e4), LIMIT, st.floats(10.0, 1e7))
def test_what_is_reachable_takes_the_whole_length(w, length, down, jerk) -> None:  # type: ignore[no-untyped-def]
    v = reachable(w, length, down, jerk)
    assert v >= w
    assert stretch(v, 0.0, w, down, jerk) == pytest.approx(length, rel=1e-3)


def test_a_velocity_that_is_low_already_needs_no_way() -> None:
    assert stretch(5.0, -10.0, 6.0, 100.0, 1000.0) == 0.0
    assert reachable(3.0, 0.0, 100.0, 1000.0) == 3.0


@given(VELOCITY, st.floats(0.0, 1.0), LIMIT, st.floats(10.0, 1e7))
def test_where_rest_is_nearer_than_a_lower_velocity(v, share, down, jerk) -> None:  # type: ignore[no-untyped-def]
    w = share * v
    if stretch(v, 0.0, 0.0, down, jerk) < stretch(v, 0.0, w, down, jerk) * (1 - 1e-9):
        assert rest_is_nearer(w, down, jerk)
    assert stretch(20.0, 0.0, 0.0, 1000.0, 20_000.0) < stretch(20.0, 0.0, 7.0, 1000.0, 20_000.0)
