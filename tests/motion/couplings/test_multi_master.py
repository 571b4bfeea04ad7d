"""One to four masters, and what the dynamics of the coupling make of them."""

from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import AxisParameters, Nc, commands

ALL = 100


def run(nc: Nc, velocities: Any) -> None:
    for axis, velocity in zip(nc, velocities, strict=False):
        commands.universal_start(axis, 3 if velocity > 0 else 4, 0.0, abs(velocity))


def ratios(slave: Any, *values: float) -> None:
    for n, value in enumerate(values):
        setattr(slave, f"gear_ratio_{n + 1}", value)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("jerk", [0.0, 5e4])
def test_worked_numbers(make_axes: Any, compiled: bool, jerk: float) -> None:
    """g 1, 0.5, -1 and v 100, 40, 20: 100; from then on positions follow, too."""
    nc = make_axes(5, compiled=compiled)
    masters, slave = list(nc)[:3], nc.axis(5)
    assert commands.couple_to_several(slave, ALL, (1, 2, 3, 0), 500.0, 0.0, jerk) == 0
    ratios(slave, 1.0, 0.5, -1.0, 7.0)
    run(nc, (100.0, 40.0, 20.0))
    nc.cycle(2000)
    assert slave.set_velocity == 100.0
    begin = [axis.set_position for axis in (*masters, slave)]
    nc.cycle(100)
    ways = [axis.set_position - at for axis, at in zip((*masters, slave), begin, strict=True)]
    assert ways[3] == pytest.approx(ways[0] + 0.5 * ways[1] - ways[2], abs=1e-9)
    assert slave.coupling.ratios[:3] == pytest.approx([1.0, 0.5, -1.0])


def test_places_that_name_no_master(make_axes: Any) -> None:
    nc = make_axes(3)
    slave = nc.axis(3)
    assert commands.couple_to_several(slave, 15, (1, 0, 0, 2), 5000.0) == 0
    ratios(slave, 1.0, 50.0, 50.0, 2.0)
    run(nc, (10.0, 20.0))
    nc.cycle(500)
    assert slave.set_velocity == 50.0


def test_the_largest_velocity(make_axes: Any) -> None:
    nc = make_axes(2)
    slave = nc.axis(2)
    commands.couple_to_several(slave, 17, (1, 0, 0, 0), 5000.0, 0.0, 0.0, 60.0)
    ratios(slave, 1.0)
    run(nc, (100.0,))
    nc.cycle(500)
    assert slave.set_velocity == 60.0
    assert commands.change_coupling(slave, 0.5, 0.0, 0.0, 0.0) == 0
    nc.cycle(500)
    assert (slave.set_velocity, slave.gear_ratio_1) == (50.0, 0.5)


def test_a_moving_slave_goes_over(make_axes: Any) -> None:
    nc = make_axes(2)
    slave = nc.axis(2)
    run(nc, (100.0, 50.0))
    nc.cycle(500)
    before = slave.set_position
    ratios(slave, 1.0)
    assert commands.couple_to_several(slave, ALL, (1, 0, 0, 0), 100.0) == 0
    nc.cycle()
    assert slave.set_position - before == pytest.approx(50.0 * 0.002 + 0.5 * 100.0 * 0.002**2)
    nc.cycle(249)
    assert slave.set_velocity == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((1, (1, 0, 0, 0), 1.0), NcError.SLAVE_TYPE),
        ((100, (0, 1, 0, 0), 1.0), NcError.SLAVE_COUPLING_PARAMETER),
        ((100, (1, 1, 0, 0), 1.0), NcError.SLAVE_COUPLING_PARAMETER),
        ((100, (1, 9, 0, 0), 1.0), NcError.ADDRESS_MASTER_AXIS),
        ((100, (1, 2, 0, 0), 1.0), NcError.MASTER_NOT_INSERTED),
        ((100, (1, 0, 0, 0), -1.0), NcError.SLAVE_COUPLING_PARAMETER),
        ((100, (1, 0, 0, 0), 1e9), NcError.ACCELERATION_NOT_PERMITTED),
        ((100, (1, 0, 0, 0), 1.0, 0.0, float("inf")), NcError.SLAVE_COUPLING_PARAMETER),
    ],
)
def test_what_is_refused(make_axes: Any, arguments: Any, error: NcError) -> None:
    nc = make_axes(2)
    before = nc.digest()
    slave = nc.axis(2)
    assert commands.couple_to_several(slave, *arguments) == error
    assert nc.digest() == before


VELOCITY = st.floats(-200.0, 200.0).filter(lambda v: abs(v) > 1.0)


@settings(max_examples=25, deadline=None)
@example(10.0, 10.0, 1000.0, 0.0, [([2.0, 2.0, -1.9375], [0.0, 1.0, 1.0], 15)])
@given(
    acceleration=st.floats(10.0, 1e4),
    deceleration=st.floats(10.0, 1e4),
    jerk=st.one_of(st.just(0.0), st.floats(1e3, 1e6)),
    most=st.one_of(st.just(0.0), st.floats(10.0, 500.0)),
    steps=st.lists(
        st.tuples(st.lists(VELOCITY, min_size=3, max_size=3),
                  st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
                  st.integers(1, 300)),
        min_size=1, max_size=4,
    ),
)  # fmt: skip
def test_limits_hold_and_in_gear_positions_follow(
    acceleration: float, deceleration: float, jerk: float, most: float, steps: Any
) -> None:
    values = {
        "control_dword": 7,
        "velocity_override": 1_000_000,
        "max_velocity": 1e9,
        "controller_following_error_position_monitoring_enable": 0,
    }
    nc = Nc(2_000_000, [AxisParameters(n, values=values) for n in range(1, 5)])
    nc.cycle(3)
    masters, slave = list(nc)[:3], nc.axis(4)
    dt = 0.002
    assert (
        commands.couple_to_several(slave, ALL, (1, 2, 3, 0), acceleration, deceleration, jerk, most)
        == 0
    )
    for velocities, requested, cycles in steps:
        run(nc, velocities)
        ratios(slave, *requested)
        for turn in range(cycles):
            p, v, a, geared = (
                slave.set_position,
                slave.set_velocity,
                slave.set_acceleration,
                slave.coupling.in_gear,
            )
            at = [axis.set_position for axis in masters]
            nc.cycle()
            limit = max(acceleration, deceleration)
            assert abs(slave.set_velocity - v) <= limit * dt * (1 + 1e-5) + 1e-9
            if jerk and not (geared and slave.coupling.in_gear):
                assert abs(slave.set_acceleration - a) <= jerk * dt * (1 + 1e-6) + 1e-6
            assert abs(slave.set_position - p - 0.5 * (v + slave.set_velocity) * dt) <= (
                limit * dt * dt + 1e-9
            )
            if most:
                assert abs(slave.set_velocity) <= most * (1 + 1e-9) or slave.set_acceleration
            if turn and geared and slave.coupling.in_gear:
                way = sum(
                    g * (axis.set_position - m)
                    for g, axis, m in zip(requested, masters, at, strict=True)
                )
                # out of gear and in again within a cycle: its way is that of its own ramp
                bent = abs(slave.set_velocity - v) * dt
                assert slave.set_position - p == pytest.approx(way, abs=1e-9 + bent)
