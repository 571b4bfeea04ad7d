"""External set points, 0x4200 + ID (002 §6.4.4.3)."""

from typing import Any

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function, numbered
from achse.devices.nc.rows import bound
from achse.motion import Axis, commands

_ROWS = named_rows(0x4200)


def _stop_endless(axis: Axis, arguments: Any) -> tuple[int, int]:
    start_type, _, *others = arguments
    return numbered(axis, commands.stop_external_setpoint_endless(axis, start_type, *others))


EXTERNAL = (
    function(_ROWS["start_external_setpoint"], commands.start_external_setpoint),
    function(_ROWS["stop_external_setpoint"], commands.stop_external_setpoint),
    bound(_ROWS["stop_external_setpoint_continuous"], exchange=_stop_endless, non_finite=True),
)
