"""What forbids a command, where no whole command is needed to see it."""

from math import inf, nan, nextafter
from operator import attrgetter
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import ControlBit, StartType
from achse.codes.nc.choices import AxisType
from achse.motion import checks, commands


def number(error: NcError | None) -> int:
    return checks.OK if error is None else error.number


def test_the_first_obstacle_is_named(rig: Any) -> None:
    axis = rig.axis
    assert checks.check_command(axis) == checks.OK
    axis.motion_locked = 1
    assert checks.check_command(axis) == NcError.AXIS_LOCKED_BY_STOP.number
    axis.error_code = 0x4550
    assert checks.check_command(axis) == 0x4550
    axis.axis_disabled = 1
    assert checks.check_command(axis) == NcError.AXIS_NOT_READY.number


def test_an_endless_start_needs_no_position(rig: Any) -> None:
    for start_type in checks.ENDLESS:
        assert checks.check_position(rig.axis, start_type, nan) == checks.OK
    assert checks.check_position(rig.axis, 1, inf) == NcError.START_AXIS_DATA.number


def test_no_direction_needs_no_feed_enable(make_rig: Any) -> None:
    axis = make_rig(control_dword=1).axis
    assert checks.check_permitted(axis, 0.0) == checks.OK
    assert checks.check_permitted(axis, 1.0) == NcError.ENABLE_MISSING.number
    assert checks.check_permitted(axis, -1.0) == NcError.ENABLE_MISSING.number


def test_an_encoder_axis_does_not_move(make_rig: Any) -> None:
    rig = make_rig(axis_type=AxisType.ENCODER)
    incompatible = NcError.AXIS_INCOMPATIBLE
    rig.refuses(incompatible, commands.start, 1, 100.0, 100.0)
    rig.refuses(incompatible, commands.start_drive_output, 1, 5.0)
    rig.refuses(incompatible, commands.home)
    assert commands.set_actual_position(rig.axis, 1, 50.0) == 0


def test_soft_limits_count_only_when_watched(make_rig: Any) -> None:
    off = make_rig(encoder_soft_limit_max=5.0).axis
    on = make_rig(encoder_soft_limit_max=5.0, encoder_soft_limit_max_enable=1).axis
    assert checks.check_target(off, 6.0) == checks.OK
    assert checks.check_target(on, 5.0) == checks.OK
    assert checks.check_target(on, 6.0) == NcError.SOFT_LIMIT_MAX_AT_START.number
    assert checks.check_away(on, 1.0) == checks.OK


def test_a_waiting_move_counts_from_the_target_before_it(make_rig: Any) -> None:
    near = {"axis_type": AxisType.DISCRETE_RAPID_CREEP, "brake_distance_negative": 2.0}
    axis = make_rig(**near).axis
    assert commands.universal_start(axis, 1, 100.0, 100.0) == 0
    assert commands.universal_start(axis, 1, 0.0, 100.0, buffer_mode=1) == 0
    assert (
        commands.universal_start(axis, 1, -1.0, 100.0, buffer_mode=1)
        == NcError.DISTANCE_BELOW_BRAKING_DISTANCE.number
    )
    loop = {"loop_enable": 1, "loop_distance": 50.0, "encoder_soft_limit_max": 120.0}
    axis = make_rig(**loop, encoder_soft_limit_max_enable=1).axis
    assert commands.universal_start(axis, 1, -100.0, 100.0) == 0
    assert commands.universal_start(axis, 1, 20.0, 100.0, buffer_mode=1) == 0
    assert (
        commands.universal_start(axis, 1, 80.0, 100.0, buffer_mode=1)
        == NcError.SOFT_LIMIT_MAX_AT_START.number
    )
    assert (
        commands.start_reversing(
            make_rig(**loop, encoder_soft_limit_max_enable=1).axis, 1, -50.0, 100.0, 100.0, 0.0
        )
        == NcError.SOFT_LIMIT_MAX_AT_START.number
    )


def test_way_of_a_loop_counts_only_in_its_direction(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max=60.5, encoder_soft_limit_max_enable=1)
    axis = rig.axis
    axis.loop_enable, axis.loop_distance = 1, 1.0
    assert checks.check_target(axis, 60.0, 60.0) == 0
    assert checks.check_target(axis, 60.0, 61.0) == 0
    assert checks.check_target(axis, 60.0, 59.0) == NcError.SOFT_LIMIT_MAX_AT_START


