"""Switching of control loops, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import function
from achse.motion import commands
from achse.server import Layout

__all__ = ["LOOPS"]

LOOPS = (
    function(
        0x52,
        "switch_control_loop",
        commands.switch_control_loop,
        (Layout("<IIdI"), Layout("<IIdI4x")),
        "go over to another encoder, controller and drive of the axis",
    ),
)
