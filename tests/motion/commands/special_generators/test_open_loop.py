"""Commands of motion in open loop, of the drive and of the brake: mistakes, each with its code."""

from collections.abc import Callable
from math import inf, nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import Axis, StartType, commands
from achse.motion.port import STATUS_ENABLED

TORQUE = {
    "kind": 0x3001, "mask": 0, "mode": 0, "buffer_mode": 0, "torque": 100.0, "ramp": 0.0,
    "high": 100.0, "low": -100.0, "acceleration": 0.0, "deceleration": 0.0, "manual": 0.0,
}  # fmt: skip

DATA = NcError.START_AXIS_DATA


@pytest.mark.parametrize(
    ("kind", "value", "error"),
    [
        (0, 1.0, NcError.START_TYPE),
        (3, 1.0, NcError.START_TYPE),
        (1, nan, DATA),
        (2, inf, DATA),
    ],
)
def test_outputs(rig: Any, kind: int, value: float, error: NcError) -> None:
    rig.refuses(error, commands.start_drive_output, kind, value)
    commands.start_drive_output(rig.axis, 1, 1.0)
    rig.refuses(error, commands.change_drive_output, kind, value)


def test_changes_need_an_output(rig: Any) -> None:
    rig.refuses(NcError.GENERATOR_INACTIVE, commands.change_drive_output, 1, 1.0)
    rig.refuses(NcError.GENERATOR_INACTIVE, commands.stop_drive_output)


def test_a_changed_output_needs_its_feed_enable(make_rig: Any) -> None:
    rig = make_rig(control_dword=3)
    commands.start_drive_output(rig.axis, 1, 1.0)
    rig.refuses(NcError.ENABLE_MISSING, commands.change_drive_output, 1, -1.0)


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"kind": 1}, NcError.START_TYPE),
        ({"buffer_mode": 1}, NcError.FUNCTION_NOT_AVAILABLE),
        ({"mode": 2}, DATA),
        ({"torque": nan}, DATA),
        ({"torque": 1e11}, DATA),
        ({"ramp": -1.0}, DATA),
        ({"high": -101.0}, DATA),
        ({"low": inf}, DATA),
        ({"acceleration": -1.0}, DATA),
        ({"deceleration": nan}, DATA),
        ({"manual": inf}, DATA),
        ({"mask": 1 << 31}, NcError.GENERATOR_INACTIVE),
    ],
)
def test_torques(rig: Any, wrong: dict[str, float], error: NcError) -> None:
    rig.refuses(error, commands.start_torque_control, *(TORQUE | wrong).values())


def test_limits_may_both_be_negative(rig: Any) -> None:
    arguments = TORQUE | {"high": -10.0, "low": -20.0, "torque": -50.0}
    assert commands.start_torque_control(rig.axis, *arguments.values()) == 0  # type: ignore[arg-type]


def test_an_update_needs_a_continuous_command(rig: Any) -> None:
    assert commands.start_torque_control(rig.axis, *TORQUE.values()) == 0  # type: ignore[arg-type]
    update = TORQUE | {"mask": 1 << 31}
    rig.refuses(NcError.GENERATOR_INACTIVE, commands.start_torque_control, *update.values())


def test_a_relative_torque_may_need_the_other_feed_enable(make_rig: Any) -> None:
    rig = make_rig(control_dword=3)
    commands.start_torque_control(rig.axis, *TORQUE.values())  # type: ignore[arg-type]
    rig.run(1)
    less = TORQUE | {"kind": 0x3002, "torque": -50.0}
    assert commands.start_torque_control(rig.axis, *less.values()) == 0  # type: ignore[arg-type]
    rig.run(1)
    below = TORQUE | {"kind": 0x3002, "torque": -51.0}
    rig.refuses(NcError.ENABLE_MISSING, commands.start_torque_control, *below.values())


def test_a_stepper_has_no_torque_mode(make_rig: Any) -> None:
    rig = make_rig(axis_type=3, drive_type=8)
    error = NcError.GENERATOR_FUNCTION_MISSING
    rig.refuses(error, commands.start_torque_control, *TORQUE.values())
    rig.refuses(NcError.AXIS_INCOMPATIBLE, commands.set_drive_operation_mode, 1)


