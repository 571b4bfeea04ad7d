"""Slave types 2 and 3: worked numbers, what refuses them, changes while they run."""

from math import radians, sin
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import MotionState, commands
from achse.motion.commands.slaves.synchronising import synchronise
from tests.motion.enabled_axes import gentle_axes

WAITS, SYNCHRONISES, RUNS = 11, 12, 13


def closed_form(kind: int, m: float, gear: float = 2.0) -> tuple[float, float]:
    """Position and velocity over the master of the saw 0 → 50 that meets at 200, by formulas."""
    length = 2.0 * 50.0 / gear
    m0 = 200.0 - length
    u = (m - m0) / length
    if u <= 0.0:
        return 0.0, 0.0
    if u >= 1.0:
        return 50.0 + gear * (m - 200.0), gear
    if kind == 2:
        return gear * (m - m0) ** 2 / (2.0 * length), gear * u
    return gear * length * (u**3 - u**4 / 2.0), gear * (3.0 * u**2 - 2.0 * u**3)


@pytest.mark.parametrize("kind", [2, 3])
def test_the_formulas_give_the_worked_numbers(kind: int) -> None:
    assert closed_form(kind, 150.0) == (0.0, 0.0)
    assert closed_form(kind, 175.0) == ((12.5, 1.0) if kind == 2 else (9.375, 1.0))
    assert closed_form(kind, 200.0) == (50.0, 2.0)
    assert closed_form(kind, 250.0) == (150.0, 2.0)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("kind", [2, 3])
def test_a_diagonal_saw_keeps_its_law_and_says_what_it_does(kind: int, compiled: bool) -> None:
    nc = gentle_axes(compiled=compiled)
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    assert commands.couple(slave, kind, 1, 0, 0, 200.0, 50.0, 30.0, 1.0) == 0
    seen = []
    while master.set_position < 250.0:
        nc.cycle()
        m = master.set_position
        place, slope = closed_form(kind, m)
        assert slave.set_position == pytest.approx(place, abs=1e-9)
        assert slave.set_velocity == pytest.approx(slope * master.set_velocity, abs=1e-9)
        seen.append(slave.motion_state)
        wanted = WAITS if m < 150.0 else SYNCHRONISES if m < 200.0 else RUNS
        assert slave.motion_state == wanted
    assert set(seen) == {WAITS, SYNCHRONISES, RUNS}
    assert slave.set_gear_ratio == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize("kind", [2, 3])
def test_the_master_may_go_back_and_forth(kind: int) -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, kind, 1, 0, 0, 200.0, 50.0, 30.0, 0.0)
    for target in (170.0, 120.0, 190.0, 160.0, 230.0, 100.0):
        commands.universal_start(master, 1, target, 100.0)
        ran = slave.motion_state == RUNS
        for _ in range(1200):
            nc.cycle()
            m = master.set_position
            place = 50.0 + 2.0 * (m - 200.0) if ran else closed_form(kind, m)[0]
            ran |= m >= 200.0
            assert slave.set_position == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize("kind", [2, 3])
def test_a_master_that_moves_back(kind: int) -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 4, 0.0, 100.0)
    nc.cycle(100)
    assert commands.couple(slave, kind, 1, 0, 0, -200.0, -50.0, 90.0, 1.0) == 0
    while master.set_position > -250.0:
        nc.cycle()
    assert slave.set_position == pytest.approx(-50.0 + master.set_position + 200.0, abs=1e-9)


def test_type_2_without_places_changes_over_at_once() -> None:
    """k = 1 / sin 30° = 2: rest to 200 with 500 and 5000 of the axis takes 0.5 s, 50 of way."""
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    here = master.set_position
    assert commands.couple(slave, 2, 1, 0, 0, 0.0, 0.0, 30.0, 1.0) == 0
    states = []
    while slave.motion_state != RUNS:
        nc.cycle()
        states.append(slave.motion_state)
    assert len(states) * 0.002 == pytest.approx(0.5, abs=0.003)
    assert set(states[1:-1]) == {SYNCHRONISES}
    way = 2.0 * (master.set_position - here)
    assert slave.set_position == pytest.approx(way - 50.0, abs=1e-9)


