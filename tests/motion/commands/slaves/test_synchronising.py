"""Universal flying saw: what is refused, what each bit of the mask does, new orders on the way."""

from itertools import pairwise
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import Nc, commands
from achse.motion.states import SynchronisingBit as Bit
from tests.motion.enabled_axes import gentle_axes

RUNS = 13


@pytest.fixture
def moving() -> Nc:
    """Axis 1 moves with 100, axis 2 stands."""
    nc = gentle_axes()
    commands.universal_start(nc.axis(1), 3, 0.0, 100.0)
    nc.cycle(1000)
    return nc


GOOD: dict[str, Any] = {
    "slave_type": 6, "master_id": 1, "master_subindex": 0, "slave_subindex": 0, "gear": 1.0,
    "master_position": 1000.0, "slave_position": 100.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"slave_type": 2}, NcError.SLAVE_TYPE),
        ({"slave_type": 0}, NcError.SLAVE_TYPE),
        ({"master_id": 7}, NcError.ADDRESS_MASTER_AXIS),
        ({"master_id": 2}, NcError.MASTER_NOT_INSERTED),
        ({"master_subindex": 1}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"slave_subindex": 8}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"gear": 0.0}, NcError.GEAR_FACTOR_ZERO),
        ({"gear": 2e6}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"gear": float("nan")}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"master_position": float("inf")}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"slave_position": 1e300}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"velocity": -1.0}, NcError.SYNCHRONISING_DYNAMICS),
        ({"acceleration": -1.0}, NcError.SYNCHRONISING_DYNAMICS),
        ({"deceleration": float("nan")}, NcError.SYNCHRONISING_DYNAMICS),
        ({"jerk": float("inf")}, NcError.SYNCHRONISING_DYNAMICS),
        ({"master_position": 0.0}, NcError.SYNCHRONISING_PROFILE),
        ({"slave_position": -100.0}, NcError.SYNCHRONISING_PROFILE),
        ({"slave_position": 0.0}, NcError.SYNCHRONISING_PROFILE),
        ({"gear": -1.0}, NcError.SYNCHRONISING_PROFILE),
    ],
)
def test_what_is_refused(moving: Nc, change: dict[str, Any], code: NcError) -> None:
    slave = moving.axis(2)
    record = slave.set_position, slave.coupling.law, slave.set_motion_phase, slave.sync.mask
    assert NcError.of(commands.synchronise(slave, **(GOOD | change))) is code
    assert record == (
        slave.set_position,
        slave.coupling.law,
        slave.set_motion_phase,
        slave.sync.mask,
    )
    moving.cycle(10)
    assert (slave.set_velocity, slave.error_code, slave.coupling.law) == (0.0, 0, 0)


@pytest.mark.parametrize("kind", [5, 6])
def test_a_slave_that_moves_while_its_master_stands_is_refused(kind: int) -> None:
    nc = gentle_axes()
    slave = nc.axis(2)
    commands.universal_start(slave, 3, 0.0, 100.0)
    nc.cycle(500)
    code = commands.synchronise(slave, kind, 1, 0, 0, 1.0, 1000.0, 1000.0)
    assert code == NcError.FLYING_COUPLING_MASTER_STANDS
    nc.cycle(100)
    assert slave.set_velocity == 100.0


def test_other_slaves_are_refused(moving: Nc) -> None:
    master, slave = moving
    commands.stop(master)
    moving.cycle(500)
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    assert commands.synchronise(slave, **GOOD) == NcError.SLAVE_ADDRESS


def test_the_service_by_four_parameters_does_not_couple_them(moving: Nc) -> None:
    for kind in (5, 6):
        code = commands.couple(moving.axis(2), kind, 1, 0, 0, 1.0, 1000.0, 100.0, 0.0)
        assert code == NcError.SLAVE_TYPE


def test_a_ring_leaves_a_saw_that_runs_as_it_was() -> None:
    nc = gentle_axes(3)
    first, second, third = nc
    assert commands.synchronise(second, 6, 1, 0, 0, 1.0, 100.0, 50.0, jerk=77.0, mask=1) == 0
    assert commands.couple(third, 1, 2, 0, 0, 1.0) == 0
    code = commands.synchronise(second, 6, 3, 0, 0, 1.0, 100.0, 50.0, jerk=88.0, mask=2)
    assert code == NcError.MASTER_NOT_INSERTED
    assert (second.coupling.law, second.sync.jerk, second.sync.mask) == (6, 77.0, 1)
    commands.universal_start(first, 1, 100.0, 100.0)
    nc.cycle(2000)
    assert second.set_position == pytest.approx(50.0)


