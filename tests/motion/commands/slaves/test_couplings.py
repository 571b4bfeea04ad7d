"""Coupling and letting go: what is refused, what a slave does afterwards."""

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.states import DecouplingType

ENDLESS = 2
VALUES = {"control_dword": 7, "velocity_override": 1_000_000}


def pair(gear: float = 1.0, *, velocity: float = 0.0, **values: float) -> tuple[Nc, Axis, Axis]:
    """A master, and a slave that follows it; at `velocity` of the master."""
    axes = [AxisParameters(n, values=VALUES | values) for n in (1, 2)]
    nc = Nc(2_000_000, axes)
    nc.cycle(3)
    master, slave = nc
    assert commands.couple(slave, 1, 1, 0, 0, gear) == 0
    if velocity:
        commands.universal_start(master, 3 if velocity > 0 else 4, 0.0, abs(velocity))
        nc.cycle(1500)
    return nc, master, slave


def test_only_a_slave_can_be_uncoupled(rig: Any) -> None:
    code = NcError.DECOUPLING_NOT_POSSIBLE
    rig.refuses(code, commands.decouple_and_start, 1, 10.0, 100.0)
    rig.refuses(code, commands.decouple)
    rig.refuses(code, commands.decouple_with_follow_up, 0)


def test_at_rest_it_rests() -> None:
    nc, _, slave = pair()
    assert commands.decouple(slave) == 0
    assert (slave.set_motion_phase, slave.coupling_state) == (0, 0)
    nc.cycle(100)
    assert slave.resting


def test_a_coupled_axis_rests_with_its_master() -> None:
    nc, master, slave = pair()
    nc.cycle(200)
    assert (master.resting, slave.resting) == (1, 1)
    commands.start(master, 1, 1.0, 10.0)
    nc.cycle(5)
    assert slave.set_position == master.set_position > 0.0


@pytest.mark.parametrize("velocity", [100.0, -100.0])
def test_in_motion_it_goes_on(velocity: float) -> None:
    nc, _, slave = pair(2.0, velocity=velocity)
    before = slave.set_position
    assert commands.decouple(slave) == 0
    nc.cycle()
    assert slave.set_position == pytest.approx(before + 2.0 * velocity * 0.002)
    nc.cycle(500)
    assert slave.set_velocity == pytest.approx(2.0 * velocity)
    assert commands.stop(slave) == 0


def test_acceleration_runs_out_under_the_jerk() -> None:
    """v = 100, a = 500, j = 5000: 0.1 s later v = 125, and 11.666666667 farther."""
    nc, _master, slave = pair(default_jerk=5000.0, max_velocity=1e4)
    slave.set_velocity, slave.set_acceleration = 100.0, 500.0
    begin = slave.set_position
    assert commands.decouple(slave) == 0
    nc.cycle(50)
    assert slave.set_velocity == pytest.approx(125.0)
    assert slave.set_position - begin == pytest.approx(11.666666667)


def test_where_that_would_turn_it_round_it_rests() -> None:
    nc, _master, slave = pair(default_jerk=5000.0)
    slave.set_velocity, slave.set_acceleration = 10.0, -500.0
    assert commands.decouple(slave) == 0
    for _ in range(500):
        nc.cycle()
        assert slave.set_velocity >= 0.0
    assert (slave.set_velocity, slave.set_motion_phase) == (0.0, 0)


FOLLOW_UPS = [
    (0, 0.0, 0.0, 0.0),
    (2, 0.0, 0.0, 100.0),
    (3, 0.0, 40.0, 40.0),
    (4, 600.0, 0.0, 0.0),
    (5, 600.0, 40.0, 0.0),
    (6, 0.0, 0.0, 0.0),
]


@pytest.mark.parametrize(("kind", "position", "velocity", "end"), FOLLOW_UPS)
def test_follow_ups(kind: int, position: float, velocity: float, end: float) -> None:
    nc, _, slave = pair(velocity=100.0)
    assert commands.decouple_with_follow_up(slave, kind, position, velocity) == 0
    assert slave.coupling_state == 0
    if kind == 6:
        assert slave.set_velocity == 0.0
    nc.cycle(10_000)
    assert slave.set_velocity == pytest.approx(end)
    if position:
        assert slave.set_position == position


