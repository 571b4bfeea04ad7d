"""Couplings of an axis and its group, 0x4200 + ID (002 §6.4.4.3)."""

from typing import Any

from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.functions.cams import CAMS
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands

_ROWS = named_rows(0x4200)

_FIELDS_OF_ONE = 8


def _couple(axis: Axis, *request: Any) -> int:
    """Couple an axis to one master or to several, by the length of the request."""
    slave_type, *masters = request[:7]
    if len(request) == _FIELDS_OF_ONE:
        return commands.couple(axis, slave_type, *request[1:])
    if masters[1] or masters[2] or any(request[7:11]):
        return NcError.SLAVE_COUPLING_PARAMETER
    acceleration, dynamics = request[12], request[15:18]
    return commands.couple_to_several(
        axis, slave_type, (masters[0], *masters[3:]), acceleration, *dynamics
    )


def _decouple(axis: Axis, *follow_up: float) -> int:
    if not follow_up:
        return commands.decouple(axis)
    decoupling_type, *others = follow_up
    return commands.decouple_with_follow_up(axis, int(decoupling_type), *others)


def _decouple_and_start(axis: Axis, arguments: Any) -> tuple[int, int]:
    """As the universal start: the mask is unused, a blending position of 0 is not given."""
    start_type, _, *others = arguments._replace(
        blending_position=arguments.blending_position or None
    )
    return numbered(axis, commands.decouple_and_start(axis, start_type, *others))


COUPLINGS = (
    function(_ROWS["couple"], _couple),
    function(_ROWS["decouple"], _decouple),
    function(_ROWS["change_coupling_parameters"], commands.change_coupling),
    function(_ROWS["stop_slave"], commands.stop_slave),
    *CAMS,
    function(_ROWS["couple_universal_flying_saw"], commands.synchronise),
    bound(
        _ROWS["decouple_and_universal_axis_start"], exchange=_decouple_and_start, non_finite=True
    ),
)


GROUPS = (function(_ROWS["return_to_ptp_group"], commands.return_to_ptp_group),)