def test_other_gears_of_a_saw_that_runs() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 90.0, 1.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1500)
    assert slave.motion_state == RUNS
    here, there = slave.set_position, master.set_position
    assert commands.change_coupling(slave, 0.0, 0.0, 45.0, 2.0) == 0
    nc.cycle(100)
    gear = 2.0 / sin(radians(45.0))
    assert slave.set_position == pytest.approx(here + gear * (master.set_position - there))
    assert slave.set_velocity == pytest.approx(gear * 100.0)


def test_a_saw_that_waits_waits_by_new_parameters() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, 3, 1, 0, 0, 2000.0, 50.0, 30.0, 1.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(200)
    assert commands.change_coupling(slave, 200.0, 50.0, 30.0, 1.0) == 0
    while master.set_position < 250.0:
        nc.cycle()
        assert slave.set_position == pytest.approx(closed_form(3, master.set_position)[0], abs=1e-9)


def test_a_saw_on_its_way_takes_no_other_parameters() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0)
    commands.universal_start(master, 1, 175.0, 100.0)
    nc.cycle(2000)
    before = nc.digest()
    code = commands.change_coupling(slave, 300.0, 50.0, 30.0, 1.0)
    assert code == NcError.SYNCHRONISING_CONDITIONS
    assert nc.digest() == before


@pytest.mark.parametrize(
    "parameters",
    [
        (200.0, 50.0, 0.0, 1.0),
        (200.0, 50.0, -30.0, 1.0),
        (200.0, 50.0, 90.001, 1.0),
        (200.0, 50.0, 1e-300, 1.0),
        (200.0, 50.0, 1e-5, 1e6),
        (200.0, 50.0, float("nan"), 1.0),
        (200.0, -50.0, 30.0, 1.0),
        (200.0, 50.0, 30.0, -1.0),
        (200.0, 0.0, 30.0, 1.0),
        (40.0, 50.0, 30.0, 1.0),
        (2e6, 50.0, 30.0, 1.0),
    ],
)
@pytest.mark.parametrize("kind", [2, 3])
def test_what_cannot_be_met_is_refused(kind: int, parameters: tuple[float, ...]) -> None:
    nc = gentle_axes()
    _master, slave = nc
    before = slave.coupling.law
    code = commands.couple(slave, kind, 1, 0, 0, *parameters)
    assert (code, slave.coupling.law) == (NcError.SLAVE_COUPLING_PARAMETER, before)


def test_a_slave_in_motion_is_refused_a_moving_master_is_not() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.universal_start(slave, 3, 0.0, 10.0)
    nc.cycle(100)
    code = commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0)
    assert code == NcError.COUPLING_DURING_JOB
    commands.stop(slave)
    commands.universal_start(master, 3, 0.0, 10.0)
    nc.cycle(1000)
    assert commands.couple(slave, 3, 1, 0, 0, 2000.0, 50.0, 30.0, 1.0) == 0


def test_places_are_those_of_renamed_axes() -> None:
    nc = gentle_axes(3)
    master, slave, other = nc
    commands.couple(other, 1, 1, 0, 0, 1.0)
    commands.set_actual_position(master, 1, 1000.0)
    commands.set_actual_position(slave, 1, 300.0)
    nc.cycle(5)
    assert commands.couple(slave, 3, 1, 0, 0, 1200.0, 350.0, 30.0, 1.0) == 0
    commands.universal_start(master, 1, 1250.0, 100.0)
    nc.cycle(2000)
    assert slave.set_position == pytest.approx(450.0, abs=1e-9)
    commands.set_actual_position(slave, 1, 0.0)
    commands.set_actual_position(master, 1, 0.0)
    nc.cycle(5)
    commands.universal_start(master, 1, 10.0, 100.0)
    nc.cycle(1000)
    assert slave.set_position == pytest.approx(20.0, abs=1e-9)


