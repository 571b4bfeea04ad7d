"""Commands: each refusal has its documented code and changes nothing."""

from math import inf, nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import BufferMode, CommandState, StartType, StateBit, commands
from achse.motion.record import COMMAND_BUFFER

V = 200.0


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


@pytest.mark.parametrize(
    ("control", "target", "error"),
    [
        (0b000, 10.0, NcError.CONTROLLER_ENABLE_MISSING),
        (0b110, 10.0, NcError.CONTROLLER_ENABLE_MISSING),
        (0b101, 10.0, NcError.ENABLE_MISSING),
        (0b011, -10.0, NcError.ENABLE_MISSING),
    ],
)
def test_enables_are_needed(make_rig: Any, control: int, target: float, error: NcError) -> None:
    rig = make_rig(control_dword=control)
    before = rig.nc.digest()
    rig.refuses(error, commands.start, StartType.ABSOLUTE, target, V)
    rig.refuses(error, commands.universal_start, StartType.ABSOLUTE, target, V)
    assert rig.nc.digest() == before


def test_one_feed_enable_is_enough_for_its_direction(make_rig: Any) -> None:
    assert commands.start(make_rig(control_dword=0b011).axis, 1, 10.0, V) == 0
    assert commands.start(make_rig(control_dword=0b101).axis, 1, -10.0, V) == 0


@pytest.mark.parametrize(
    ("velocity", "error"),
    [
        (0.0, NcError.SET_VELOCITY_NOT_ALLOWED),
        (-1.0, NcError.SET_VELOCITY_NOT_ALLOWED),
        (nan, NcError.SET_VELOCITY_NOT_ALLOWED),
        (inf, NcError.SET_VELOCITY_NOT_ALLOWED),
        (2000.1, NcError.SET_VELOCITY_NOT_ALLOWED),
        (1e-4, NcError.SET_VELOCITY_RANGE),
    ],
)
def test_velocities(rig: Any, velocity: float, error: NcError) -> None:
    for kind in (StartType.ABSOLUTE, StartType.ENDLESS_POSITIVE):
        rig.refuses(error, commands.start, kind, 10.0, velocity)
        rig.refuses(error, commands.universal_start, kind, 10.0, velocity)


def test_velocity_above_the_reference_velocity(make_rig: Any) -> None:
    rig = make_rig(drive_reference_velocity=150.0)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, commands.start, 1, 10.0, V)


@pytest.mark.parametrize(
    ("dynamics", "error"),
    [
        ((0.0, 1.0, 1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((1.0, -1.0, 1.0), NcError.DECELERATION_NOT_POSITIVE),
        ((1.0, 1.0, 0.0), NcError.JERK_NOT_POSITIVE),
        ((nan, 1.0, 1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((1e9, 1.0, 1.0), NcError.ACCELERATION_NOT_PERMITTED),
        ((1.0, 1e9, 1.0), NcError.ACCELERATION_NOT_PERMITTED),
        ((1.0, 1.0, 1e13), NcError.JERK_NOT_PERMITTED),
    ],
)
def test_dynamics(rig: Any, dynamics: tuple[float, float, float], error: NcError) -> None:
    rig.refuses(error, commands.start, 1, 10.0, V, *dynamics)
    if 0.0 not in dynamics:
        rig.refuses(error, commands.universal_start, 1, 10.0, V, *dynamics)


def test_zero_dynamics_of_the_universal_start_are_the_defaults(rig: Any) -> None:
    assert commands.universal_start(rig.axis, 1, 10.0, V) == 0
    assert rig.axis.job_acceleration == rig.axis.default_acceleration
    assert rig.axis.job_jerk == rig.axis.default_jerk


@pytest.mark.parametrize(
    ("kind", "position", "error"),
    [
        (0, 10.0, NcError.START_TYPE),
        (6, 10.0, NcError.START_TYPE),
        (1, nan, NcError.START_AXIS_DATA),
        (2, inf, NcError.START_AXIS_DATA),
        (1, 1e11, NcError.PRECISION_LOST),
        (StartType.MODULO_SHORTEST, 360.0, NcError.MODULO_START_RANGE),
        (StartType.MODULO_POSITIVE, -1.0, NcError.MODULO_START_RANGE),
        (StartType.MODULO_NEGATIVE, 720.0, NcError.MODULO_START_RANGE),
    ],
)
def test_targets(rig: Any, kind: int, position: float, error: NcError) -> None:
    rig.refuses(error, commands.start, kind, position, V)
    rig.refuses(error, commands.universal_start, kind, position, V)


def test_the_old_start_knows_neither_halt_nor_lock(rig: Any) -> None:
    for kind in (StartType.HALT, StartType.STOP_AND_LOCK):
        rig.refuses(NcError.START_TYPE, commands.start, kind, 0.0, V)


def test_targets_beyond_soft_limits(make_rig: Any) -> None:
    rig = make_rig(
        encoder_soft_limit_min_enable=1,
        encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-10.0,
        encoder_soft_limit_max=20.0,
    )
    rig.refuses(NcError.SOFT_LIMIT_MIN_AT_START, commands.start, 1, -10.1, V)
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 2, 20.1, V)
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 517, 90.0, V)
    assert commands.start(rig.axis, 1, 20.0, V) == 0
    rig.until_rest()
    assert rig.axis.error_code == 0
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 3, 0.0, V)
    assert commands.start(rig.axis, 1, 0.0, V) == 0
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.new_end_position, 1, 30.0)