def test_an_oriented_stop() -> None:
    nc, _, slave = pair(velocity=100.0)
    assert commands.decouple_with_follow_up(slave, 1, 90.0) == 0
    nc.cycle(10_000)
    assert slave.set_position_modulo == pytest.approx(90.0)
    assert (slave.set_velocity, slave.coupling_state) == (0.0, 0)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((7,), NcError.DECOUPLING_TYPE),
        ((3, 0.0, 0.0), NcError.DECOUPLING_VELOCITY),
        ((5, 0.0, -1.0), NcError.DECOUPLING_VELOCITY),
        ((0, 0.0, 0.0, -1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((0, 0.0, 0.0, 0.0, -1.0), NcError.DECELERATION_NOT_POSITIVE),
        ((0, 0.0, 0.0, 0.0, 0.0, -1.0), NcError.JERK_NOT_POSITIVE),
        ((1, -1.0), NcError.MODULO_START_RANGE),
        ((5, float("nan"), 10.0), NcError.START_AXIS_DATA),
    ],
)
def test_what_is_refused_leaves_it_coupled(arguments: Any, error: NcError) -> None:
    nc, master, slave = pair(velocity=100.0)
    assert commands.decouple_with_follow_up(slave, *arguments) == error
    assert (slave.coupling_state, master.coupling_state) == (3, 1)
    nc.cycle()
    assert slave.set_position == master.set_position


@pytest.mark.parametrize("speed", [0.0, 5e-4])
def test_a_slave_that_hardly_moves_has_no_velocity_to_keep(speed: float) -> None:
    slave = pair(gear=1e-5, velocity=100.0 * speed / 1e-3)[2]
    assert slave.set_velocity == pytest.approx(speed, rel=1e-6)
    refusal = commands.decouple_with_follow_up(slave, 4, 10.0)
    assert refusal == NcError.DECOUPLING_VELOCITY
    assert slave.coupling_state == 3


@settings(max_examples=20, deadline=None)
@given(
    kind=st.sampled_from([0, 2, 3, 4, 5, 1]),
    gear=st.floats(-10.0, 10.0).filter(lambda g: abs(g) > 0.01),
    velocity=st.floats(1.0, 150.0),
    position=st.floats(0.0, 359.0),
    own=st.floats(1.0, 500.0),
    cycles=st.integers(1, 400),
    dynamics=st.tuples(st.floats(0.0, 5e4), st.floats(0.0, 5e4), st.floats(0.0, 1e6)),
)
def test_letting_go_never_jumps(
    kind: int,
    gear: float,
    velocity: float,
    position: float,
    own: float,
    cycles: int,
    dynamics: Any,
) -> None:
    nc, master, slave = pair(gear, controller_following_error_position_monitoring_enable=0)
    commands.universal_start(master, 1, 100.0, velocity)
    nc.cycle(cycles)
    before, speed = slave.set_position, slave.set_velocity
    acceleration = abs(slave.set_acceleration)
    if commands.decouple_with_follow_up(
        slave, kind, position, own, *(each if each > 0.1 else 0.0 for each in dynamics)
    ):
        return
    steepest = max(acceleration, *(dynamics[:2]), 1500.0) * 1.000001
    for _ in range(300):
        nc.cycle()
        assert (
            abs(slave.set_velocity - speed)
            <= 0.002 * max(steepest, abs(slave.set_acceleration) * 1.01) + 1e-6
        )
        mean = 0.5 * (slave.set_velocity + speed)
        assert abs(slave.set_position - before - mean * 0.002) <= 0.002**2 * steepest + 1e-6
        before, speed = slave.set_position, slave.set_velocity
    assert slave.error_code == 0


def test_a_slave_with_an_error_is_let_go_and_its_order_too() -> None:
    nc, master, slave = pair(velocity=100.0)
    commands.set_external_error(slave, 0x4655)
    nc.cycle(1000)
    assert (slave.coupling_state, slave.set_velocity) == (0, 0.0)
    commands.reset(slave)
    commands.parameterized_stop(master, 1000.0, 10_000.0)
    nc.cycle(1000)
    assert commands.couple(master, 1, 2, 0, 0, 1.0) == 0


def test_an_error_of_the_master_stops_the_slave_with_it() -> None:
    nc, master, slave = pair(velocity=100.0)
    commands.set_external_error(master, 0x4655)
    for _ in range(1000):
        nc.cycle()
        assert slave.set_position == master.set_position
    assert (slave.coupling_state, slave.error_code, slave.set_velocity) == (3, 0, 0.0)