def test_new_places_while_it_runs_do_not_jump(moving: Nc) -> None:
    master, slave = moving
    m0 = master.set_position
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, m0 + 200.0, 100.0) == 0
    orders = {400: (0.5, 300.0, 200.0), 1000: (1.5, 500.0, 400.0), 1700: (1.0, 600.0, 520.0)}
    before = slave.set_velocity, slave.set_acceleration
    for n in range(6000):
        if n in orders:
            gear, ahead, place = orders[n]
            there = m0 + ahead + n * 0.1 - 40.0
            place = max(place, slave.set_position + 100.0)
            assert commands.synchronise(slave, 6, 1, 0, 0, gear, there, place) == 0
        moving.cycle()
        assert abs(slave.set_velocity - before[0]) < 3.0
        assert abs(slave.set_acceleration - before[1]) < 40.0
        before = slave.set_velocity, slave.set_acceleration
        if n == 5999:
            wanted = place + gear * (master.set_position - there)
            assert slave.set_position == pytest.approx(wanted, abs=1e-8)
    assert slave.motion_state == RUNS


def run(nc: Nc, cycles: int) -> list[tuple[float, float, float]]:
    slave = nc.axis(2)
    samples = [(slave.set_position, slave.set_velocity, slave.set_acceleration)]
    for _ in range(cycles):
        nc.cycle()
        samples.append((slave.set_position, slave.set_velocity, slave.set_acceleration))
    return samples


def test_a_phase_of_constant_velocity_is_preferred(moving: Nc) -> None:
    master, slave = moving
    there = master.set_position + 400.0
    mask = int(Bit.PREFER_CONSTANT_VELOCITY | Bit.MAX_ACCELERATION | Bit.MAX_DECELERATION)
    mask |= int(Bit.MAX_JERK)
    code = commands.synchronise(slave, 6, 1, 0, 0, 1.0, there, 240.0, mask=mask, jerk=5000.0)
    assert code == 0
    assert slave.sync.count == 3
    samples = run(moving, 2500)
    still = [v for _, v, a in samples if abs(a) < 1e-9 and 1.0 < v < 99.0]
    assert len(still) > 500
    assert max(still) - min(still) < 1e-9
    assert max(abs(a) for _, _, a in samples) == pytest.approx(500.0, rel=0.35)
    assert max(abs(b[2] - a[2]) for a, b in pairwise(samples)) <= 5000.0 * 0.002 * 1.001
    assert slave.set_position == pytest.approx(240.0 + master.set_position - there, abs=1e-9)
    assert slave.motion_state == RUNS


def test_without_room_for_it_the_way_is_one_span(moving: Nc) -> None:
    master, slave = moving
    there = master.set_position + 20.0
    mask = int(Bit.PREFER_CONSTANT_VELOCITY)
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, there, 10.0, mask=mask) == 0
    assert slave.sync.count == 1


@pytest.mark.parametrize(("bit", "jump"), [(0, False), (Bit.IGNORE_SLAVE_ACCELERATION, True)])
def test_the_acceleration_of_the_slave_may_be_ignored(moving: Nc, bit: int, jump: bool) -> None:
    master, slave = moving
    commands.universal_start(slave, 3, 0.0, 300.0)
    moving.cycle(120)
    a = slave.set_acceleration
    assert a > 100.0
    there, place = master.set_position + 400.0, slave.set_position + 400.0
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, there, place, mask=int(bit)) == 0
    moving.cycle()
    assert (abs(slave.set_acceleration - a) > 50.0) == jump


@pytest.mark.parametrize(("bit", "jump"), [(0, False), (Bit.IGNORE_MASTER_ACCELERATION, True)])
def test_the_acceleration_of_the_master_may_be_ignored(moving: Nc, bit: int, jump: bool) -> None:
    master, slave = moving
    commands.universal_start(slave, 3, 0.0, 100.0)
    moving.cycle(500)
    commands.universal_start(master, 3, 0.0, 300.0)
    moving.cycle(120)
    assert master.set_acceleration > 100.0
    there, place = master.set_position + 400.0, slave.set_position + 300.0
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, there, place, mask=int(bit)) == 0
    moving.cycle()
    assert (abs(slave.set_acceleration) > 50.0) == jump


CHECKS = 0x3F3F
LIMIT = st.one_of(st.just(0.0), st.floats(200.0, 3000.0))
JERK = st.one_of(st.just(0.0), st.floats(2000.0, 50000.0))


