"""Axis functions, 0x4200 + ID: commands to an axis.

A row's request is the arguments of a command in `achse.motion.commands`; a refusal travels as the
result. Source: 002 §6.4.4.3.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from achse.ams import DeviceError
from achse.devices.nc.binding import per_element
from achse.devices.nc.layouts import NO_DATA, UINT32, request
from achse.motion import Axis, CommandState, commands
from achse.server import READ_WRITE, WRITE, Codec, Layout, Service

__all__ = ["AXIS_FUNCTIONS"]


def _carry_out(code: int) -> None:
    if code:
        raise DeviceError(code)


def _function(
    offset: int,
    name: str,
    call: Callable[..., int],
    codec: Codec | tuple[Codec, ...],
    description: str,
    *,
    port: int | None = None,
) -> Service:
    def write(axis: Axis, data: Any) -> None:
        _carry_out(call(axis, *data) if isinstance(data, tuple) else call(axis, data))

    return Service(
        offset,
        name,
        WRITE,
        codec,
        description,
        write=write,
        port=port,
        non_finite=True,  # the command says what is wrong with a number, by an NC code
    )


def _start_extended(
    axis: Axis,
    start_type: int,
    end_position: float,
    velocity: float,
    default_acceleration: int,
    acceleration: float,
    default_deceleration: int,
    deceleration: float,
    default_jerk: int,
    jerk: float,
) -> int:
    return commands.start(
        axis,
        start_type,
        end_position,
        velocity,
        None if default_acceleration else acceleration,
        None if default_deceleration else deceleration,
        None if default_jerk else jerk,
    )


def _universal_start(axis: Axis, arguments: tuple[float, ...]) -> tuple[int, int]:
    """The command's number and state; the control mask, whose bits no manual prints, is unused."""
    start_type, _, *others = arguments
    _carry_out(commands.universal_start(axis, int(start_type), *others))  # type: ignore[arg-type]
    number = axis.command_counter
    active = axis.set_command_number == number
    return number, axis.set_command_state if active else CommandState.BUFFERED


_RAMP = request(deceleration="d", jerk="d")
_POSITION = request(position_type="I", position="d")
_DYNAMICS = request(acceleration="d", deceleration="d", jerk="d")
_START = request(start_type="I", end_position="d", velocity="d")

_NEW_END_POSITION = request(
    command_type="I", position_type="I", position="d", velocity="d", switch_position="d"
)

_START_EXTENDED = request(
    start_type="I", end_position="d", velocity="d",
    use_default_acceleration="I", acceleration="d",
    use_default_deceleration="I", deceleration="d",
    use_default_jerk="I", jerk="d",
)  # fmt: skip

_UNIVERSAL_START = request(
    start_type="I", control_mask="I", end_position="d", velocity="d",
    acceleration="d", deceleration="d", jerk="d",
    buffer_mode="I", blending_position="d",
    segment_start_velocity="d", segment_end_velocity="d",
)  # fmt: skip

_output_off = partial(commands.set_drive_output, enabled=False)
_output_on = partial(commands.set_drive_output, enabled=True)

AXIS_FUNCTIONS = (
    _function(0x01, "reset", commands.reset, NO_DATA, "reset the axis"),
    _function(0x02, "stop", commands.stop, NO_DATA, "stop with the running deceleration"),
    _function(0x04, "emergency_stop", commands.emergency_stop, _RAMP, "stop, not weaker than now"),
    _function(0x05, "parameterized_stop", commands.parameterized_stop, _RAMP, "stop by a ramp"),
    _function(0x11, "new_end_position", commands.new_end_position, _POSITION, "change the target"),
    _function(
        0x12,
        "new_end_position_and_velocity",
        commands.new_end_position_and_velocity,
        _NEW_END_POSITION,
        "change target, velocity or both, at once or from a switch position on",
    ),
    _function(0x15, "new_dynamics", commands.new_dynamics, _DYNAMICS, "change the dynamics"),
    Service(
        0x16,
        "universal_axis_start",
        READ_WRITE,
        _UNIVERSAL_START,
        "start, stop or halt with buffer mode; answers command number and state",
        exchange=_universal_start,
        response=Layout("<HH"),
        port=501,
        non_finite=True,
    ),
    _function(0x18, "release_motion_lock", commands.release_lock, NO_DATA, "end 'stop and lock'"),
    _function(
        0x19,
        "set_external_axis_error",
        commands.set_external_error,
        UINT32,
        "put the axis into an error",
    ),
    *per_element(
        _function(
            0x1A,
            "set_actual_position",
            commands.set_actual_position,
            _POSITION,
            "give the present position another value",
            port=501,
        ),
        _function(
            0x1B,
            "set_homed_flag",
            commands.set_homed_flag,
            UINT32,
            "set or clear the homed flag",
        ),
    ),
    _function(0x20, "start", commands.start, _START, "start with the axis defaults"),
    _function(0x21, "start_extended", _start_extended, _START_EXTENDED, "start with own dynamics"),
    _function(0x50, "disable", commands.disable, NO_DATA, "disable the complete axis"),
    _function(0x51, "enable", commands.enable, NO_DATA, "enable the complete axis"),
    _function(0x60, "disable_drive_output", _output_off, NO_DATA, "drive output off"),
    _function(0x61, "enable_drive_output", _output_on, NO_DATA, "drive output on"),
)
