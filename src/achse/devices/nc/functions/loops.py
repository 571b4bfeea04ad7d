"""Switching of control loops, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands

__all__ = ["LOOPS"]

_ROWS = named_rows(0x4200)

LOOPS = (function(_ROWS["switch_control_loop"], commands.switch_control_loop),)
