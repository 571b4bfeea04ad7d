"""What forbids a command, where no whole command is needed to see it."""

from math import inf, nan
from typing import Any

from achse.codes import NcError
from achse.motion import checks, commands
from achse.motion.states import AxisType


def test_the_first_obstacle_is_named(rig: Any) -> None:
    axis = rig.axis
    assert checks.why_no_command(axis) == checks.OK
    axis.motion_locked = 1
    assert checks.why_no_command(axis) == NcError.AXIS_LOCKED_BY_STOP.number
    axis.error_code = 0x4550
    assert checks.why_no_command(axis) == 0x4550
    axis.axis_disabled = 1
    assert checks.why_no_command(axis) == NcError.AXIS_NOT_READY.number


def test_an_endless_start_needs_no_position(rig: Any) -> None:
    for start_type in checks.ENDLESS:
        assert checks.why_not_position(rig.axis, start_type, nan) == checks.OK
    assert checks.why_not_position(rig.axis, 1, inf) == NcError.START_AXIS_DATA.number


def test_no_direction_needs_no_feed_enable(make_rig: Any) -> None:
    axis = make_rig(control_dword=1).axis
    assert checks.why_not_permitted(axis, 0.0) == checks.OK
    assert checks.why_not_permitted(axis, 1.0) == NcError.ENABLE_MISSING.number
    assert checks.why_not_permitted(axis, -1.0) == NcError.ENABLE_MISSING.number


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
    assert checks.why_not_target(off, 6.0) == checks.OK
    assert checks.why_not_target(on, 5.0) == checks.OK
    assert checks.why_not_target(on, 6.0) == NcError.SOFT_LIMIT_MAX_AT_START.number
    assert checks.why_not_away(on, 1.0) == checks.OK


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
    assert checks.why_not_target(axis, 60.0, 60.0) == 0
    assert checks.why_not_target(axis, 60.0, 61.0) == 0
    assert checks.why_not_target(axis, 60.0, 59.0) == NcError.SOFT_LIMIT_MAX_AT_START
