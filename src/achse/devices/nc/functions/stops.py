"""Stops and their lock, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands

__all__ = ["STOPS"]

_ROWS = named_rows(0x4200)


STOPS = (
    function(_ROWS["stop"], commands.stop),
    function(_ROWS["clear"], commands.clear),
    function(_ROWS["emergency_stop"], commands.emergency_stop),
    function(_ROWS["parameterized_stop"], commands.parameterized_stop),
    function(_ROWS["oriented_stop"], commands.oriented_stop),
    function(_ROWS["release_motion_lock"], commands.release_lock),
)