def test_the_way_back_from_beyond_a_soft_limit_is_open(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=20.0)
    commands.set_actual_position(rig.axis, 1, 30.0)
    assert commands.start(rig.axis, 1, 10.0, V) == 0
    rig.run(2)
    assert rig.has(StateBit.SOFT_LIMIT_MAX_EXCEEDED)
    rig.until_rest()
    assert rig.axis.error_code == 0
    assert not rig.has(StateBit.SOFT_LIMIT_MAX_EXCEEDED)


def test_old_services_are_busy_during_a_job(rig: Any) -> None:
    assert commands.start(rig.axis, 1, 100.0, V) == 0
    rig.refuses(NcError.GROUP_BUSY, commands.start, 1, 50.0, V)
    rig.refuses(NcError.GROUP_BUSY, commands.set_actual_position, 1, 0.0)
    rig.refuses(NcError.GROUP_BUSY, commands.disable)


def test_changes_need_a_running_move(rig: Any) -> None:
    rig.refuses(NcError.GROUP_BUSY, commands.new_end_position, 1, 50.0)
    rig.refuses(NcError.NO_MOTION, commands.new_dynamics, 1.0, 1.0, 1.0)


def test_the_job_shows_before_the_next_cycle(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    assert rig.has(StateBit.HAS_JOB)
    assert not rig.has(StateBit.IN_TARGET_POSITION)


def test_a_full_buffer(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    for n in range(COMMAND_BUFFER):
        assert commands.universal_start(rig.axis, 2, 1.0 + n, V, buffer_mode=1) == 0
    full = commands.universal_start(rig.axis, 2, 1.0, V, buffer_mode=1)
    refused(rig, full, NcError.COMMAND_BUFFER_FULL)
    rig.until(lambda axis: axis.set_motion_phase == 0 and axis.buffer_count == 0)
    assert rig.axis.set_position == pytest.approx(100.0 + sum(range(1, COMMAND_BUFFER + 1)))


def test_an_aborting_command_empties_the_buffer(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    commands.universal_start(rig.axis, 1, 200.0, V, buffer_mode=BufferMode.BUFFERED)
    commands.universal_start(rig.axis, 1, 50.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.set_position == 50.0


def test_blending_wants_one_direction_and_a_way(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    back = commands.universal_start(rig.axis, 1, 50.0, V, buffer_mode=BufferMode.BLENDING_LOW)
    refused(rig, back, NcError.COMMAND_OTHER_DIRECTION)
    same = commands.universal_start(rig.axis, 1, 100.0, V, buffer_mode=BufferMode.BUFFERED)
    refused(rig, same, NcError.COMMAND_SAME_TARGET)


def test_modes_that_do_not_exist(rig: Any) -> None:
    for extra in ({"buffer_mode": 2}, {"segment_end_velocity": 5.0}, {"blending_position": 1.0}):
        code = commands.universal_start(rig.axis, 1, 50.0, V, **extra)
        refused(rig, code, NcError.FUNCTION_NOT_AVAILABLE)


def test_stop_and_lock_holds_the_axis_until_released(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    assert commands.universal_start(rig.axis, StartType.STOP_AND_LOCK, 0.0, 0.0) == 0
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED)
    locked = NcError.AXIS_LOCKED_BY_STOP
    rig.refuses(locked, commands.universal_start, 1, 0.0, V)
    rig.refuses(locked, commands.universal_start, StartType.HALT, 0.0, 0.0)
    rig.until_rest()
    rig.run(1)
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED)
    rig.refuses(locked, commands.start, 1, 0.0, V)
    assert commands.release_lock(rig.axis) == 0
    assert commands.start(rig.axis, 1, 0.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 0.0


def test_halt_can_be_aborted(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    assert commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0) == 0
    rig.run(5)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    assert commands.universal_start(rig.axis, 1, 500.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 500.0
    assert not rig.has(StateBit.HAS_BEEN_STOPPED)


def test_a_halt_is_a_command_with_number_and_state(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0)
    assert rig.axis.set_command_number == rig.axis.command_counter == 2
    assert rig.axis.set_command_state == CommandState.ACTIVE
    rig.until_rest()
    assert rig.axis.set_command_state == CommandState.DONE


def test_an_emergency_stop_is_no_weaker_than_the_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    for data in ((1000.0, 3000.0), (3000.0, 2000.0), (0.0, 3000.0), (3000.0, nan)):
        rig.refuses(NcError.EMERGENCY_STOP_DATA, commands.emergency_stop, *data)
    begin = rig.axis.set_position
    assert commands.emergency_stop(rig.axis, 4000.0, 80000.0) == 0
    rig.until_rest()
    time = V / 4000.0 + 4000.0 / 80000.0
    assert rig.axis.set_position - begin == pytest.approx(V * time / 2.0)


def test_a_parameterized_stop_has_its_own_ramp(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    zero = commands.parameterized_stop(rig.axis, 0.0, 1.0)
    refused(rig, zero, NcError.DECELERATION_NOT_POSITIVE)
    begin = rig.axis.set_position
    assert commands.parameterized_stop(rig.axis, 100.0, 1000.0) == 0
    rig.until_rest()
    time = V / 100.0 + 100.0 / 1000.0
    assert rig.axis.set_position - begin == pytest.approx(V * time / 2.0)


def test_a_running_stop_is_not_weakened(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    begin = rig.axis.set_position
    commands.emergency_stop(rig.axis, 4000.0, 80000.0)
    rig.run(1)
    commands.parameterized_stop(rig.axis, 10.0, 10.0)
    rig.until_rest()
    assert rig.axis.set_position - begin == pytest.approx(V * 0.1 / 2.0)


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


def test_actual_positions_that_cannot_be_set(make_rig: Any) -> None:
    rig = make_rig()
    out_of_range = NcError.ENCODER_SET_POSITION_RANGE
    rig.refuses(out_of_range, commands.set_actual_position, 1, 1e11)
    rig.refuses(out_of_range, commands.set_actual_position, 1, nan)
    rig.refuses(NcError.JOB_START_TYPE, commands.set_actual_position, 3, 1.0)
    absolute = make_rig(encoder_is_absolute=1)
    code = commands.set_actual_position(absolute.axis, 1, 1.0)
    refused(absolute, code, NcError.FUNCTION_NOT_ALLOWED)


def test_switch_positions_lie_on_the_way(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.seconds(0.5)
    change = commands.new_end_position_and_velocity
    beside = NcError.ACTIVATION_POSITION_NOT_ON_WAY
    rig.refuses(beside, change, 10, 0, 0.0, 10.0, -5.0)
    rig.refuses(beside, change, 10, 0, 0.0, 10.0, 105.0)
    rig.refuses(NcError.JOB_START_TYPE, change, 9, 3, 0.0, 0.0, 90.0)
    rig.refuses(NcError.JOB_TYPE, change, 4, 1, 0.0, 0.0, 90.0)
    rig.refuses(NcError.JOB_START_TYPE, change, 1, 9, 0.0, 0.0, 90.0)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, change, 2, 0, 0.0, 0.0, 0.0)


def test_a_move_becomes_endless_and_positioned_again(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.run(100)
    assert commands.new_end_position(rig.axis, 3, 0.0) == 0
    rig.seconds(2.0)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert commands.new_end_position(rig.axis, 1, 1000.0) == 0
    rig.until_rest()
    assert rig.axis.set_position == 1000.0


def test_an_axis_in_error_answers_its_error(rig: Any) -> None:
    assert commands.set_external_error(rig.axis, NcError.DRIVE_IO_INVALID.number) == 0
    rig.run(1)
    assert rig.has(StateBit.ERROR)
    assert commands.start(rig.axis, 1, 10.0, V) == NcError.DRIVE_IO_INVALID.number
    assert (
        commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0)
        == NcError.DRIVE_IO_INVALID.number
    )
    assert commands.reset(rig.axis) == 0
    assert not rig.has(StateBit.ERROR)
    assert commands.start(rig.axis, 1, 10.0, V) == 0
    assert rig.axis.reset_command_counter == 1
    rig.refuses(NcError.REQUEST_PARAMETER, commands.set_external_error, 0)


def test_reset_during_a_move_stops_abruptly(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    p = rig.axis.set_position
    commands.reset(rig.axis)
    rig.run(1)
    assert (rig.axis.set_position, rig.axis.set_velocity) == (p, 0.0)
    assert not rig.has(StateBit.HAS_JOB)


def test_a_disabled_axis_takes_no_command(rig: Any) -> None:
    commands.disable(rig.axis)
    rig.run(1)
    assert not rig.has(StateBit.CONTROL_LOOP_CLOSED)
    rig.refuses(NcError.AXIS_NOT_READY, commands.start, 1, 1.0, V)
    rig.refuses(NcError.AXIS_NOT_READY, commands.universal_start, 8192, 1.0, V)
    commands.enable(rig.axis)
    assert commands.start(rig.axis, 1, 1.0, V) == 0


def test_the_drive_output_can_be_switched_off(rig: Any) -> None:
    commands.set_drive_output(rig.axis, False)
    rig.run(1)
    assert not rig.has(StateBit.OPERATIONAL)
    rig.refuses(NcError.CONTROLLER_ENABLE_MISSING, commands.start, 1, 1.0, V)
    commands.set_drive_output(rig.axis, True)
    rig.run(1)
    assert rig.has(StateBit.OPERATIONAL)


def test_the_homed_flag(rig: Any) -> None:
    assert commands.set_homed_flag(rig.axis, 1) == 0
    rig.run(1)
    assert rig.has(StateBit.HOMED)
    rig.refuses(NcError.ENCODER_HOMED_FLAG, commands.set_homed_flag, 2)


def test_new_dynamics_act_on_the_running_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    assert commands.new_dynamics(rig.axis, 500.0, 100.0, 1000.0) == 0
    commands.stop(rig.axis)
    distance, time = commands.stop_information(rig.axis, 0.0, 0.0)
    assert time == pytest.approx(V / 100.0 + 100.0 / 1000.0)
    assert distance == pytest.approx(V * time / 2.0)


def test_command_numbers_are_16_bits_and_never_zero(rig: Any) -> None:
    rig.axis.command_counter = 0xFFFF
    commands.universal_start(rig.axis, 1, 1.0, V)
    assert rig.axis.command_counter == 1
