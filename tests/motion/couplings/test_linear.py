"""Slave type 1: the slave keeps s = s0 + g · (M - M0), whatever its master does."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import AxisParameters, Nc, commands
from achse.motion.checks import check_permitted
from achse.motion.states import SlaveType
from tests.motion.enabled_axes import QUICK, enabled_axes


def place(nc: Nc, axis_id: int, position: float) -> None:
    """Bring an axis there."""
    assert commands.start(nc.axis(axis_id), 1, position, 1000.0) == 0
    nc.cycle(2000)
    assert nc.axis(axis_id).set_position == position


@pytest.mark.parametrize("compiled", [False, True])
def test_worked_numbers(compiled: bool) -> None:
    """M0 = 100, s0 = 7, g = -0.25, M = 140, vM = 80: s = -3, v = -20."""
    nc = enabled_axes(compiled=compiled)
    master, slave = nc
    place(nc, 1, 100.0)
    place(nc, 2, 7.0)
    assert commands.couple(slave, 1, 1, 0, 0, -0.25) == 0
    assert (slave.coupling_state, master.coupling_state) == (3, 1)
    commands.universal_start(master, 1, 1000.0, 80.0)
    while master.set_position < 140.0:
        nc.cycle()
    assert slave.set_position == 7.0 - 0.25 * (master.set_position - 100.0)
    assert (master.set_velocity, slave.set_velocity) == (80.0, -20.0)
    commands.universal_start(master, 1, 140.0, 80.0)
    nc.cycle(2000)
    assert (master.set_position, slave.set_position) == (140.0, -3.0)


def test_a_new_ratio_acts_at_once() -> None:
    """g 1 → 2 at M = 50, s = 50: M = 60 → s = 70."""
    nc = enabled_axes()
    _master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    place(nc, 1, 50.0)
    assert commands.change_coupling(slave, 2.0, 0.0, 0.0, 0.0) == 0
    place(nc, 1, 60.0)
    assert slave.set_position == 70.0


def test_a_new_ratio_in_motion_loses_no_way() -> None:
    nc = enabled_axes()
    master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    here, there = slave.set_position, master.set_position
    assert commands.change_coupling(slave, 2.0, 0.0, 0.0, 0.0) == 0
    nc.cycle()
    assert slave.set_position == here + 2.0 * (master.set_position - there)
    assert slave.set_velocity == 200.0


def test_a_phase_shift_acts() -> None:
    nc = enabled_axes()
    _master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 2.0)
    assert commands.start_phasing(slave, 2, 0, 1, 10.0, 100.0, 1000.0, 1000.0, 10000.0) == 0
    nc.cycle(1000)
    assert slave.set_position == 20.0
    assert slave.phasing_position == 10.0


def test_renamed_positions_do_not_move_the_slave() -> None:
    nc = enabled_axes()
    master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    place(nc, 1, 50.0)
    assert commands.set_actual_position(master, 1, 500.0) == 0
    nc.cycle(10)
    assert slave.set_position == 50.0
    place(nc, 1, 510.0)
    assert slave.set_position == pytest.approx(60.0, abs=1e-9)
    assert commands.set_actual_position(slave, 1, 0.0) == 0
    place(nc, 1, 520.0)
    assert slave.set_position == pytest.approx(10.0, abs=1e-9)


def test_without_its_enable_a_slave_waits_and_does_not_jump() -> None:
    nc = enabled_axes()
    master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    master.velocity_override = 0
    assert commands.start(master, 1, 50.0, 1000.0) == 0
    nc.cycle(5)
    slave.control_dword = 0
    nc.cycle(5)
    assert (slave.error_code, slave.coupling_state, slave.loop_closed) == (0, 3, 0)
    master.velocity_override = 1_000_000
    nc.cycle(2000)
    assert master.set_position == 50.0
    slave.control_dword = 7
    nc.cycle(5)
    assert slave.set_position == pytest.approx(0.0, abs=1e-3)
    place(nc, 1, 60.0)
    assert slave.set_position == pytest.approx(10.0, abs=1e-3)


@pytest.mark.parametrize("kind", [1, 2, 3, 8192])
def test_a_master_does_not_start_while_a_slave_has_no_enable(kind: int) -> None:
    """Nor one whose slave's slave has none; enabled in motion, it would jump to the velocity."""
    nc = enabled_axes(3)
    master, middle, last = nc
    assert commands.couple(middle, 1, 1, 0, 0, 1.0) == commands.couple(last, 1, 2, 0, 0, -2.0) == 0
    for slave in (middle, last):
        slave.control_dword = 6
        refused = 0 if kind == 8192 else NcError.SLAVE_ENABLE_MISSING
        assert commands.universal_start(master, kind, 10.0, 100.0) == refused
        slave.control_dword = 7
        nc.cycle(5)
    assert commands.start(master, 1, 10.0, 100.0) == 0
    nc.cycle(2000)
    assert [axis.set_position for axis in nc] == pytest.approx([10.0, 10.0, -20.0], abs=1e-3)


