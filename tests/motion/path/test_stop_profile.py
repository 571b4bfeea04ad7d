"""Stopping trajectories: they end at their junction with its safe velocity."""

from hypothesis import given
from hypothesis import strategies as st

from achse.motion.path.record import junction_record, state_record
from achse.motion.path.stop_profile import (
    find_rest,
    find_stop_profile,
    follow_stop_profile,
    keep_stop_profile,
)

DOWN, JERK = 1000.0, 20_000.0


def ahead(*places: tuple[float, float, float]):  # type: ignore[no-untyped-def]
    """Junctions at ways, with limits and safe velocities; spans as of a line."""
    state, junctions = state_record(), []
    for at, limit, safe in places:
        junction = junction_record()
        junction.at, junction.limit, junction.safe, junction.cap = at, limit, safe, 1e3
        junction.wanted_limit, junction.wanted_safe = 0.5 * limit, 0.5 * safe
        junction.start = junction.acceleration = junction.rest = junction.deceleration = DOWN
        junction.first_jerk = junction.jerk = JERK
        junction.power = junction.most_acceleration = 1e12
        junction.most_deceleration = junction.most_jerk = 1e12
        junctions.append(junction)
    state.junctions = len(junctions)
    return junctions, state


@given(st.floats(0.0, 200.0), st.floats(-1.0, 1.0), st.floats(0.1, 50.0), st.floats(0.0, 100.0))
def test_a_stop_profile_ends_at_its_junction(v, share, at, safe) -> None:  # type: ignore[no-untyped-def]
    junctions, state = ahead((at, safe, safe), (at + 10.0, 0.0, 0.0))
    a = share * DOWN
    k, speed, down, jerk = find_stop_profile(junctions, state, 0.0, v, a, v, False, True)
    if k < 0:
        assert v > safe or a != 0.0
        return
    assert speed <= junctions[k].safe
    keep_stop_profile(state, junctions[k].at, 0.0, v, a, speed, down, jerk, False)
    before, x, step = a, 0.0, 0.01 * state.out_duration + 1e-9
    while state.out:
        x, _ = follow_stop_profile(state, step)
        assert abs(state.acceleration - before) <= JERK * step * (1 + 1e-9) + 1e-9
        assert -DOWN * (1 + 1e-9) <= state.acceleration <= max(a, 0.0) + 1e-9
        before = state.acceleration
    assert state.velocity == speed
    assert state.acceleration == 0.0
    assert x <= junctions[k].at + 2e-8
    assert x >= junctions[k].at - 2e-8 or speed == 0.0


def test_what_is_wanted_is_kept_on_request() -> None:
    junctions, state = ahead((5.0, 100.0, 100.0), (10.0, 0.0, 0.0))
    assert find_stop_profile(junctions, state, 4.9, 80.0, 0.0, 80.0, False, True)[0] == 0
    assert find_stop_profile(junctions, state, 4.9, 80.0, 0.0, 80.0, True, True)[0] == -1


def test_a_junction_that_was_passed_too_fast_has_no_stop_profile() -> None:
    junctions, state = ahead((5.0, 50.0, 50.0), (60.0, 0.0, 0.0))
    assert find_stop_profile(junctions, state, 5.1, 49.0, 0.0, 49.0, False, True)[0] == 1
    assert find_stop_profile(junctions, state, 5.1, 49.0, 0.0, 51.0, False, True)[0] == -1


def test_rest_is_possible_where_no_slower_velocity_is() -> None:
    """From 20 to 7 mm/s, and no acceleration, takes more way than from 20 to rest."""
    junctions, state = ahead((0.64, 7.0, 7.0), (20.0, 0.0, 0.0))
    k, speed, _, _ = find_stop_profile(junctions, state, 0.0, 20.0, 0.0, 20.0, False, True)
    assert (k, speed) == (0, 0.0)
    state.velocity = 20.0
    assert 0.6 < find_rest(junctions, state) < 0.64
    junctions[0].at = 0.6
    assert find_stop_profile(junctions, state, 0.0, 20.0, 0.0, 20.0, False, True)[0] == -1