@pytest.mark.parametrize("kind", [5, 6, 12])
@pytest.mark.parametrize("seed", range(12))
def test_letting_go_of_a_saw_never_jumps(kind: int, seed: int) -> None:
    """Before it runs with its master and after, by each follow-up, in either order of the axes."""
    dice = random.Random(f"{kind} {seed}")
    presets = {
        "control_dword": 7,
        "velocity_override": 1_000_000,
        "controller_following_error_position_monitoring_enable": 0,
    }
    nc = Nc(2_000_000, [AxisParameters(n, values=presets) for n in (1, 2)], compiled=seed % 4 > 0)
    nc.cycle(3)
    master, slave = dice.sample(list(nc), 2)
    speed, gear = dice.uniform(10.0, 150.0), dice.uniform(0.2, 1.5)
    commands.universal_start(master, 3, 0.0, speed)
    nc.cycle(500)
    id, here = master.axis_id, master.set_position
    if kind == 12:
        code = commands.couple(slave, 12, id, 0, 0, 1.0, dice.uniform(0.2, 1.0))
    else:
        way = dice.uniform(0.5, 2.0) * speed
        code = commands.synchronise(slave, kind, id, 0, 0, gear, here + way, 0.5 * gear * way)
    assert code == 0
    nc.cycle(dice.randint(1, 1500))
    form, own = dice.randrange(7), dice.uniform(1.0, 200.0)
    acceleration = dice.choice((0.0, dice.uniform(100.0, 1e4)))
    before, v, a = slave.set_position, slave.set_velocity, slave.set_acceleration
    code = commands.decouple_with_follow_up(
        slave, form, dice.uniform(0.0, 359.0), own, acceleration
    )
    if code:
        assert slave.coupling.law == kind
        return
    steepest = 1.000001 * max(abs(a), acceleration, 1500.0)
    for _ in range(300):
        nc.cycle()
        if form == DecouplingType.INSTANTANEOUS_STOP:
            assert (slave.set_position, slave.set_velocity) == (before, 0.0)
            continue
        change = abs(slave.set_velocity - v)
        assert change <= 0.002 * max(steepest, 1.01 * abs(slave.set_acceleration)) + 1e-6
        mean = 0.5 * (slave.set_velocity + v)
        assert abs(slave.set_position - before - 0.002 * mean) <= 0.002**2 * steepest + 1e-6
        before, v = slave.set_position, slave.set_velocity
    assert (slave.coupling.law, slave.error_code) == (0, 0)


@pytest.mark.parametrize("command", ["halt", "stop", "parameterized", "emergency", "clear", "move"])
def test_a_motion_of_its_own_within_a_cycle_lets_a_slave_go(command: str) -> None:
    """Bare worlds 1363 and 3133: the slave stayed coupled, and followed after its halt."""
    nc, master, slave = pair(allow_slave_motion_commands=1)
    assert {
        "halt": lambda: commands.universal_start(slave, 0x2000, 0.0, 0.0),
        "stop": lambda: commands.stop(slave),
        "parameterized": lambda: commands.parameterized_stop(slave, 500.0, 5000.0),
        "emergency": lambda: commands.emergency_stop(slave, 1500.0, 5000.0),
        "clear": lambda: commands.clear(slave),
        "move": lambda: commands.universal_start(slave, 1, 1e-9, 100.0),
    }[command]() == 0
    nc.cycle()
    rests = slave.set_position
    assert commands.universal_start(master, 3, 0.0, 100.0) == 0
    nc.cycle(500)
    assert (slave.coupling.law, slave.set_position, master.followers) == (0, rests, 0)


def test_an_oriented_stop_from_rest_is_refused() -> None:
    """Bare world 1007: it was a positioning at velocity 0, which never ended."""
    nc, _, slave = pair()
    before = nc.digest()
    form = DecouplingType.ORIENTED_STOP
    code = commands.decouple_with_follow_up(slave, form, 5.0)
    assert (NcError.of(code), nc.digest()) == (NcError.DECOUPLING_VELOCITY, before)


@pytest.mark.parametrize("seed", range(20))
def test_a_slave_let_go_before_its_law_acts_keeps_its_jerk(seed: int) -> None:
    """World of motion 7100230: in a last ramp the jerk behind a coupling became twice its own."""
    dice = random.Random(seed)
    jerk = 10.0 ** dice.uniform(3.0, 5.0)
    presets = {
        "default_jerk": jerk,
        "controller_following_error_position_monitoring_enable": 0,
    }
    axes = [AxisParameters(n, values=VALUES | presets) for n in (1, 2)]
    nc = Nc(1_000_000, axes, compiled=seed % 2 > 0)
    nc.cycle(3)
    master, slave = nc
    assert commands.universal_start(master, 3, 0.0, 20.0) == 0
    assert commands.universal_start(slave, 3, 0.0, dice.uniform(5.0, 100.0)) == 0
    nc.cycle(3000)
    assert commands.stop(slave) == 0
    while abs(slave.set_velocity) > 3.0:
        nc.cycle()
    while slave.set_jerk <= 0.0:
        nc.cycle()
    nc.cycle(dice.randrange(3))
    if slave.set_velocity == 0.0:
        return
    here = master.set_position
    assert commands.synchronise(slave, 5, 1, 0, 0, 1.0, here + 200.0, 100.0) == 0
    assert commands.decouple_with_follow_up(slave, dice.choice((0, 2)), 0.0, 5.0) == 0
    assert commands.stop(slave) == 0
    commands.reset(slave)
    a = slave.set_acceleration
    for _ in range(600):
        nc.cycle()
        assert abs(slave.set_acceleration - a) <= 0.001 * jerk * (1.0 + 1e-6) + 1e-9
        a = slave.set_acceleration
    assert slave.set_motion_phase == 0