@pytest.mark.parametrize("without", [None, 1, 40])
def test_slaves_of_several_masters_each_are_looked_at_once(without: int | None) -> None:
    """40 axes that follow the two before them have 10^8 ways from the first to the last."""
    nc = enabled_axes(41)
    axes = list(nc)
    for n, slave in enumerate(axes[1:], 1):
        slave.follow(SlaveType.LINEAR, axes[max(n - 2, 0) : n])
    if without is not None:
        axes[without].control_dword = 6
    refused = 0 if without is None else NcError.SLAVE_ENABLE_MISSING
    assert check_permitted(axes[0], 1.0) == refused


def test_a_slave_that_loses_its_enable_in_motion_brakes_alone() -> None:
    nc = enabled_axes()
    master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(1000)
    slave.control_dword = 6
    nc.cycle(2000)
    assert slave.error_code == 0x4260
    assert (slave.set_velocity, slave.coupling_state, master.coupling_state) == (0.0, 0, 0)
    assert master.set_velocity == 100.0


def test_a_soft_limit_of_the_slave_holds() -> None:
    nc = enabled_axes()
    master, slave = nc
    slave.encoder.soft_limit_max, slave.encoder.soft_limit_max_enable = 100.0, 1
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    commands.universal_start(master, 3, 0.0, 100.0)
    nc.cycle(3000)
    assert slave.error_code == NcError.SOFT_LIMIT_MAX_PASSED
    assert 95.0 < slave.set_position <= 100.0 + 1e-6
    assert slave.set_velocity == 0.0


def test_a_master_that_is_not_ready_does_not_pull() -> None:
    nc = enabled_axes()
    master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 1.0)
    master.control_dword = 0
    nc.cycle(5)
    master.machine.position += 5.0
    master.wake()
    nc.cycle(5)
    assert slave.set_position == 0.0
    master.control_dword = 7
    nc.cycle(50)
    assert slave.set_position == 0.0


STEP = st.tuples(
    st.sampled_from(["start", "stop", "override", "endless", "back"]),
    st.floats(1.0, 300.0),
    st.floats(0.0, 1.0),
    st.integers(1, 300),
)


@settings(max_examples=10, deadline=None)
@given(
    gears=st.lists(st.floats(-20.0, 20.0).filter(lambda g: abs(g) > 1e-3), min_size=1, max_size=4),
    steps=st.lists(STEP, min_size=1, max_size=6),
    begin=st.floats(-500.0, 500.0),
)
def test_slaves_of_slaves_keep_their_law(
    gears: list[float], steps: list[Any], begin: float
) -> None:
    nc = enabled_axes(len(gears) + 1, max_velocity=1e9)
    axes = list(nc)
    for n, gear in enumerate(gears):
        axes[n + 1].drive.reference_velocity = 1e9
        commands.set_actual_position(axes[n + 1], 1, begin)
        nc.cycle()
        assert commands.couple(axes[n + 1], 1, n + 1, 0, 0, gear) == 0
    bases = [axis.set_position for axis in axes]
    master = axes[0]
    for kind, size, share, cycles in steps:
        match kind:
            case "start":
                commands.universal_start(master, 2, size * (2 * share - 1), size)
            case "endless":
                commands.universal_start(master, 3, 0.0, size)
            case "back":
                commands.universal_start(master, 4, 0.0, size)
            case "stop":
                commands.parameterized_stop(master, 100.0 * size, 1000.0 * size)
            case "override":
                master.velocity_override = int(1e6 * share)
        for _ in range(cycles):
            nc.cycle()
            for n, gear in enumerate(gears):
                law = bases[n + 1] + gear * (axes[n].set_position - bases[n])
                assert axes[n + 1].set_position == pytest.approx(law, rel=1e-12, abs=1e-9)
                assert axes[n + 1].set_velocity == gear * axes[n].set_velocity


