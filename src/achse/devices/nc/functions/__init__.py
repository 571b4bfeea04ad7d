"""Axis functions, 0x4200 + ID: commands to an axis, a file for each kind of them.

Source: 002 §6.4.4.3.
"""

from achse.devices.nc.functions.positions import POSITIONS
from achse.devices.nc.functions.starts import STARTS
from achse.devices.nc.functions.stops import STOPS
from achse.devices.nc.functions.switches import SWITCHES

__all__ = ["AXIS_FUNCTIONS"]

AXIS_FUNCTIONS = (*SWITCHES, *STOPS, *STARTS, *POSITIONS)
"""All of them; the table sorts by offset."""
