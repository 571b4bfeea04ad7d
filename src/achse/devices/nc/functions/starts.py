"""Starts and changes of the running move, 0x4200 + ID (002 §6.4.4.3)."""

from collections.abc import Callable
from typing import Any

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands

__all__ = ["STARTS"]

_ROWS = named_rows(0x4200)


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


STARTS = (
    function(_ROWS["new_end_position"], commands.new_end_position),
    function(_ROWS["new_end_position_and_velocity"], commands.new_end_position_and_velocity),
    function(_ROWS["new_dynamics"], commands.new_dynamics),
    bound(_ROWS["universal_axis_start"], exchange=_universal_start, non_finite=True),
    function(_ROWS["freeze_override"], commands.freeze_override),
    function(_ROWS["start"], commands.start),
    function(_ROWS["start_extended"], _with_defaults(commands.start)),
    function(_ROWS["start_special"], _with_defaults(commands.start_special)),
)