@pytest.mark.parametrize("gear", [1.0, -3.7])
def test_both_kernels_do_the_same(gear: float) -> None:
    digests = []
    for compiled in (False, True):
        nc = enabled_axes(3, compiled=compiled)
        commands.couple(nc.axis(2), 1, 1, 0, 0, gear)
        commands.couple(nc.axis(3), 1, 2, 0, 0, 0.3)
        commands.universal_start(nc.axis(1), 1, 50.0, 100.0)
        nc.cycle(200)
        commands.decouple(nc.axis(2))
        nc.cycle(200)
        nc.axis(1).control_dword = 6
        nc.cycle(200)
        digests.append(nc.digest())
    assert digests[0] == digests[1]


@given(
    ratio=st.floats(-50.0, 50.0).filter(bool),
    other=st.floats(-50.0, 50.0).filter(bool),
    velocity=st.floats(1.0, 900.0),
    most=st.floats(1.0, 2000.0),
    room=st.floats(1.0, 1e4),
    soft=st.sampled_from([0, 1]),
    cycles=st.integers(1, 300),
)
@settings(max_examples=60)
def test_a_new_ratio_never_makes_a_slave_too_fast(
    ratio: float, other: float, velocity: float, most: float, room: float, soft: int, cycles: int
) -> None:
    """It is refused and changes nothing, or the next cycle is not farther than both allow."""
    limits = {"encoder_soft_limit_max": room, "encoder_soft_limit_min": -room}
    enabled = {"encoder_soft_limit_max_enable": soft, "encoder_soft_limit_min_enable": soft}
    slave_values = QUICK | limits | enabled | {"max_velocity": most}
    parameters = [AxisParameters(1, values=QUICK), AxisParameters(2, values=slave_values)]
    nc = Nc(2_000_000, parameters, compiled=False)
    nc.cycle(3)
    master, slave = nc
    assert commands.couple(slave, 1, 1, 0, 0, ratio) == 0
    commands.universal_start(master, 3, 0.0, velocity)
    nc.cycle(cycles)
    if slave.error_code:
        return
    before, place = slave.set_velocity, slave.set_position
    code = commands.change_coupling(slave, other, 0.0, 0.0, 0.0)
    nc.cycle()
    way = abs(slave.set_position - place)
    in_force = other if code == 0 else ratio
    assert slave.set_gear_ratio == in_force
    if code == 0:
        accelerated = abs(other) * 5e3 * 0.002  # of the master, within the cycle
        assert way <= (max(most, abs(before)) + accelerated) * 0.002 + 1e-6
    else:
        assert code in (NcError.SLAVE_COUPLING_PARAMETER, NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS)


def test_a_ratio_that_the_slave_cannot_follow_is_refused() -> None:
    nc = enabled_axes(
        max_velocity=500.0, encoder_soft_limit_max=2e3, encoder_soft_limit_max_enable=1
    )
    master, slave = nc
    commands.couple(slave, 1, 1, 0, 0, 0.5)
    commands.universal_start(master, 3, 0.0, 200.0)
    nc.cycle(2000)
    code = commands.change_coupling(slave, 50.0, 0.0, 0.0, 0.0)
    assert code == NcError.SLAVE_COUPLING_PARAMETER
    nc.cycle()
    assert slave.set_velocity == 100.0
    assert commands.change_coupling(slave, 2.5, 0.0, 0.0, 0.0) == 0
    while slave.set_position < 1960.0:
        nc.cycle()
    assert commands.change_coupling(slave, 0.5, 0.0, 0.0, 0.0) == 0
    while slave.set_position < 1995.0:
        nc.cycle()
    code = commands.change_coupling(slave, 2.5, 0.0, 0.0, 0.0)
    assert code == NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS
