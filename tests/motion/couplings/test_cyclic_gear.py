"""Slave type 15: the ratio of the PLC, its ramp, and the way by the mean ratio."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import AxisParameters, Nc, commands

ENDLESS = 3
VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "controller_following_error_position_monitoring_enable": 0,
}


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("cycle_ns", [1_000_000, 2_000_000, 700_000])
@pytest.mark.parametrize("source", ["operation_mode_value", "gear_ratio_1"])
def test_worked_numbers(make_axes: Any, compiled: bool, cycle_ns: int, source: str) -> None:
    """p_a = 2/s, g: 0 → 1, vM = 100: after 0.5 s g = 1 and s = 25, whatever the cycle time."""
    nc = make_axes(compiled=compiled, cycle_ns=cycle_ns)
    master, slave = nc
    assert commands.couple(slave, 15, 1, 0, 0, 2.0) == 0
    commands.universal_start(master, ENDLESS, 0.0, 100.0)
    nc.cycle(2000)
    assert (slave.set_position, slave.set_velocity) == (0.0, 0.0)
    begin = master.set_position
    setattr(slave, source, 1.0)
    nc.cycle(10)
    assert slave.set_acceleration == pytest.approx(200.0)
    nc.cycle(1000)
    assert slave.set_gear_ratio == 1.0
    assert master.set_position - begin - slave.set_position == pytest.approx(25.0, abs=1e-9)
    assert (slave.set_velocity, slave.set_acceleration) == (100.0, 0.0)


def test_it_couples_to_a_moving_master(make_axes: Any) -> None:
    nc = make_axes()
    master, slave = nc
    commands.universal_start(master, ENDLESS, 0.0, 100.0)
    nc.cycle(500)
    slave.operation_mode_value = 1.0
    assert commands.couple(slave, 1, 1, 0, 0, 1.0) == NcError.COUPLING_DURING_JOB
    assert commands.couple(slave, 15, 1, 0, 0, 2.0) == 0
    nc.cycle()
    assert slave.set_velocity == pytest.approx(0.4)


def test_the_limit_changes_while_it_runs(make_axes: Any) -> None:
    nc = make_axes()
    _master, slave = nc
    commands.couple(slave, 15, 1, 0, 0, 2.0)
    slave.operation_mode_value = 10.0
    nc.cycle(100)
    assert slave.coupling.gear == pytest.approx(0.4)
    assert commands.change_coupling(slave, 20.0, 0.0, 0.0, 0.0) == 0
    nc.cycle(100)
    assert slave.coupling.gear == pytest.approx(4.4)


@pytest.mark.parametrize("p_a", [0.0, -1.0, 1e7, float("nan")])
def test_wrong_limits(make_axes: Any, p_a: float) -> None:
    _master, slave = make_axes()
    assert commands.couple(slave, 15, 1, 0, 0, p_a) == NcError.SLAVE_COUPLING_PARAMETER


@pytest.mark.parametrize("ratio", [float("nan"), float("inf"), -2e6])
def test_a_ratio_that_is_none_changes_nothing(make_axes: Any, ratio: float) -> None:
    nc = make_axes()
    _master, slave = nc
    commands.couple(slave, 15, 1, 0, 0, 1000.0)
    slave.operation_mode_value = 0.5
    nc.cycle(10)
    slave.operation_mode_value = ratio
    nc.cycle(10)
    assert (slave.coupling.gear, slave.error_code) == (0.5, 0)


@settings(max_examples=25, deadline=None)
@given(
    p_a=st.floats(0.1, 1e4),
    steps=st.lists(
        st.tuples(st.floats(-20.0, 20.0), st.floats(-300.0, 300.0), st.integers(1, 200)),
        min_size=1,
        max_size=6,
    ),
    cycle_ns=st.sampled_from([250_000, 1_000_000, 2_000_000, 10_000_000]),
)
def test_any_ratios(p_a: float, steps: Any, cycle_ns: int) -> None:
    """The way is the sum of the mean ratios, and the ratio changes as fast as its limit says."""
    values = VALUES | {"max_velocity": 1e9}
    nc = Nc(cycle_ns, [AxisParameters(n, values=values) for n in (1, 2)])
    nc.cycle(3)
    master, slave = nc
    commands.couple(slave, 15, 1, 0, 0, p_a)
    dt = cycle_ns * 1e-9
    s, g = slave.set_position, 0.0
    for goal, velocity, cycles in steps:
        slave.operation_mode_value = goal or 1.0
        if velocity:
            commands.universal_start(master, 3 if velocity > 0 else 4, 0.0, abs(velocity) + 1.0)
        for _ in range(cycles):
            before, at = g, master.set_position
            nc.cycle()
            wanted = slave.operation_mode_value
            g += max(-p_a * dt, min(p_a * dt, wanted - g))
            share = min(1.0, abs(wanted - before) / (p_a * dt))
            s += (0.5 * (before + g) * share + g * (1 - share)) * (master.set_position - at)
            assert slave.set_position == pytest.approx(s, rel=1e-9, abs=1e-9)
            assert slave.coupling.gear == pytest.approx(g, rel=1e-9, abs=1e-12)
            assert slave.set_velocity == slave.coupling.gear * master.set_velocity