def test_a_phase_shift_is_seen() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0)
    commands.start_phasing(slave, 2, 0, 1, 30.0, 100.0, 1000.0, 1000.0, 10000.0)
    commands.universal_start(master, 1, 170.0, 100.0)
    nc.cycle(2500)
    assert slave.set_position == pytest.approx(50.0, abs=1e-9)


@pytest.mark.parametrize("state", [WAITS, SYNCHRONISES, RUNS])
def test_a_loop_that_was_open(state: int) -> None:
    """Waiting it waits on; on its way it begins anew or stays; running it changes over smoothly."""
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0)
    targets = {WAITS: 100.0, SYNCHRONISES: 175.0, RUNS: 250.0}
    commands.universal_start(master, 1, targets[state], 100.0)
    nc.cycle(2000)
    assert slave.motion_state == state
    slave.control_dword = 0
    nc.cycle(20)
    slave.control_dword = 7
    nc.cycle(20)
    here = slave.set_position
    commands.universal_start(master, 1, 400.0, 100.0)
    before, fastest = here, 0.0
    for _ in range(2500):
        nc.cycle()
        fastest = max(fastest, abs(slave.set_position - before))
        before = slave.set_position
    assert slave.error_code == 0
    assert fastest <= 200.0 * 0.002 * 1.001
    assert slave.set_position > here + 100.0 or slave.motion_state == MotionState.INACTIVE


def test_a_master_that_is_an_encoder() -> None:
    nc = gentle_axes()
    master, slave = nc
    master.axis_type = 5
    master.control_dword = 0
    assert commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0) == 0
    for _ in range(2400):
        master.machine.position += 0.1
        master.wake()
        nc.cycle()
    assert master.actual_position > 210.0
    wanted = closed_form(3, master.actual_position)[0]
    assert slave.set_position == pytest.approx(wanted, abs=1e-6)


def test_stopping_a_saw() -> None:
    nc = gentle_axes()
    master, slave = nc
    commands.couple(slave, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1500)
    here, speed = slave.set_position, slave.set_velocity
    assert commands.stop_slave(slave) == 0
    assert (slave.coupling.law, master.coupling_state) == (0, 0)
    nc.cycle(1000)
    way = 0.5 * speed * (speed / 500.0 + 500.0 / 5000.0)
    assert slave.set_position == pytest.approx(here + way, abs=1e-6)
    assert slave.motion_state == 0
    assert commands.stop_slave(slave) == NcError.FUNCTION_NOT_AVAILABLE


def test_kept_by_both_kernels() -> None:
    digests: list[Any] = []
    for compiled in (False, True):
        nc = gentle_axes(4, compiled=compiled)
        first, second, third, fourth = nc
        commands.couple(second, 2, 1, 0, 0, 20.0, 5.0, 30.0, 1.0)
        commands.couple(third, 3, 2, 0, 0, 30.0, 5.0, 77.7, 0.7)
        commands.couple(fourth, 2, 3, 0, 0, 0.0, 0.0, 60.0, 1.3)
        commands.universal_start(first, 3, 0.0, 100.0)
        nc.cycle(700)
        commands.stop(first)
        nc.cycle(300)
        digests.append(nc.digest())
    assert digests[0] == digests[1]


STEP = st.tuples(
    st.sampled_from(["start", "endless", "back", "stop", "override"]),
    st.floats(-400.0, 400.0),
    st.floats(0.0, 1.0),
    st.integers(1, 400),
)


