"""The origin of positions and the homed flag."""

from math import nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import AxisParameters, Nc, StateBit, commands

V = 200.0


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


@pytest.mark.parametrize(
    ("kind", "value", "before", "after"),
    [(1, 50.0, 10.0, 50.0), (2, 5.0, 10.0, 15.0), (5, 20.0, 730.0, 740.0)],
)
def test_set_actual_position(
    rig: Any, kind: int, value: float, before: float, after: float
) -> None:
    commands.start(rig.axis, 1, before, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert commands.set_actual_position(rig.axis, kind, value) == 0
    rig.run(50)
    assert rig.axis.actual_position == pytest.approx(after, abs=1e-9)
    assert rig.axis.set_position == pytest.approx(after, abs=1e-9)
    assert rig.axis.actual_velocity == 0.0
    assert rig.has(StateBit.IN_TARGET_POSITION)
    commands.start(rig.axis, 1, 0.0, V)
    rig.until_rest()
    assert rig.axis.set_position == 0.0


def test_positions_set_within_one_cycle_count_from_each_other(rig: Any) -> None:
    commands.start(rig.axis, 1, 730.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    for modulo in (20.0, 350.0, 60.0):
        assert commands.set_actual_position(rig.axis, 5, modulo) == 0
        assert rig.axis.actual_position == pytest.approx(720.0 + modulo)


def test_actual_positions_that_cannot_be_set(make_rig: Any) -> None:
    rig = make_rig()
    out_of_range = NcError.ENCODER_SET_POSITION_RANGE
    rig.refuses(out_of_range, commands.set_actual_position, 1, 1e11)
    rig.refuses(out_of_range, commands.set_actual_position, 1, nan)
    rig.refuses(NcError.JOB_START_TYPE, commands.set_actual_position, 3, 1.0)
    absolute = make_rig(encoder_is_absolute=1)
    code = commands.set_actual_position(absolute.axis, 1, 1.0)
    refused(absolute, code, NcError.FUNCTION_NOT_ALLOWED)


def test_the_homed_flag(rig: Any) -> None:
    assert commands.set_homed_flag(rig.axis, 1) == 0
    rig.run(1)
    assert rig.has(StateBit.HOMED)
    rig.refuses(NcError.ENCODER_HOMED_FLAG, commands.set_homed_flag, 2)


CYCLE = 0.002


@pytest.fixture(params=[False, True], ids=["plain", "compiled"])
def make(request: pytest.FixtureRequest, make_rig: Any) -> Any:
    return lambda **values: make_rig(compiled=request.param, **values)


def machine(axis: Any) -> float:
    """Where the motor stands, whatever positions are called."""
    return float(axis.machine.position)


@pytest.mark.parametrize(("kind", "value"), [(1, 500.0), (2, 400.0)])
def test_on_the_fly_the_motion_goes_on_undisturbed(make: Any, kind: int, value: float) -> None:
    """An equal axis without the change is the reference; the positions alone differ."""
    rig, reference = make(), make()
    for each in (rig, reference):
        commands.start(each.axis, 1, 200.0, 100.0)
        each.seconds(1.0)
    shift = value if kind == 2 else value - rig.axis.actual_position
    assert commands.set_actual_position_on_the_fly(rig.axis, kind, 0, value) == 0
    assert rig.axis.set_position - shift == pytest.approx(reference.axis.set_position)
    for _ in range(1500):
        rig.run(1)
        reference.run(1)
        a, b = rig.axis, reference.axis
        assert a.set_position - shift == pytest.approx(b.set_position, abs=1e-9)
        assert (a.set_velocity, a.set_acceleration) == (b.set_velocity, b.set_acceleration)
        assert a.actual_velocity == pytest.approx(b.actual_velocity, abs=1e-6)
        assert machine(a) == pytest.approx(machine(b), abs=1e-9)
    assert rig.axis.set_position == pytest.approx(200.0 + shift, abs=1e-9)
    assert rig.axis.error_code == 0


def test_on_the_fly_what_waits_goes_on_undisturbed(rig: Any, make_rig: Any) -> None:
    other = make_rig()
    for chain in (rig, other):
        for target, blending in ((100.0, None), (200.0, 90.0), (150.0, None)):
            mode = 20 if target > 150.0 else 1
            code = commands.universal_start(chain.axis, 1, target, V, 0.0, 0.0, 0.0, mode, blending)
            assert code == 0
        chain.seconds(0.3)
    commands.set_actual_position_on_the_fly(rig.axis, 2, 0, 1000.0)
    for _ in range(1500):
        rig.run(1)
        other.run(1)
        assert rig.axis.set_velocity == pytest.approx(other.axis.set_velocity, abs=1e-3)
    assert rig.axis.set_position == pytest.approx(1150.0)
    assert other.axis.set_position == pytest.approx(150.0)


def test_on_the_fly_the_following_error_stays_unless_it_is_cleared(make_rig: Any) -> None:
    rig = make_rig(controller_velocity_feedforward_weight=0.5)
    commands.start(rig.axis, 3, 0.0, 50.0)
    rig.seconds(2.0)
    error = rig.axis.following_error
    assert error == pytest.approx(0.5 * 50.0 / 20.0, rel=0.05)
    commands.set_actual_position_on_the_fly(rig.axis, 1, 0, 0.0)
    assert rig.axis.set_position - rig.axis.actual_position == pytest.approx(error, abs=0.01)
    commands.set_actual_position_on_the_fly(rig.axis, 1, 1, 0.0)
    assert rig.axis.set_position == rig.axis.actual_position == pytest.approx(0.0, abs=1e-9)


def test_positions_that_cannot_be_set_on_the_fly(make_rig: Any) -> None:
    rig = make_rig()
    function = commands.set_actual_position_on_the_fly
    rig.refuses(NcError.JOB_START_TYPE, function, 5, 0, 1.0)
    rig.refuses(NcError.ENCODER_SET_POSITION_RANGE, function, 1, 0, nan)
    absolute = make_rig(encoder_is_absolute=1)
    absolute.refuses(NcError.FUNCTION_NOT_ALLOWED, function, 1, 0, 1.0)
    absolute.refuses(NcError.FUNCTION_NOT_ALLOWED, commands.set_actual_position_only, 1, 1.0)


def test_only_the_actual_position_makes_a_following_error_that_is_worked_off(make: Any) -> None:
    """A P controller works an error off exponentially: after t it is e to the -Kv t of it."""
    rig = make(simulation_time_constant=0.0)
    rig.seconds(0.1)
    assert commands.set_actual_position_only(rig.axis, 1, 1.0) == 0
    assert (rig.axis.actual_position, rig.axis.set_position) == (1.0, 0.0)
    rig.run(1)
    assert rig.axis.following_error == pytest.approx(-1.0, abs=1e-4)
    kv = rig.axis.controller.position_kv
    rig.seconds(0.1)
    assert rig.axis.following_error == pytest.approx(-((1 - kv * CYCLE) ** 50), abs=1e-3)
    rig.seconds(1.0)
    assert rig.axis.actual_position == pytest.approx(0.0, abs=2e-4)
    assert machine(rig.axis) == pytest.approx(-1.0, abs=2e-4)


def test_only_the_actual_position_in_motion(make: Any) -> None:
    rig = make()
    commands.start(rig.axis, 1, 100.0, 50.0)
    rig.seconds(1.0)
    set_position = rig.axis.set_position
    assert commands.set_actual_position_only(rig.axis, 2, 0.5) == 0
    assert rig.axis.set_position == set_position
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.set_position == 100.0
    assert rig.axis.actual_position == pytest.approx(100.0, abs=1e-3)
    assert machine(rig.axis) == pytest.approx(99.5, abs=1e-3)


CANOPEN = {"drive_type": 16, "controller_type": 9}


def test_a_drive_that_counts_from_another_number(make: Any) -> None:
    rig = make(**CANOPEN)
    commands.start(rig.axis, 1, 10.0, 50.0)
    rig.until_rest()
    rig.seconds(1.0)
    assert commands.set_actual_position_in_drive(rig.axis, 1, 250.0) == 0
    rig.run(5)
    axis = rig.axis
    assert axis.actual_position == axis.set_position == pytest.approx(250.0, abs=1e-4)
    assert axis.encoder.set_position_offset == pytest.approx(0.0, abs=1e-9)
    assert axis.encoder.hardware_increments == 2_500_000
    assert axis.actual_velocity == 0.0
    commands.start(axis, 2, -10.0, 50.0)
    rig.until_rest()
    rig.seconds(0.1)
    assert axis.encoder.hardware_increments == 2_400_000
    commands.activate_touch_probe(axis, 1, 0, 1, 128)
    commands.start(axis, 2, 7.0, 50.0)
    rig.until_rest()
    index = 240.0 + axis.simulation_turn * 1e-4  # the motor has not moved by counting otherwise
    assert axis.encoder.probe_position[0] == pytest.approx(index, abs=1e-9)


def test_what_forbids_it(make_rig: Any) -> None:
    function = commands.set_actual_position_in_drive
    make_rig().refuses(NcError.FUNCTION_NOT_AVAILABLE, function, 1, 1.0)
    make_rig(drive_type=16).refuses(NcError.FUNCTION_NOT_AVAILABLE, function, 1, 1.0)
    make_rig(**CANOPEN, encoder_position_offset=1.0).refuses(
        NcError.ENCODER_POSITION_OFFSET, function, 1, 1.0
    )
    rig = make_rig(**CANOPEN)
    rig.refuses(NcError.JOB_START_TYPE, function, 0, 1.0)
    commands.start(rig.axis, 1, 10.0, 50.0)
    rig.refuses(NcError.GROUP_BUSY, function, 1, 1.0)


def test_an_absolute_scaling_means_other_positions(make: Any) -> None:
    rig = make(encoder_position_offset=5.0)
    commands.start(rig.axis, 1, 15.0, 50.0)
    rig.until_rest()
    rig.seconds(1.0)
    count = rig.axis.encoder.software_increments
    assert count == pytest.approx(100_000, abs=2)
    assert commands.set_encoder_scaling_factor(rig.axis, 1, 0, 3e-4) == 0
    rig.run(3)
    axis = rig.axis
    assert axis.actual_position == pytest.approx(5.0 + 3e-4 * count)
    assert axis.set_position == pytest.approx(15.0 + 2e-4 * count)
    assert axis.actual_velocity == 0.0
    assert axis.encoder.set_position_offset == 0.0
    assert (axis.encoder.scaling_numerator, axis.encoder.scaling_denominator) == (3e-4, 1.0)


def test_a_relative_scaling_leaves_the_position_alone_in_motion(make: Any) -> None:
    rig = make()
    commands.start(rig.axis, 1, 100.0, 50.0)
    rig.seconds(1.0)
    here, count = rig.axis.actual_position, rig.axis.encoder.software_increments
    assert commands.set_encoder_scaling_factor(rig.axis, 2, 0, 1.01e-4) == 0
    rig.run(1)
    assert rig.axis.actual_position == pytest.approx(here + 50.0 * CYCLE, abs=0.005)
    rig.until_rest()
    rig.seconds(1.0)
    axis = rig.axis
    assert axis.actual_position == pytest.approx(100.0, abs=1e-3)
    way = (axis.encoder.software_increments - count) * 1.01e-4
    assert way == pytest.approx(100.0 - here, abs=1e-3)


def test_scalings_that_cannot_be(rig: Any) -> None:
    function = commands.set_encoder_scaling_factor
    rig.refuses(NcError.JOB_START_TYPE, function, 0, 0, 1e-4)
    for factor in (0.99e-8, 100.1, nan):
        rig.refuses(NcError.ENCODER_SCALING_FACTOR, function, 2, 0, factor)
    commands.start(rig.axis, 1, 10.0, 50.0)
    rig.refuses(NcError.GROUP_BUSY, function, 1, 0, 1e-4)


def test_a_reinitialised_encoder_knows_the_hardware_alone(make: Any) -> None:
    rig = make(encoder_position_offset=2.0)
    commands.start(rig.axis, 1, 12.0, 50.0)
    rig.until_rest()
    rig.seconds(1.0)
    commands.set_actual_position(rig.axis, 1, 700.0)
    commands.set_homed_flag(rig.axis, 1)
    rig.refuses(NcError.FUNCTION_NOT_ALLOWED, commands.reinitialize_encoder)
    rig.axis.control_dword = 0
    rig.run(2)
    assert rig.axis.initialize_command_counter == 0
    assert commands.reinitialize_encoder(rig.axis) == 0
    assert rig.axis.initialize_command_counter == 1
    assert rig.axis.encoder.reinitialization_state == 1
    rig.run(2)
    axis = rig.axis
    assert axis.encoder.reinitialization_state == 0
    assert axis.actual_position == axis.set_position == pytest.approx(12.0, abs=1e-3)
    assert axis.actual_velocity == 0.0
    assert axis.homed == 0


def test_overflows_counted_before_are_lost(make: Any) -> None:
    rig = make(encoder_mask=0xFFFF, encoder_reference_system=2, encoder_is_absolute=1)
    commands.start(rig.axis, 1, 100.0, 200.0)
    rig.until_rest()
    rig.seconds(1.0)
    axis = rig.axis
    assert axis.encoder.software_increments == pytest.approx(1_000_000, abs=3)
    axis.control_dword, axis.homed = 0, 1
    rig.run(2)
    assert commands.reinitialize_actual_position(axis) == 0
    rig.run(2)
    assert axis.encoder.software_increments == pytest.approx(1_000_000 % 65_536, abs=3)
    assert axis.actual_position == pytest.approx(1_000_000 % 65_536 * 1e-4, abs=1e-3)
    assert axis.homed == 1
    axis.control_dword = 7
    rig.run(5)
    commands.start(axis, 2, 10.0, 50.0)
    rig.until_rest()
    rig.seconds(0.5)
    assert axis.actual_position == pytest.approx(10.0 + 1_000_000 % 65_536 * 1e-4, abs=1e-3)


def test_an_incremental_position_stays(rig: Any) -> None:
    commands.set_actual_position(rig.axis, 1, 9.0)
    assert commands.reinitialize_actual_position(rig.axis) == 0
    rig.run(2)
    assert rig.axis.actual_position == 9.0


def test_a_further_encoder_has_its_own_position() -> None:
    values = {"control_dword": 7, "velocity_override": 1_000_000}
    nc = Nc(2_000_000, [AxisParameters(1, values=values, encoder_ids=(1, 2))])
    axis, second = nc.axis(1), nc.element("encoder", 2)
    for _ in range(3):
        nc.cycle()
    commands.start(axis, 1, 10.0, 50.0)
    for _ in range(50):
        nc.cycle()
    assert commands.set_actual_position(second, 1, 80.0) == 0
    assert commands.set_homed_flag(second, 1) == 0
    here = axis.actual_position
    for _ in range(1500):
        nc.cycle()
    assert axis.actual_position == pytest.approx(10.0, abs=1e-3)
    assert second.actual_position == pytest.approx(80.0 + 10.0 - here, abs=0.11)
    assert (axis.homed, second.homed) == (0, 1)