STATES: list[tuple[dict[str, int], NcError | None]] = [
    ({}, None),
    ({"axis_disabled": 1}, NcError.AXIS_NOT_READY),
    ({"error_code": NcError.AXIS_LOCKED_BY_STOP.number}, NcError.AXIS_LOCKED_BY_STOP),
    ({"grouped": 1}, NcError.FUNCTION_NOT_ALLOWED),
    ({"motion_locked": 1}, NcError.AXIS_LOCKED_BY_STOP),
    ({"coupling.law": 1}, NcError.JOB_FOR_SLAVE),
    ({"coupling.law": 1, "allow_slave_motion_commands": 1}, None),
    ({"allow_slave_motion_commands": 1}, None),
    ({"external_setpoint_active": 1}, NcError.EXTERNAL_GENERATOR_ACTIVE),
    (
        {"external_setpoint_active": 1, "allow_motion_commands_with_external_setpoint": 1},
        None,
    ),
]


@pytest.mark.parametrize(("state", "error"), STATES)
def test_state_forbids_commands(rig: Any, state: dict[str, int], error: NcError | None) -> None:
    for name, value in state.items():
        part, _, field = name.rpartition(".")
        setattr(attrgetter(part)(rig.axis) if part else rig.axis, field, value)
    assert checks.check_command(rig.axis) == number(error)
    follows = rig.axis.coupling.law and not rig.axis.allow_slave_motion_commands
    assert checks.check_own(rig.axis) == number(NcError.FUNCTION_FOR_SLAVE if follows else None)


@pytest.mark.parametrize(
    ("state", "codes"),
    [
        ({}, (None, None, None)),
        ({"axis_type": AxisType.ENCODER}, (NcError.AXIS_INCOMPATIBLE,) * 3),
        ({"control_dword": 6}, (NcError.CONTROLLER_ENABLE_MISSING,) * 3),
        ({"drive_output_disabled": 1}, (NcError.CONTROLLER_ENABLE_MISSING,) * 3),
        ({"control_dword": 3}, (None, None, NcError.ENABLE_MISSING)),
        ({"control_dword": 5}, (NcError.ENABLE_MISSING, None, None)),
        ({"drive_status": 9}, (NcError.DRIVE_NOT_READY_AT_START,) * 3),
        ({"limit_switch": 1}, (NcError.DRIVE_NOT_READY_AT_START,) * 3),
        (
            {"limit_switch": 1, "control_dword": 0x107},
            (NcError.DRIVE_NOT_READY_AT_START, NcError.DRIVE_NOT_READY_AT_START, None),
        ),
        (
            {"limit_switch": -1, "control_dword": 0x107},
            (None, NcError.DRIVE_NOT_READY_AT_START, NcError.DRIVE_NOT_READY_AT_START),
        ),
        (
            {"limit_switch": -1, "control_dword": 0x107, "drive_status": 9},
            (NcError.DRIVE_NOT_READY_AT_START,) * 3,
        ),
    ],
)
def test_enables_and_drive_permit_directions(
    rig: Any, state: dict[str, int], codes: tuple[NcError | None, ...]
) -> None:
    """Forward, in no direction, backward."""
    assert ControlBit.ACCEPT_BLOCKED_DRIVE == 0x100
    for name, value in state.items():
        setattr(rig.axis, name, value)
    results = [checks.check_permitted(rig.axis, direction) for direction in (1.0, 0.0, -1.0)]
    assert results == [number(code) for code in codes]


@pytest.mark.parametrize("first", ["max_velocity", "reference_velocity"])
def test_velocity_of_a_command_has_bounds(rig: Any, first: str) -> None:
    axis = rig.axis
    for limit, velocity, error in (
        (50.0, 50.0, None),
        (50.0, nextafter(50.0, inf), NcError.SET_VELOCITY_NOT_ALLOWED),
        (50.0, 0.0, NcError.SET_VELOCITY_NOT_ALLOWED),
        (50.0, nan, NcError.SET_VELOCITY_NOT_ALLOWED),
        (50.0, checks.SLOWEST, None),
        (50.0, nextafter(checks.SLOWEST, 0.0), NcError.SET_VELOCITY_RANGE),
        (1e11, checks.FASTEST, None),
        (1e11, nextafter(checks.FASTEST, inf), NcError.SET_VELOCITY_RANGE),
    ):
        axis.max_velocity = axis.drive.reference_velocity = 1e12
        setattr(axis if first == "max_velocity" else axis.drive, first, limit)
        assert checks.check_velocity(axis, velocity) == number(error), velocity
    assert checks.SLOWEST == 1e-3