@settings(max_examples=40, deadline=None, phases=[Phase.generate])
@given(
    kind=st.sampled_from([5, 6]), speed=st.floats(-300.0, 300.0), own=st.floats(-300.0, 300.0),
    gear=st.floats(-3.0, 3.0).filter(lambda g: abs(g) > 0.05), ahead=st.floats(20.0, 600.0),
    share=st.floats(0.1, 1.5), velocity=LIMIT, acceleration=LIMIT, deceleration=LIMIT, jerk=JERK,
    mask=st.integers(0, 0x1FF_FFFF).map(lambda bits: bits & ~0x3_0000), cut=st.integers(0, 3),
    pause=st.integers(300, 900), compiled=st.booleans(), swapped=st.booleans(),
    soft=st.floats(50.0, 900.0),
)  # fmt: skip
def test_limits_are_kept_or_a_code_says_why_not(
    kind: int, speed: float, own: float, gear: float, ahead: float, share: float, velocity: float,
    acceleration: float, deceleration: float, jerk: float, mask: int, cut: int, pause: int,
    compiled: bool, swapped: bool, soft: float,
) -> None:  # fmt: skip
    """Every parameter is drawn; what the mask asks for holds in each cycle of the way."""
    nc = gentle_axes(compiled=compiled)
    master, slave = reversed(list(nc)) if swapped else nc
    mask &= (CHECKS | ~CHECKS, ~CHECKS, 0x3F | ~CHECKS, 0x3C | ~CHECKS)[cut]
    if abs(speed) > 1.0:
        commands.universal_start(master, 3 if speed > 0.0 else 4, 0.0, abs(speed))
    if abs(own) > 1.0:
        commands.universal_start(slave, 3 if own > 0.0 else 4, 0.0, abs(own))
    nc.cycle(pause)
    vm = master.set_velocity
    slave.encoder.soft_limit_max = slave.set_position + soft
    slave.encoder.soft_limit_max_enable = 1
    heading = -1.0 if vm < 0.0 else 1.0
    m0, s0 = master.set_position, slave.set_position
    there = m0 + heading * ahead
    place = s0 + heading * gear * ahead * share
    code = commands.synchronise(
        slave, kind, master.axis_id, 0, 0, gear, there, place,
        velocity, acceleration, deceleration, jerk, mask,
    )  # fmt: skip
    named = NcError.of(code)
    assert code == 0 or named is not None
    if code:
        detailed = 0x4372 <= code <= 0x438B
        assert detailed <= bool(mask & Bit.DETAILED_ERROR_CODES)
        assert slave.coupling.law == 0
        return
    v_max = (velocity or 1e4) if mask & Bit.MAX_VELOCITY else 1e300
    a_max = (acceleration or 500.0) if mask & Bit.MAX_ACCELERATION or kind == 5 else 1e300
    d_max = (deceleration or 500.0) if mask & Bit.MAX_DECELERATION or kind == 5 else 1e300
    j_max = (jerk or 5000.0) if mask & Bit.MAX_JERK or kind == 5 else 1e300
    constant = master.set_acceleration == 0.0 and vm != 0.0
    before = (slave.set_position, slave.set_velocity, slave.set_acceleration)
    peak = max(abs(before[2]), a_max, d_max)
    low, high = min(s0, place), max(s0, place)
    for _ in range(8000):
        nc.cycle()
        s, v, a = slave.set_position, slave.set_velocity, slave.set_acceleration
        if slave.motion_state == RUNS or slave.error_code:
            break
        assert abs(s - before[0]) <= 0.002 * max(abs(v), abs(before[1])) * 1.5 + 0.05
        if constant:
            assert abs(v) <= v_max * (1 + 1e-9) + 1e-6 or kind == 5
            if kind == 6 and a * v != 0.0:
                limit = a_max if a * v > 0.0 else d_max
                assert abs(a) <= limit * (1 + 1e-9) + 1e-6
            if kind == 5:
                assert abs(a) <= peak * (1 + 1e-9)
                assert abs(a - before[2]) <= j_max * 0.002 * (1 + 1e-9) + 1e-6
            if kind == 6:
                width = 1e-6 * (abs(high - low) + 1.0)
                assert s >= low - width or not mask & Bit.UNDERSHOOT_POSITION
                assert s <= high + width or not mask & Bit.OVERSHOOT_POSITION
                assert s <= slave.encoder.soft_limit_max + width or not mask & Bit.MAX_POSITION
            assert v <= 1e-6 or not mask & Bit.OVERSHOOT_VELOCITY_ZERO
            assert v >= -1e-6 or not mask & Bit.UNDERSHOOT_VELOCITY_ZERO
        before = (s, v, a)
    if constant and not slave.error_code and (kind == 5 or 15.0 * abs(vm) > ahead):
        assert slave.motion_state == RUNS
        assert slave.set_velocity == pytest.approx(gear * master.set_velocity, abs=1e-9)
        if kind == 6:
            wanted = place + gear * (master.set_position - there)
            assert slave.set_position == pytest.approx(wanted, abs=1e-7)
