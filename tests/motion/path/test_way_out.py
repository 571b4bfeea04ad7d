"""Ways out: they end at their gate with its safe velocity, and keep what is before it."""

from hypothesis import given
from hypothesis import strategies as st

from achse.motion.path.record import gate_record, state_record
from achse.motion.path.way_out import find_rest, find_way_out, follow_way_out, keep_way_out

DOWN, JERK = 1000.0, 20_000.0


def ahead(*places: tuple[float, float, float]):  # type: ignore[no-untyped-def]
    """Gates at ways, with limits and safe velocities; spans as of a line."""
    state, gates = state_record(), []
    for at, limit, safe in places:
        gate = gate_record()
        gate.at, gate.limit, gate.safe, gate.cap = at, limit, safe, 1e3
        gate.wanted_limit, gate.wanted_safe = 0.5 * limit, 0.5 * safe
        gate.start = gate.acceleration = gate.rest = gate.deceleration = DOWN
        gate.first_jerk = gate.jerk = JERK
        gate.power = gate.most_acceleration = gate.most_deceleration = gate.most_jerk = 1e12
        gates.append(gate)
    state.gates = len(gates)
    return gates, state


@given(st.floats(0.0, 200.0), st.floats(-1.0, 1.0), st.floats(0.1, 50.0), st.floats(0.0, 100.0))
def test_a_way_out_ends_at_its_gate(v, share, at, safe) -> None:  # type: ignore[no-untyped-def]
    gates, state = ahead((at, safe, safe), (at + 10.0, 0.0, 0.0))
    a = share * DOWN
    k, speed, down, jerk = find_way_out(gates, state, 0.0, v, a, v, False, True)
    if k < 0:
        assert v > safe or a != 0.0
        return
    assert speed <= gates[k].safe
    keep_way_out(state, gates[k].at, 0.0, v, a, speed, down, jerk, False)
    before, x, step = a, 0.0, 0.01 * state.out_duration + 1e-9
    while state.out:
        x, _ = follow_way_out(state, step)
        assert abs(state.acceleration - before) <= JERK * step * (1 + 1e-9) + 1e-9
        assert -DOWN * (1 + 1e-9) <= state.acceleration <= max(a, 0.0) + 1e-9
        before = state.acceleration
    assert state.velocity == speed
    assert state.acceleration == 0.0
    assert x <= gates[k].at + 2e-8
    assert x >= gates[k].at - 2e-8 or speed == 0.0


def test_what_is_wanted_is_kept_on_request() -> None:
    gates, state = ahead((5.0, 100.0, 100.0), (10.0, 0.0, 0.0))
    assert find_way_out(gates, state, 4.9, 80.0, 0.0, 80.0, False, True)[0] == 0
    assert find_way_out(gates, state, 4.9, 80.0, 0.0, 80.0, True, True)[0] == -1


def test_a_gate_that_was_passed_too_fast_has_no_way_out() -> None:
    gates, state = ahead((5.0, 50.0, 50.0), (60.0, 0.0, 0.0))
    assert find_way_out(gates, state, 5.1, 49.0, 0.0, 49.0, False, True)[0] == 1
    assert find_way_out(gates, state, 5.1, 49.0, 0.0, 51.0, False, True)[0] == -1


def test_rest_is_possible_where_no_slower_velocity_is() -> None:
    """From 20 to 7 mm/s, and no acceleration, takes more way than from 20 to rest."""
    gates, state = ahead((0.64, 7.0, 7.0), (20.0, 0.0, 0.0))
    k, speed, _, _ = find_way_out(gates, state, 0.0, 20.0, 0.0, 20.0, False, True)
    assert (k, speed) == (0, 0.0)
    state.velocity = 20.0
    assert 0.6 < find_rest(gates, state) < 0.64
    gates[0].at = 0.6
    assert find_way_out(gates, state, 0.0, 20.0, 0.0, 20.0, False, True)[0] == -1
