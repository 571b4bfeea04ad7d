"""Homing and its state, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands

__all__ = ["HOMING"]

_ROWS = named_rows(0x4200)

HOMING = (
    function(_ROWS["home"], commands.home),
    function(_ROWS["set_homing_state"], commands.set_homing_state),
)
