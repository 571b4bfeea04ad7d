"""Functions of an encoder, 0x5200 + ID: its position and its touch probes (002 §6.4.5.3).

Latches are activated and let go without data for the first of them, with four flags for four
(CANopen), or one by one as touch probes.
"""

from functools import partial

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands
from achse.motion.parts import AxisEncoder

_ROWS = named_rows(0x5200)


_PROBE_AND_EDGE = 2


def _deactivate(encoder: AxisEncoder, *data: int) -> int:
    if len(data) == _PROBE_AND_EDGE:
        return commands.deactivate_touch_probe(encoder, *data)
    return commands.deactivate_latch(encoder, *data)


ENCODER_FUNCTIONS = (
    function(_ROWS["set_actual_position"], commands.set_actual_position),
    function(_ROWS["reinitialize_actual_position"], commands.reinitialize_actual_position),
    function(_ROWS["activate_touch_probe"], commands.activate_touch_probe),
    function(_ROWS["activate_latch_rising"], partial(commands.activate_latch, falling=False)),
    function(_ROWS["activate_latch_falling"], partial(commands.activate_latch, falling=True)),
    function(_ROWS["deactivate_touch_probe"], _deactivate),
    function(_ROWS["set_latch_event"], commands.set_latch_event),
)
