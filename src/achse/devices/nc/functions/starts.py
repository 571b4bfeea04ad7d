"""Starts and changes of the running move, 0x4200 + ID (002 §6.4.4.3)."""

from collections.abc import Callable
from typing import Any

from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.layouts import NO_DATA, request
from achse.motion import Axis, commands
from achse.server import READ_WRITE, Layout, Service

__all__ = ["STARTS", "UNIVERSAL_START"]


def _with_defaults(call: Callable[..., int]) -> Callable[..., int]:
    """`call` with dynamics that each come as "take the default?" and a value."""

    def start(axis: Axis, *arguments: Any) -> int:
        where, dynamics = arguments[:-6], arguments[-6:]
        pairs = zip(dynamics[::2], dynamics[1::2], strict=True)
        return call(axis, *where, *(None if default else value for default, value in pairs))

    return start


def _universal_start(axis: Axis, arguments: Any) -> tuple[int, int]:
    """The command's number and state; the control mask, whose bits no manual prints, is unused.

    So a blending position of 0 is one that is not given, as the other optional values.
    """
    start_type, _, *others = arguments._replace(
        blending_position=arguments.blending_position or None
    )
    return numbered(axis, commands.universal_start(axis, start_type, *others))


_POSITION = request(position_type="I", position="d")
_DYNAMICS = (
    *request(acceleration="d", deceleration="d", jerk="d"),
    *request(acceleration="d", deceleration="d"),
)
_START = request(start_type="I", end_position="d", velocity="d")

_NEW_END_POSITION = request(
    command_type="I", position_type="I", position="d", velocity="d", switch_position="d"
)

_OWN_DYNAMICS = {
    "use_default_acceleration": "I", "acceleration": "d",
    "use_default_deceleration": "I", "deceleration": "d",
    "use_default_jerk": "I", "jerk": "d",
}  # fmt: skip

_START_EXTENDED = request(start_type="I", end_position="d", velocity="d", **_OWN_DYNAMICS)

_START_SPECIAL = request(
    start_type="I", end_position="d", start_velocity="d",
    velocity_change_position="d", end_velocity="d", **_OWN_DYNAMICS,
)  # fmt: skip

UNIVERSAL_START = request(
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
        "change target, velocity or both, at once or from a switch position on; 14: reached there",
    ),
    function(0x15, "new_dynamics", commands.new_dynamics, _DYNAMICS, "change the dynamics"),
    Service(
        0x16,
        "universal_axis_start",
        READ_WRITE,
        UNIVERSAL_START,
        "start, stop or halt with buffer mode; answers command number and state",
        exchange=_universal_start,
        response=Layout("<HH"),
        non_finite=True,
    ),
    function(0x29, "freeze_override", commands.freeze_override, NO_DATA, "take the override now"),
    function(0x20, "start", commands.start, _START, "start with the axis defaults"),
    function(
        0x21,
        "start_extended",
        _with_defaults(commands.start),
        _START_EXTENDED,
        "start with own dynamics",
    ),
    function(
        0x22,
        "start_special",
        _with_defaults(commands.start_special),
        _START_SPECIAL,
        "start with a second velocity from a position on",
    ),
)