@settings(max_examples=25, deadline=None)
@given(
    kind=st.sampled_from([2, 3]), angle=st.floats(5.0, 90.0), ratio=st.floats(0.2, 3.0),
    back=st.booleans(), master_place=st.floats(-500.0, 500.0), place=st.floats(-500.0, 500.0),
    way=st.floats(5.0, 100.0), ahead=st.floats(0.0, 150.0), warm=st.integers(0, 200),
    first=st.booleans(), compiled=st.booleans(), steps=st.lists(STEP, min_size=1, max_size=6),
    release=st.integers(-2, 6), velocity=st.floats(1.0, 300.0), target=st.floats(0.0, 359.0),
)  # fmt: skip
def test_whatever_the_master_does_the_saw_keeps_its_law_and_does_not_jump_when_let_go(
    kind: int, angle: float, ratio: float, back: bool, master_place: float, place: float,
    way: float, ahead: float, warm: int, first: bool, compiled: bool, steps: list[Any],
    release: int, velocity: float, target: float,
) -> None:  # fmt: skip
    """Forms of release: those of 0x41, -1 without follow-up, -2 an error."""
    nc = gentle_axes(2, compiled=compiled)
    master, slave = tuple(nc) if first else tuple(nc)[::-1]
    slave.drive.reference_velocity = 1e6
    commands.set_actual_position(master, 1, master_place)
    commands.set_actual_position(slave, 1, place)
    nc.cycle(5)
    heading = -1.0 if back else 1.0
    gear = heading * ratio / sin(radians(angle))
    commands.universal_start(master, 4 if back else 3, 0.0, 50.0)
    nc.cycle(warm + 30)
    s0 = slave.set_position
    length = 2.0 * way / abs(gear)
    m0 = master.set_position + heading * (ahead + 0.001)
    meets, goes = m0 + heading * length, way
    parameters = meets, s0 + goes, angle, heading * ratio
    assert commands.couple(slave, kind, master.axis_id, 0, 0, *parameters) == 0
    ran = False
    for name, size, share, cycles in steps:
        match name:
            case "start":
                commands.universal_start(master, 2, size, abs(size) + 1.0)
            case "endless":
                commands.universal_start(master, 3, 0.0, abs(size) + 1.0)
            case "back":
                commands.universal_start(master, 4, 0.0, abs(size) + 1.0)
            case "stop":
                commands.stop(master)
            case "override":
                master.velocity_override = int(1e6 * share)
        for _ in range(cycles):
            nc.cycle()
            u = heading * (master.set_position - m0) / length
            ran |= u >= 1.0
            if ran:
                law, slope = goes + gear * (master.set_position - meets), gear
            elif u <= 0.0:
                law = slope = 0.0
            elif kind == 2:
                law, slope = goes * u * u, gear * u
            else:
                law = 2.0 * goes * (u**3 - u**4 / 2.0)
                slope = gear * (3.0 * u * u - 2.0 * u**3)
            assert slave.set_position - s0 == pytest.approx(law, abs=1e-7)
            assert slave.set_velocity == pytest.approx(slope * master.set_velocity, abs=1e-6)
    p, v, a = slave.set_position, slave.set_velocity, slave.set_acceleration
    if release == -2:
        slave.control_dword = 0
    elif release == -1:
        assert commands.decouple(slave) == 0
    else:
        code = commands.decouple_with_follow_up(slave, release, target, velocity)
        if code:
            remaining = (NcError.DECOUPLING_VELOCITY, NcError.SET_VELOCITY_NOT_ALLOWED)
            assert release == 1 or (release == 4 and code in remaining), hex(
                code
            )  # none, or too much
            assert commands.stop_slave(slave) == 0
    closed = slave.loop_closed
    nc.cycle()
    steepest = max(abs(a), 500.0) + 5000.0 * 0.002
    if closed and not slave.loop_closed:
        assert slave.set_position == slave.encoder.actual_position
    else:
        assert abs(slave.set_position - p - v * 0.002) <= abs(v) * 0.002 * (release == 6) + (
            steepest * 0.002**2 + 1e-9
        )
    if release not in (-2, 6):
        assert abs(slave.set_velocity - v) <= steepest * 0.002 + 1e-9
    for _ in range(300):
        p, v = slave.set_position, slave.set_velocity
        nc.cycle()
        if not slave.loop_closed:  # then the set position is where the motor is
            assert slave.set_position == slave.encoder.actual_position
            continue
        most = max(abs(v), abs(slave.set_velocity)) * 0.002
        assert abs(slave.set_position - p) <= most * 1.01 + 0.01