@pytest.mark.parametrize("mode", [6, 7, 16, 22, 38, 100, 107, -1])
def test_operation_modes_that_the_drive_has_not(rig: Any, mode: int) -> None:
    rig.refuses(NcError.DRIVE_MODE, commands.set_drive_operation_mode, mode)


def test_the_operation_mode_stays_during_a_job(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, 100.0)
    rig.refuses(NcError.GROUP_BUSY, commands.set_drive_operation_mode, 1)


def test_the_brake_of_a_two_speed_axis(make_rig: Any) -> None:
    rig = make_rig(axis_type=2, drive_type=7)
    assert rig.axis.drive.control_byte == 0x80
    assert commands.release_brake(rig.axis, 1) == 0
    rig.run(1)
    assert rig.axis.drive.control_byte == 0x40
    commands.reset(rig.axis)
    rig.run(1)
    assert rig.axis.drive.control_byte == 0x80
    rig.refuses(NcError.REQUEST_PARAMETER, commands.release_brake, 2)


def test_other_axes_have_no_brake(rig: Any) -> None:
    rig.refuses(NcError.AXIS_INCOMPATIBLE, commands.release_brake, 1)


TAKING_OVER: dict[str, Callable[[Axis], Any]] = {
    "halt": lambda axis: commands.universal_start(axis, StartType.HALT, 0.0, 0.0),
    "stop": commands.stop,
    "move": lambda axis: commands.universal_start(axis, StartType.ABSOLUTE, -5.0, 3.0),
    "error": lambda axis: commands.set_external_error(axis, 0x4FFF),
    "controller off": lambda axis: setattr(axis, "control_dword", 6),
    "feed off": lambda axis: setattr(axis, "control_dword", 1),
}


@pytest.mark.parametrize("first", [None, "halt", "stop"])
@pytest.mark.parametrize("then", TAKING_OVER)
def test_what_takes_over_from_a_torque_before_its_first_cycle_makes_nothing_faster(
    rig: Any, first: str | None, then: str
) -> None:
    """The acceleration of the move is still there; only the jerk it was made with ends it."""
    axis = rig.axis
    commands.universal_start(axis, StartType.ENDLESS_POSITIVE, 0.0, 100.0, 1500.0, 1500.0, 1e5)
    rig.run(20)
    run_out = axis.set_velocity + axis.set_acceleration**2 / 2e5
    assert axis.set_acceleration == 1500.0
    if first is not None:
        TAKING_OVER[first](axis)
    torque: list[Any] = list({**TORQUE, "torque": 1.0}.values())
    assert commands.start_torque_control(axis, *torque) == 0
    TAKING_OVER[then](axis)
    speeds = [abs(velocity) for _, velocity, _ in rig.trace(2000)]
    assert max(speeds) <= run_out + 1e-9


def test_type_0x3000_ends_a_torque(rig: Any) -> None:
    abort = TORQUE | {"kind": 0x3000}
    rig.refuses(NcError.GENERATOR_INACTIVE, commands.start_torque_control, *abort.values())
    assert commands.start_torque_control(rig.axis, *TORQUE.values()) == 0  # type: ignore[arg-type]
    rig.run(5)
    assert commands.start_torque_control(rig.axis, *abort.values()) == 0  # type: ignore[arg-type]
    rig.until_rest()
    assert rig.axis.set_motion_phase == 0


@pytest.mark.parametrize("enabled", [False, True])
def test_the_mode_of_a_drive_that_rests_changes_again_and_again(rig: Any, enabled: bool) -> None:
    """Its machine slept and never reported the mode: the second change was refused for ever."""
    if not enabled:
        rig.axis.control_dword = 0
    rig.run(200)
    for mode in (4, 2, 5, 1, 0, 4):
        assert commands.set_drive_operation_mode(rig.axis, mode) == 0, mode
        rig.run(3)
        io = rig.axis.drive.io
        assert io.state3 == io.ctrl3
        rig.run(100)


def test_a_drive_that_rests_says_whether_it_is_enabled(rig: Any) -> None:
    io = rig.axis.drive.io
    for enabled in (True, False, True, False):
        rig.axis.control_dword = 7 if enabled else 0
        rig.run(200)
        assert bool(io.state1 & STATUS_ENABLED) is enabled
