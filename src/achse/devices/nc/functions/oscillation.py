"""Oscillations: reversing, velocity steps, sine, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands

__all__ = ["OSCILLATIONS"]

_ROWS = named_rows(0x4200)


OSCILLATIONS = (
    function(_ROWS["start_reversing_positioning"], commands.start_reversing),
    function(_ROWS["start_reversing_velocity_steps"], commands.start_velocity_steps),
    function(_ROWS["start_sine_oscillation"], commands.start_sine_oscillation),
)
