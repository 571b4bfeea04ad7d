"""Monitoring: every error at run time and every status bit has its cause."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import EncoderType
from achse.motion import (
    ControlBit,
    MotionState,
    OperationModeBit,
    StartType,
    StateBit,
    commands,
)
from achse.motion.monitoring import _at_limit, show_state

V = 200.0

FULL_COUNTER = 4_000_000_000_000_000_000


def fails(rig: Any, error: NcError, seconds: float = 10.0) -> int:
    """Cycles until the axis shows this error."""
    cycles: int = rig.until(lambda axis: axis.error_code != 0, seconds)
    assert NcError.of(rig.axis.error_code) is error
    assert rig.has(StateBit.ERROR)
    assert not rig.has(StateBit.OPERATIONAL)
    assert not rig.has(StateBit.HAS_JOB)
    assert rig.axis.buffer_count == 0
    return cycles


def start_endless(rig: Any, kind: StartType = StartType.ENDLESS_POSITIVE) -> None:
    commands.universal_start(rig.axis, kind, 0.0, V)
    commands.universal_start(rig.axis, StartType.RELATIVE, 10.0, V, buffer_mode=0)
    commands.universal_start(rig.axis, kind, 0.0, V)
    rig.seconds(1.0)
    assert abs(rig.axis.set_velocity) == pytest.approx(V)


def test_a_withdrawn_enable_brakes_the_axis_and_opens_the_loop(rig: Any) -> None:
    start_endless(rig)
    begin = rig.axis.set_position
    way, time = commands.stop_information(rig.axis, 0.0, 0.0)
    rig.axis.control_dword = 6
    assert fails(rig, NcError.CONTROLLER_ENABLE_MISSING) == 1
    assert rig.has(StateBit.CONTROL_LOOP_CLOSED)
    assert rig.until_rest() == pytest.approx(time / rig.dt, abs=1.0)
    assert rig.axis.set_position == pytest.approx(begin + way)
    rig.seconds(1.0)
    assert not rig.has(StateBit.CONTROL_LOOP_CLOSED)
    rig.axis.control_dword = 7
    rig.run(1)
    assert rig.has(StateBit.ERROR)
    commands.reset(rig.axis)
    rig.run(1)
    assert rig.has(StateBit.OPERATIONAL)


def test_enable_and_start_may_come_in_the_same_cycle(make_rig: Any) -> None:
    rig = make_rig(control_dword=0)
    rig.axis.control_dword = 7
    assert commands.start(rig.axis, 1, 10.0, V) == 0
    rig.until_rest()
    assert (rig.axis.set_position, rig.axis.error_code) == (10.0, 0)


def test_a_start_whose_enable_vanished_ends_in_error(make_rig: Any) -> None:
    rig = make_rig(control_dword=0)
    rig.axis.control_dword = 7
    commands.start(rig.axis, 1, 10.0, V)
    rig.axis.control_dword = 0
    assert fails(rig, NcError.CONTROLLER_ENABLE_MISSING) == 1
    assert rig.axis.set_motion_phase == 0


def test_enable_of_a_slave_at_rest_may_go(make_rig: Any) -> None:
    rig = make_rig(count=2)
    slave = rig.nc.axis(2)
    assert commands.couple(slave, 1, 1, 0, 0, 1.0) == 0
    rig.run(2)
    slave.control_dword = 6
    rig.run(2)
    assert (slave.error_code, slave.loop_closed) == (0, 0)


def test_axis_beyond_a_limit_without_a_table_is_at_the_limit(make_rig: Any) -> None:
    axis = make_rig(count=1).axis
    axis.limits.low, axis.limits.high = -60.0, 60.0
    for position, velocity, where in (
        (61.0, 5.0, 1),
        (61.0, -5.0, 0),
        (-61.0, -5.0, -1),
        (-61.0, 5.0, 0),
        (60.0, 5.0, 0),
        (-60.0, -5.0, 0),
    ):
        axis.set_position, axis.set_velocity = position, velocity
        assert _at_limit(axis) == where
    axis.limits.reached = -1
    assert (_at_limit(axis), axis.limits.reached) == (-1, 0)


def test_the_enable_may_go_at_rest(rig: Any) -> None:
    rig.axis.control_dword = 0
    rig.run(1)
    assert not rig.has(StateBit.CONTROL_LOOP_CLOSED)
    assert rig.axis.error_code == 0


@pytest.mark.parametrize(
    ("kind", "withdrawn", "error"),
    [
        (
            StartType.ENDLESS_POSITIVE,
            ControlBit.FEED_ENABLE_PLUS,
            NcError.FEED_ENABLE_PLUS_WITHDRAWN,
        ),
        (
            StartType.ENDLESS_NEGATIVE,
            ControlBit.FEED_ENABLE_MINUS,
            NcError.FEED_ENABLE_MINUS_WITHDRAWN,
        ),
    ],
)
def test_a_withdrawn_feed_enable(
    rig: Any, kind: StartType, withdrawn: ControlBit, error: NcError
) -> None:
    start_endless(rig, kind)
    rig.axis.control_dword = 7 & ~(7 ^ 1 ^ withdrawn)
    rig.run(5)
    assert rig.axis.error_code == 0  # the other direction does not matter
    rig.axis.control_dword = 7 & ~withdrawn
    fails(rig, error)
    rig.until_rest()
    rig.run(1)
    assert rig.has(StateBit.CONTROL_LOOP_CLOSED)


def test_the_emergency_ramp_is_the_stronger_one(make_rig: Any) -> None:
    rig = make_rig(fast_axis_stop_deceleration=5000.0, fast_axis_stop_jerk=100_000.0)
    start_endless(rig)
    rig.axis.control_dword = 0
    time = V / 5000.0 + 5000.0 / 100_000.0
    assert rig.until_rest() == pytest.approx(time / rig.dt, abs=1.0)


@pytest.mark.parametrize(
    ("kind", "error"),
    [
        (StartType.ENDLESS_POSITIVE, NcError.SOFT_LIMIT_MAX_PASSED),
        (StartType.ENDLESS_NEGATIVE, NcError.SOFT_LIMIT_MIN_PASSED),
    ],
)
def test_soft_limits_end_an_endless_move(make_rig: Any, kind: StartType, error: NcError) -> None:
    rig = make_rig(
        encoder_soft_limit_min_enable=1,
        encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-300.0,
        encoder_soft_limit_max=300.0,
    )
    start_endless(rig, kind)
    fails(rig, error)
    assert abs(rig.axis.set_position) == 300.0
    rig.until_rest()
    rig.seconds(0.5)
    assert abs(rig.axis.set_position) == 300.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_soft_limit_is_exceeded_where_the_axis_is_beyond(rig: Any, sign: float) -> None:
    assert commands.start(rig.axis, StartType.ABSOLUTE, sign * 50.0, V) == 0
    rig.until_rest()
    rig.seconds(0.5)
    rig.axis.encoder.soft_limit_max, rig.axis.encoder.soft_limit_min = 20.0, -20.0
    rig.axis.encoder.soft_limit_max_enable = rig.axis.encoder.soft_limit_min_enable = 1
    rig.run(1)
    exceeded = rig.has(StateBit.SOFT_LIMIT_MAX_EXCEEDED), rig.has(StateBit.SOFT_LIMIT_MIN_EXCEEDED)
    assert exceeded == (sign > 0.0, sign < 0.0)


def test_a_blocked_motor_becomes_a_following_error(rig: Any) -> None:
    start_endless(rig)
    before = rig.axis.actual_position
    rig.axis.simulation_blocked = 1
    cycles = fails(rig, NcError.FOLLOWING_ERROR_POSITION)
    window, filter_time = 5.0, 0.02
    assert cycles * rig.dt == pytest.approx(window / V + filter_time, abs=3 * rig.dt)
    rig.run(1)
    assert rig.axis.drive.output == 0.0
    assert rig.axis.set_velocity == 0.0
    assert not rig.has(StateBit.CONTROL_LOOP_CLOSED)
    assert rig.axis.set_position == rig.axis.actual_position
    assert rig.axis.actual_position == pytest.approx(before, abs=1.01 * V * rig.dt)
    rig.axis.simulation_blocked = 0
    commands.reset(rig.axis)
    rig.run(1)
    assert commands.start(rig.axis, StartType.RELATIVE, 10.0, V) == 0
    rig.until_rest()
    assert rig.axis.error_code == 0


def test_a_following_error_shorter_than_the_filter_time_passes(rig: Any) -> None:
    start_endless(rig)
    rig.axis.simulation_blocked = 1
    rig.until(lambda axis: axis.following_error > 5.0)
    rig.run(5)
    assert rig.axis.error_code == 0
    rig.axis.monitoring.following_error_time = 0.0
    rig.axis.controller.following_error_position_monitoring_enable = 0
    rig.seconds(1.0)
    assert rig.axis.error_code == 0


def test_a_velocity_following_error(make_rig: Any) -> None:
    rig = make_rig(
        controller_following_error_position_monitoring_enable=0,
        controller_following_error_velocity_monitoring_enable=1,
        controller_following_error_velocity_max=100.0,
    )
    start_endless(rig)
    rig.axis.simulation_blocked = 1
    fails(rig, NcError.FOLLOWING_ERROR_VELOCITY)


def test_motion_monitoring_sees_a_standing_encoder(make_rig: Any) -> None:
    rig = make_rig(
        controller_following_error_position_monitoring_enable=0,
        motion_monitoring_enable=1,
        motion_monitoring_time=0.3,
    )
    start_endless(rig)
    assert rig.axis.error_code == 0
    rig.axis.simulation_blocked = 1
    cycles = fails(rig, NcError.NO_MOVEMENT_SEEN)
    assert cycles * rig.dt == pytest.approx(0.3, abs=3 * rig.dt)


def test_peh_time_over(make_rig: Any) -> None:
    rig = make_rig(
        peh_monitoring_enable=1,
        peh_monitoring_time=0.4,
        controller_position_kv=0.0,
        controller_velocity_feedforward_weight=0.9,
        controller_following_error_position_max=100.0,
    )
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    cycles = fails(rig, NcError.PEH_TIME_OVER)
    assert cycles * rig.dt == pytest.approx(0.4, abs=2 * rig.dt)


def test_a_drive_that_is_not_ready(rig: Any) -> None:
    start_endless(rig)
    rig.axis.simulation_not_ready = 1
    assert fails(rig, NcError.DRIVE_NOT_READY) == 1
    assert rig.has(StateBit.DRIVE_DEVICE_ERROR)
    assert not rig.has(StateBit.CONTROL_LOOP_CLOSED)
    commands.reset(rig.axis)
    rig.run(1)
    rig.refuses(NcError.DRIVE_NOT_READY_AT_START, commands.start, 1, 10.0, V)


def test_a_delayed_reaction_announces_the_error(make_rig: Any) -> None:
    rig = make_rig(error_reaction_mode=1, error_reaction_delay=0.1)
    start_endless(rig)
    rig.axis.simulation_blocked = 1
    rig.until(lambda axis: axis.delayed_error_code != 0)
    assert rig.has(StateBit.ERROR_PROPAGATION_DELAYED)
    assert rig.axis.delayed_error_code == NcError.FOLLOWING_ERROR_POSITION.number
    assert rig.axis.error_code == 0
    cycles = fails(rig, NcError.FOLLOWING_ERROR_POSITION)
    assert cycles * rig.dt == pytest.approx(0.1, abs=2 * rig.dt)
    assert not rig.has(StateBit.ERROR_PROPAGATION_DELAYED)


def test_the_encoder_counter_does_not_overflow(rig: Any) -> None:
    rig.axis.encoder.software_increments = FULL_COUNTER
    rig.axis.encoder.data -= 1  # one more was counted
    fails(rig, NcError.ENCODER_OVERFLOW)
    commands.reset(rig.axis)
    rig.axis.encoder.software_increments = -FULL_COUNTER
    rig.axis.encoder.data += 1
    fails(rig, NcError.ENCODER_UNDERFLOW)


def test_the_first_error_stays(rig: Any) -> None:
    start_endless(rig)
    commands.set_external_error(rig.axis, 0x4466)
    rig.run(1)
    rig.axis.control_dword = 0
    rig.seconds(1.0)
    assert rig.axis.error_code == 0x4466


def test_arrival_is_the_target_window_for_its_time(make_rig: Any) -> None:
    rig = make_rig(simulation_ideal=1)
    axis = rig.axis
    axis.target_position_window = 0.01
    commands.start(axis, 1, 100.0, V)
    inside = rig.until(lambda ax: abs(ax.actual_position - 100.0) <= 0.01)
    assert not rig.has(StateBit.IN_TARGET_POSITION)
    waited = rig.until(lambda ax: ax.in_target_position == 1)
    assert waited == pytest.approx(0.02 / rig.dt, abs=1)
    assert rig.has(StateBit.IN_TARGET_POSITION)
    assert axis.set_motion_phase != 0  # inside long enough before the profile ends
    ending = rig.until_rest()
    assert axis.last_positioning_time == pytest.approx((inside + waited + ending) * rig.dt)


def test_the_position_window_has_no_time(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until(lambda axis: axis.in_position_range == 1)
    assert rig.axis.actual_position == pytest.approx(95.0, abs=V * rig.dt)


def test_windows_that_are_off_show_nothing(make_rig: Any) -> None:
    rig = make_rig(position_range_monitoring_enable=0, target_position_monitoring_enable=0)
    commands.start(rig.axis, 1, 1.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert not rig.has(StateBit.IN_POSITION_AREA)
    assert not rig.has(StateBit.IN_TARGET_POSITION)
    assert rig.axis.last_positioning_time > 0.0


def test_motion_states_and_bits_of_a_move(rig: Any) -> None:
    axis = rig.axis
    assert axis.motion_state == MotionState.INACTIVE
    assert rig.has(StateBit.NOT_MOVING)
    commands.start(axis, 1, 400.0, V)
    seen: list[Any] = []
    while not seen or axis.set_motion_phase:
        rig.run(1)
        if not seen or axis.motion_state != seen[-1]:
            seen.append(axis.motion_state)
        if axis.motion_state == MotionState.CONSTANT_VELOCITY:
            assert rig.has(StateBit.CONSTANT_VELOCITY)
            assert rig.has(StateBit.POSITIVE_DIRECTION)
            assert axis.set_direction == 1.0
    assert seen == [
        MotionState.ACCELERATING,
        MotionState.CONSTANT_VELOCITY,
        MotionState.DECELERATING,
        MotionState.INACTIVE,
    ]
    assert rig.has(StateBit.NOT_MOVING)
    assert axis.set_direction == 0.0


def test_remaining_time_and_distance(rig: Any) -> None:
    commands.start(rig.axis, 1, 400.0, V)
    rig.seconds(1.0)
    remaining = rig.axis.remaining_time
    assert rig.axis.remaining_distance == pytest.approx(400.0 - rig.axis.set_position)
    assert rig.until_rest() * rig.dt == pytest.approx(remaining, abs=2 * rig.dt)
    assert rig.axis.remaining_time == 0.0
    assert rig.axis.remaining_distance == 0.0


def test_operation_mode_shows_the_monitoring(make_rig: Any) -> None:
    rig = make_rig(
        position_range_monitoring_enable=0,
        target_position_monitoring_enable=0,
        controller_following_error_position_monitoring_enable=0,
    )
    assert rig.axis.operation_mode_state_dword == OperationModeBit.SIMULATION
    for field, value, bit in (
        ("position_range_monitoring_enable", 1, OperationModeBit.POSITION_AREA_MONITORING),
        ("target_position_monitoring_enable", 1, OperationModeBit.TARGET_POSITION_MONITORING),
        ("motion_monitoring_enable", 1, OperationModeBit.MOTION_MONITORING),
        ("peh_monitoring_enable", 1, OperationModeBit.PEH_TIME_MONITORING),
        ("error_reaction_mode", 1, OperationModeBit.DELAYED_ERROR_REACTION),
        ("unit_interpretation", 4, OperationModeBit.MODULO),
        (
            "controller_following_error_position_monitoring_enable",
            1,
            OperationModeBit.POSITION_LAG_MONITORING,
        ),
        (
            "controller_following_error_velocity_monitoring_enable",
            1,
            OperationModeBit.VELOCITY_LAG_MONITORING,
        ),
        ("encoder_soft_limit_min_enable", 1, OperationModeBit.SOFT_LIMIT_MIN_MONITORING),
        ("encoder_soft_limit_max_enable", 1, OperationModeBit.SOFT_LIMIT_MAX_MONITORING),
    ):
        setattr(rig.axis, field, value)
        rig.run(1)
        assert rig.axis.operation_mode_state_dword == OperationModeBit.SIMULATION | bit
        setattr(rig.axis, field, 0)


@pytest.mark.parametrize(
    ("kind", "signals", "stops"),
    [
        (0, (0, 1, 0), False),
        (1, (0, 1), True),
        (1, (1, 0), False),
        (2, (1, 0), True),
        (2, (0, 1), False),
        (3, (0, 1), True),
        (3, (1, 0), True),
        (4, (0, 0, 1), True),
        (5, (1, 1, 0), True),
        (5, (1, 1, 1), False),
    ],
)
def test_the_fast_stop_signal(
    make_rig: Any, kind: int, signals: tuple[int, ...], stops: bool
) -> None:
    rig = make_rig(
        fast_axis_stop_signal_type=kind,
        simulation_fast_stop_signal=signals[0],
        fast_axis_stop_deceleration=20_000.0,
        fast_axis_stop_jerk=1e7,
    )
    commands.start(rig.axis, 3, 0.0, 200.0)
    rig.seconds(2.0)
    assert rig.axis.set_velocity == 200.0
    for signal in signals[1:]:
        rig.axis.simulation_fast_stop_signal = signal
        rig.run(2)
    if stops:
        assert rig.has(StateBit.HAS_BEEN_STOPPED)
        time = rig.until_rest() * rig.dt
        assert time == pytest.approx(200.0 / 20_000.0 + 20_000.0 / 1e7, abs=3 * rig.dt)
        assert rig.axis.error_code == 0
    else:
        rig.seconds(1.0)
        assert rig.axis.set_velocity == 200.0


def test_invalid_io_data_are_an_error_after_some_cycles(rig: Any) -> None:
    rig.axis.simulation_io_invalid = 1
    rig.run(4)
    assert rig.has(StateBit.IO_DATA_INVALID)
    assert rig.axis.error_code == 0
    rig.axis.simulation_io_invalid = 0
    rig.run(4)
    assert not rig.has(StateBit.IO_DATA_INVALID)
    rig.axis.simulation_io_invalid = 1
    assert rig.until(lambda axis: axis.error_code == 0x4655, 1.0) == 9
    rig.run(1)
    assert rig.axis.loop_closed == 0


@pytest.mark.parametrize(
    ("parameter", "bit"),
    [
        ("position_range_monitoring_enable", 0),
        ("target_position_monitoring_enable", 1),
        ("loop_enable", 2),
        ("motion_monitoring_enable", 3),
        ("peh_monitoring_enable", 4),
        ("backlash_compensation_enable", 5),
        ("error_reaction_mode", 6),
        ("drive_output_filter_type", 13),
        ("controller_following_error_position_monitoring_enable", 16),
        ("controller_following_error_velocity_monitoring_enable", 17),
        ("encoder_soft_limit_min_enable", 18),
        ("encoder_soft_limit_max_enable", 19),
        ("encoder_actual_position_correction_enable", 20),
        ("allow_slave_motion_commands", 21),
        ("allow_motion_commands_with_external_setpoint", 22),
    ],
)
def test_each_operation_mode_bit_has_its_switch(make_rig: Any, parameter: str, bit: int) -> None:
    words = []
    for value in (0, 1):
        rig = make_rig(
            encoder_soft_limit_min=-1e6, encoder_soft_limit_max=1e6, **{parameter: 1 - value}
        )
        setattr(rig.axis, parameter, value)
        rig.run(1)
        words.append(rig.axis.operation_mode_state_dword)
    assert words[0] ^ words[1] == 1 << bit
    assert words[1] >> bit & 1


def test_a_simulation_axis_has_an_encoder_that_is_one(make_rig: Any) -> None:
    for encoder_type, shown in ((EncoderType.SIMULATION, True), (EncoderType.KL5151, False)):
        mode = make_rig(encoder_type=encoder_type).axis.operation_mode_state_dword
        assert bool(mode & OperationModeBit.SIMULATION) is shown


@pytest.mark.parametrize(
    ("field", "bit"),
    [
        ("homing_state", StateBit.HOMING_BUSY),
        ("compensating", StateBit.COMPENSATING),
        ("external_setpoint_active", StateBit.EXTERNAL_SETPOINT_ENABLED),
        ("phasing_active", StateBit.PHASING_ACTIVE),
        ("encoder_latch_valid", StateBit.EXTERNAL_LATCH_VALID),
        ("homed", StateBit.HOMED),
        ("motion_locked", StateBit.MOTION_COMMANDS_LOCKED),
        ("simulation_not_ready", StateBit.DRIVE_DEVICE_ERROR),
        ("simulation_io_invalid", StateBit.IO_DATA_INVALID),
    ],
)
def test_status_bits_show_their_cause(make_rig: Any, field: str, bit: StateBit) -> None:
    rig = make_rig(control_dword=0)
    assert not rig.has(bit)
    setattr(rig.axis, field, 1)
    if field.startswith("simulation"):
        rig.run(1)
    show_state(rig.axis)
    assert rig.has(bit)


def test_the_operation_mode_is_confirmed_in_the_next_cycle(rig: Any) -> None:
    rig.axis.operation_mode = 7
    assert rig.axis.operation_mode_feedback == 0
    rig.run(1)
    assert rig.axis.operation_mode_feedback == 7
