"""Slave type 12: the slave turns with its master at the same angle, on the shortest way."""

import random
from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import commands
from tests.motion.enabled_axes import enabled_axes

RUNS = 13


station = partial(
    enabled_axes,
    max_velocity=2000.0,
    default_acceleration=1000.0,
    default_deceleration=800.0,
)


def beside(place: float, other: float, period: float = 360.0) -> float:
    """How far apart within the period, -period/2 … period/2."""
    return (place - other + period / 2) % period - period / 2


@settings(max_examples=12, deadline=None)
@given(
    speed=st.floats(-400.0, 400.0), start=st.integers(1, 900), share=st.floats(0.05, 1.0),
    slave_place=st.floats(-1000.0, 1000.0), compiled=st.booleans(), first=st.booleans(),
    changes=st.lists(
        st.tuples(st.sampled_from([0.0, 1.0, 2.0]), st.integers(1, 1500)), max_size=4
    ),
)  # fmt: skip
def test_it_comes_to_the_angle_of_its_master_with_a_share_of_its_acceleration(
    speed: float, start: int, share: float, slave_place: float, compiled: bool, first: bool,
    changes: list[tuple[float, int]],
) -> None:  # fmt: skip
    nc = station(3, compiled=compiled)
    one, two, three = nc
    master, slave, other = (one, two, three) if first else (three, two, one)
    commands.set_actual_position(slave, 1, slave_place)
    nc.cycle(3)
    commands.universal_start(master, 3 if speed > 0.0 else 4, 0.0, abs(speed) + 1.0)
    commands.universal_start(other, 3, 0.0, 77.0)
    nc.cycle(start)
    third = float(other.axis_id)
    assert commands.couple(slave, 12, master.axis_id, 0, 0, 1.0, share, third, 0.0) == 0
    mode = 1.0
    for wanted, cycles in [*changes, (1.0, 12000)]:
        if wanted != mode:
            assert commands.change_coupling(slave, wanted, share, third, 0.0) == 0
            mode = wanted
        for _ in range(cycles):
            s, v, a = slave.set_position, slave.set_velocity, slave.set_acceleration
            nc.cycle()
            running = slave.motion_state == RUNS
            limit = share * 800.0 + 1e-6
            assert running or abs(slave.set_acceleration) <= max(limit, abs(a))
            assert running or abs(slave.set_acceleration - a) <= 1e5 * 0.002 * 1.001
            largest = max(abs(v), abs(slave.set_velocity)) + 2.0
            assert abs(slave.set_position - s) <= largest * 0.002 + 1e-9
            if running and mode:
                leader = master if mode == 1.0 else other
                assert abs(beside(slave.set_position, leader.set.position)) < 1e-7
                assert slave.set_velocity == leader.set.velocity
            if running and cycles == 12000:
                break
        if mode == 0.0 and cycles > 1400 and share > 0.9:
            assert slave.set_velocity == 0.0
    assert slave.motion_state == RUNS


@pytest.mark.parametrize(("ahead", "way"), [(100.0, 100.0), (179.0, 179.0), (181.0, -179.0)])
def test_the_shortest_way(ahead: float, way: float) -> None:
    nc = station()
    master, slave = nc
    commands.set_actual_position(master, 1, ahead + 720.0)
    nc.cycle(5)
    assert commands.couple(slave, 12, 1, 0, 0, 1.0, 1.0, 0.0, 0.0) == 0
    nc.cycle(1500)
    assert slave.set_position == pytest.approx(way, abs=1e-9)
    assert slave.motion_state == RUNS


