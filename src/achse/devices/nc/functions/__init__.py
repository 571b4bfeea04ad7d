"""Axis functions, 0x4200 + ID: commands to an axis, a file for each kind of them.

Source: 002 §6.4.4.3.

Read `moves` first. `calling` is how a row becomes a call of `achse.motion.commands`; the others are
kinds of commands.
"""

from achse.devices.nc.functions.couplings import COUPLINGS, GROUPS
from achse.devices.nc.functions.external import EXTERNAL
from achse.devices.nc.functions.moves import OSCILLATIONS, STARTS, STOPS
from achse.devices.nc.functions.open_loop import LOOPS, OPEN_LOOP
from achse.devices.nc.functions.positions import HOMING, POSITIONS
from achse.devices.nc.functions.probes import ENCODER_FUNCTIONS
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