@pytest.mark.parametrize("trembling", [0.0, 0.0005])
def test_a_saw_takes_over_from_an_encoder_without_a_step(trembling: float) -> None:
    """Its velocity changes as its master's does, and by its own limit at most."""
    nc = gentle_axes(max_velocity=1e6)
    master, slave = nc
    master.axis_type = 5
    master.control_dword = 0
    ran, state, v, seen, a = 0, 0, 0.0, 0.0, 0.0
    for n in range(1500):
        master.machine.position += 0.1 + trembling * (n % 3 - 1)
        master.wake()
        nc.cycle()
        if n == 300:
            assert commands.couple(slave, 2, 1, 0, 0, 0.0, 0.0, 90.0, 1.0) == 0
        change = slave.set_velocity - v
        trembled = abs(master.leading_value.velocity - seen)
        assert abs(change) <= 500.0 * 0.002 + trembled + 1e-9
        if n > 300 and slave.motion_state == RUNS:
            if state != RUNS:  # in the cycle after it there is nothing left but the trembling
                assert abs(change) <= max(abs(a), 10.0) * 0.002 + trembled + 1e-9
            ran += 1
            assert slave.set_velocity == pytest.approx(master.leading_value.velocity, abs=1e-9)
        state, v, seen, a = (
            slave.motion_state,
            slave.set_velocity,
            master.leading_value.velocity,
            abs(slave.set_acceleration),
        )
    assert ran > 500


@pytest.mark.parametrize("type", [2, 3])
@pytest.mark.parametrize("compiled", [False, True])
def test_a_way_over_the_master_that_is_too_fast_is_an_error(type: int, compiled: bool) -> None:
    """Bare world 475: at a small angle the saw jumped 80 times as far as its velocity allows."""
    nc = gentle_axes(compiled=compiled, max_velocity=100.0)
    master, slave = nc
    assert commands.couple(slave, type, 1, 0, 0, 5.0, 3.0, 0.7, 0.0) == 0
    assert commands.universal_start(master, 3, 0.0, 50.0) == 0
    most = min(slave.max_velocity, slave.drive.reference_velocity) * 0.002 * (1.0 + 1e-9)
    before = slave.set_position
    for _ in range(600):
        nc.cycle()
        assert abs(slave.set_position - before) <= most
        before = slave.set_position
    assert NcError.of(slave.error_code) is NcError.SET_VELOCITY_TOO_HIGH
    assert (slave.coupling.law, slave.set_velocity, master.error_code) == (0, 0.0, 0)


@pytest.mark.parametrize("seed", range(6))
def test_slave_that_cannot_begin_takes_its_own_acceleration_away_by_its_jerk(seed: int) -> None:
    """Swarm seed 20398: it was dropped within a cycle."""
    dice = Random(seed)
    nc = gentle_axes(max_velocity=500.0, compiled=False)
    master, slave = nc
    assert commands.universal_start(master, 3, 0.0, 450.0) == 0
    nc.cycle(1000)
    assert commands.universal_start(slave, 4, 0.0, dice.uniform(200.0, 490.0)) == 0
    nc.cycle(dice.randrange(20, 150))
    accelerates = slave.set_acceleration
    assert accelerates < 0.0
    near = master.set_position + dice.uniform(0.9, 1.0)
    there = slave.set_position + dice.uniform(4.0, 9.0)
    assert synchronise(slave, 6, 1, 0, 0, dice.uniform(0.2, 1.0), near, there, mask=1 << 20) == 0
    nc.cycle()
    assert NcError.of(slave.error_code) is NcError.SET_VELOCITY_TOO_HIGH
    change = abs(slave.set_acceleration - accelerates)
    assert change <= slave.default_jerk * 0.002 * (1.0 + 1e-9)
