"""Functions about the group of an axis, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands

__all__ = ["GROUPS"]

_ROWS = named_rows(0x4200)


GROUPS = (function(_ROWS["return_to_ptp_group"], commands.return_to_ptp_group),)