def test_dynamics_of_a_command_have_bounds(rig: Any) -> None:
    axis, steepest = rig.axis, checks.STEEPEST_JERK
    axis.max_acceleration, axis.max_deceleration = 300.0, 400.0
    for dynamics, error in (
        ((300.0, 400.0, steepest), None),
        ((nan, 400.0, steepest), NcError.ACCELERATION_NOT_POSITIVE),
        ((0.0, 400.0, steepest), NcError.ACCELERATION_NOT_POSITIVE),
        ((300.0, 0.0, steepest), NcError.DECELERATION_NOT_POSITIVE),
        ((300.0, 400.0, 0.0), NcError.JERK_NOT_POSITIVE),
        ((5e-324, 5e-324, 5e-324), None),
        ((nextafter(300.0, inf), 400.0, 1.0), NcError.ACCELERATION_NOT_PERMITTED),
        ((300.0, nextafter(400.0, inf), 1.0), NcError.ACCELERATION_NOT_PERMITTED),
        ((300.0, 400.0, nextafter(steepest, inf)), NcError.JERK_NOT_PERMITTED),
    ):
        assert checks.check_dynamics(axis, *dynamics) == number(error), dynamics


def test_position_within_one_period_may_be_its_begin_but_not_its_end(rig: Any) -> None:
    rig.axis.encoder.modulo_factor = 360.0
    for start_type in (
        StartType.MODULO_SHORTEST,
        StartType.MODULO_POSITIVE,
        StartType.MODULO_NEGATIVE,
    ):
        for position, error in (
            (0.0, None),
            (nextafter(360.0, 0.0), None),
            (360.0, NcError.MODULO_START_RANGE),
            (-5e-324, NcError.MODULO_START_RANGE),
            (nan, NcError.START_AXIS_DATA),
        ):
            code = checks.check_position(rig.axis, start_type, position)
            assert code == number(error), position
    assert checks.check_position(rig.axis, StartType.ABSOLUTE, 360.0) == checks.OK


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_target_may_be_at_a_limit_but_not_beyond(rig: Any, sign: float) -> None:
    axis, encoder = rig.axis, rig.axis.encoder
    for target, error in (
        (checks.FARTHEST, None),
        (nextafter(checks.FARTHEST, inf), NcError.PRECISION_LOST),
    ):
        assert checks.check_target(axis, sign * target) == number(error)
    encoder.soft_limit_min, encoder.soft_limit_max = -60.0, 60.0
    encoder.soft_limit_min_enable = encoder.soft_limit_max_enable = 1
    passed = NcError.SOFT_LIMIT_MAX_AT_START if sign > 0.0 else NcError.SOFT_LIMIT_MIN_AT_START
    for loop, begin, target, error in (
        (0.0, 0.0, 60.0, None),
        (0.0, 0.0, nextafter(60.0, inf), passed),
        (9.0, 0.0, 51.0, None),
        (9.0, 0.0, 52.0, passed),
        (9.0, 52.0, 52.0, None),
        (-9.0, 52.0, 52.0, None),
        (-9.0, 0.0, 60.0, None),
    ):
        axis.loop_enable, axis.loop_distance = int(loop != 0.0), sign * loop
        axis.set_position = sign * begin
        assert checks.check_target(axis, sign * target) == number(error), (loop, begin, target)
    axis.loop_enable, axis.loop_distance, axis.set_position = 0, sign * 9.0, 0.0
    assert checks.check_target(axis, sign * 52.0) == checks.OK
    for direction in (1.0, -1.0, 0.0):
        for place, error in ((60.0, passed), (nextafter(60.0, 0.0), None), (61.0, passed)):
            axis.set_position = sign * place
            expected = error if direction == sign else None
            assert checks.check_away(axis, direction) == number(expected)
    encoder.soft_limit_min_enable = encoder.soft_limit_max_enable = 0
    assert checks.check_away(axis, sign) == checks.OK
    assert checks.check_target(axis, sign * 61.0) == checks.OK


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_way_of_rapid_and_creep_is_longer_than_its_braking_distance(
    make_rig: Any, sign: float
) -> None:
    """A loop ends the other way: there the other braking distance counts."""
    axis = make_rig(axis_type=AxisType.DISCRETE_RAPID_CREEP).axis
    ahead, back = 0.25, 5.0
    axis.brake_distance_positive, axis.brake_distance_negative = (
        (ahead, back) if sign > 0.0 else (back, ahead)
    )
    short, loop = NcError.DISTANCE_BELOW_BRAKING_DISTANCE, NcError.LOOP_BELOW_BRAKING_DISTANCE
    for begin, target, distance, error in (
        (10.0, 10.25, 0.0, short),
        (10.0, nextafter(10.25, inf), 0.0, None),
        (10.0, 10.0, 0.0, short),
        (10.0, 10.5, 5.0, loop),
        (10.0, 10.5, nextafter(5.0, inf), None),
        (10.0, 20.0, -3.0, None),
    ):
        axis.loop_enable, axis.loop_distance = int(distance != 0.0), sign * distance
        code = checks.check_target(axis, sign * target, sign * begin)
        assert code == number(error), (target, distance)
    axis.axis_type = AxisType.CONTINUOUS_SERVO
    assert checks.check_target(axis, sign * 10.25, sign * 10.0) == checks.OK
