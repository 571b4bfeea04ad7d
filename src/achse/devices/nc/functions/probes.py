"""Functions of an encoder, 0x5200 + ID: its position and its touch probes (002 §6.4.5.3).

Latches are activated and let go without data for the first of them, with four flags for four
(CANopen), or one by one as touch probes.
"""

from functools import partial

from achse.devices.nc.functions.calling import function
from achse.devices.nc.functions.positions import POSITION_REQUEST
from achse.devices.nc.layouts import NO_DATA, NOTHING, REAL64
from achse.motion import commands
from achse.motion.parts import AxisEncoder
from achse.server import Layout

__all__ = ["ENCODER_FUNCTIONS"]

_FOUR_FLAGS = Layout("<4I")

_PROBE_AND_EDGE = 2


def _deactivate(encoder: AxisEncoder, *data: int) -> int:
    if len(data) == _PROBE_AND_EDGE:
        return commands.deactivate_touch_probe(encoder, *data)
    return commands.deactivate_latch(encoder, *data)


ENCODER_FUNCTIONS = (
    function(
        0x1A,
        "set_actual_position",
        commands.set_actual_position,
        POSITION_REQUEST,
        "give the present position another value",
    ),
    function(
        0x1B,
        "reinitialize_actual_position",
        commands.reinitialize_actual_position,
        NO_DATA,
        "take an absolute position from the hardware again",
    ),
    function(
        0x200,
        "activate_touch_probe",
        commands.activate_touch_probe,
        Layout("<4I8x"),
        "have a touch probe wait for an edge: unit, edge, mode, source",
    ),
    function(
        0x201,
        "activate_latch_rising",
        partial(commands.activate_latch, falling=False),
        (NOTHING, _FOUR_FLAGS),
        "have latches wait for a rising edge",
    ),
    function(
        0x202,
        "activate_latch_falling",
        partial(commands.activate_latch, falling=True),
        (NOTHING, _FOUR_FLAGS),
        "have latches wait for a falling edge",
    ),
    function(
        0x205,
        "deactivate_touch_probe",
        _deactivate,
        (NOTHING, _FOUR_FLAGS, Layout("<2I16x")),
        "have a touch probe, or latches, wait no longer",
    ),
    function(
        0x210,
        "set_latch_event",
        commands.set_latch_event,
        REAL64,
        "let the first latch latch this position; simulated encoders",
    ),
)