def test_rest_and_back_again() -> None:
    nc = station()
    master, slave = nc
    commands.universal_start(master, 3, 0.0, 100.0)
    assert commands.couple(slave, 12, 1, 0, 0, 1.0, 0.5, 0.0, 0.0) == 0
    nc.cycle(3000)
    assert commands.change_coupling(slave, 0.0, 0.5, 0.0, 0.0) == 0
    nc.cycle(1000)
    assert (slave.set_velocity, slave.coupling_state, slave.motion_state) == (0.0, 3, 0)
    nc.cycle(3000)
    assert commands.change_coupling(slave, 1.0, 0.25, 0.0, 0.0) == 0
    nc.cycle(6000)
    assert slave.motion_state == RUNS
    assert abs(beside(slave.set_position, master.set_position)) < 1e-7
    assert commands.stop_slave(slave) == 0
    nc.cycle(1000)
    assert (slave.set_velocity, slave.coupling_state) == (0.0, 0)


@pytest.mark.parametrize(
    "parameters",
    [
        (2.0, 0.5, 0.0, 0.0),
        (0.0, 0.5, 0.0, 0.0),
        (1.0, 0.0, 0.0, 0.0),
        (1.0, 1.001, 0.0, 0.0),
        (1.0, 0.5, 0.0, 7.0),
        (1.0, float("nan"), 0.0, 0.0),
    ],
)
def test_other_parameters_are_refused(parameters: tuple[float, ...]) -> None:
    nc = station()
    slave = nc.axis(2)
    code = commands.couple(slave, 12, 1, 0, 0, *parameters)
    assert (code, slave.coupling.law) == (NcError.SLAVE_COUPLING_PARAMETER, 0)


def test_periods_have_to_be_the_same_and_a_second_master_has_to_be_there() -> None:
    nc = station(3)
    _master, slave, other = nc
    other.encoder.modulo_factor = 180.0
    code = commands.couple(slave, 12, 3, 0, 0, 1.0, 0.5, 0.0, 0.0)
    assert code == NcError.SLAVE_COUPLING_PARAMETER
    code = commands.couple(slave, 12, 1, 0, 0, 1.0, 0.5, 9.0, 0.0)
    assert code == NcError.ADDRESS_MASTER_AXIS
    assert commands.couple(slave, 12, 1, 0, 0, 1.0, 0.5, 0.0, 0.0) == 0
    code = commands.change_coupling(slave, 2.0, 0.5, 0.0, 0.0)
    assert code == NcError.SLAVE_COUPLING_PARAMETER


@pytest.mark.parametrize("seed", range(8))
def test_a_master_that_trembles_is_met_too(seed: int) -> None:
    """An encoder that trembles from cycle to cycle, beyond what the slave may follow; or rests."""
    dice = random.Random(seed)
    nc = station(2, compiled=dice.random() < 0.8)
    master, slave = dice.sample(list(nc), 2)
    master.axis_type, master.control_dword = 5, 0
    commands.set_actual_position(slave, 1, dice.uniform(-1000.0, 1000.0))
    speed = dice.choice((0.0, dice.uniform(-150.0, 150.0)))
    size = dice.choice((0.0, 10.0 ** dice.uniform(-4.0, -1.5)))
    start = dice.randint(1, 600)
    for n in range(8000):
        master.machine.position += 0.002 * speed + size * (n % 3 - 1)
        master.wake()
        nc.cycle()
        if n == start:
            share = dice.uniform(0.1, 1.0)
            assert commands.couple(slave, 12, master.axis_id, 0, 0, 1.0, share) == 0
    assert slave.motion_state == RUNS
    assert abs(beside(slave.set_position, master.actual_position)) < 1e-7


def test_a_phase_shift_moves_the_first_master_alone() -> None:
    nc = station(3)
    slave, first, second = nc
    assert commands.couple(slave, 12, 2, 0, 0, 1.0, 1.0, 3.0) == 0
    assert commands.start_phasing(slave, 1, 0, 0, 30.0, 100.0) == 0
    nc.cycle(3000)
    assert slave.motion_state == RUNS
    assert slave.set_position == pytest.approx(first.set_position + 30.0)
    assert commands.change_coupling(slave, 2.0, 1.0, 3.0, 0.0) == 0
    nc.cycle(3000)
    assert slave.motion_state == RUNS
    assert slave.set_position == pytest.approx(second.set_position)
