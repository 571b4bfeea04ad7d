"""Moves of an axis: starts, changes, stops and oscillations, 0x4200 + ID (002 §6.4.4.3)."""

from collections.abc import Callable
from typing import Any

from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands

_ROWS = named_rows(0x4200)


def _with_defaults(call: Callable[..., int]) -> Callable[..., int]:
    """Return `call` with dynamics as pairs of a flag, 1 for the default of the axis, and a value.

    Other flags than 0 and 1 are refused: 0x423B, the axis part of the start structure is invalid.
    """

    def start(axis: Axis, *arguments: Any) -> int:
        where, dynamics = arguments[:-6], arguments[-6:]
        if max(dynamics[::2]) > 1:
            return NcError.START_AXIS_DATA
        pairs = zip(dynamics[::2], dynamics[1::2], strict=True)
        return call(axis, *where, *(None if default else value for default, value in pairs))

    return start


def _universal_start(axis: Axis, arguments: Any) -> tuple[int, int]:
    """Return the command's number and state; the control mask, whose bits no manual prints, is
    unused.

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


STOPS = (
    function(_ROWS["stop"], commands.stop),
    function(_ROWS["clear"], commands.clear),
    function(_ROWS["emergency_stop"], commands.emergency_stop),
    function(_ROWS["parameterized_stop"], commands.parameterized_stop),
    function(_ROWS["oriented_stop"], commands.oriented_stop),
    function(_ROWS["release_motion_lock"], commands.release_lock),
)


OSCILLATIONS = (
    function(_ROWS["start_reversing_positioning"], commands.start_reversing),
    function(_ROWS["start_reversing_velocity_steps"], commands.start_velocity_steps),
    function(_ROWS["start_sine_oscillation"], commands.start_sine_oscillation),
)
