"""Starts and changes of the running move, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import carry_out, function
from achse.devices.nc.layouts import request
from achse.motion import Axis, CommandState, commands
from achse.server import READ_WRITE, Layout, Service

__all__ = ["STARTS"]


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
    carry_out(commands.universal_start(axis, int(start_type), *others))  # type: ignore[arg-type]
    number = axis.command_counter
    active = axis.set_command_number == number
    return number, axis.set_command_state if active else CommandState.BUFFERED


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

STARTS = (
    function(0x11, "new_end_position", commands.new_end_position, _POSITION, "change the target"),
    function(
        0x12,
        "new_end_position_and_velocity",
        commands.new_end_position_and_velocity,
        _NEW_END_POSITION,
        "change target, velocity or both, at once or from a switch position on",
    ),
    function(0x15, "new_dynamics", commands.new_dynamics, _DYNAMICS, "change the dynamics"),
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
    function(0x20, "start", commands.start, _START, "start with the axis defaults"),
    function(0x21, "start_extended", _start_extended, _START_EXTENDED, "start with own dynamics"),
)
