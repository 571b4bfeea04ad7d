"""Axis functions, 0x4200 + ID: commands to an axis, a file for each kind of them.

Source: 002 §6.4.4.3.
"""

from achse.devices.nc.functions.couplings import COUPLINGS
from achse.devices.nc.functions.external import EXTERNAL
from achse.devices.nc.functions.groups import GROUPS
from achse.devices.nc.functions.homing import HOMING
from achse.devices.nc.functions.loops import LOOPS
from achse.devices.nc.functions.open_loop import OPEN_LOOP
from achse.devices.nc.functions.oscillation import OSCILLATIONS
from achse.devices.nc.functions.positions import POSITIONS
from achse.devices.nc.functions.probes import ENCODER_FUNCTIONS
from achse.devices.nc.functions.starts import STARTS
from achse.devices.nc.functions.stops import STOPS
from achse.devices.nc.functions.superposition import SUPERPOSITION
from achse.devices.nc.functions.switches import SWITCHES

__all__ = ["AXIS_FUNCTIONS", "ENCODER_FUNCTIONS"]

AXIS_FUNCTIONS = (
    *SWITCHES,
    *STOPS,
    *STARTS,
    *POSITIONS,
    *HOMING,
    *LOOPS,
    *GROUPS,
    *COUPLINGS,
    *SUPERPOSITION,
    *EXTERNAL,
    *OSCILLATIONS,
    *OPEN_LOOP,
)
"""All of them; the table sorts by offset."""
