"""Homing and its state, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import NO_DATA, UINT32
from achse.motion import commands

__all__ = ["HOMING"]

HOMING = (
    function(0x10, "home", commands.home, NO_DATA, "home the axis as its reference mode says"),
    function(
        0x2C,
        "set_homing_state",
        commands.set_homing_state,
        UINT32,
        "show a step of a homing that the application does",
    ),
)
