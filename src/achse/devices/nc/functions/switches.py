"""Switches: reset, errors from outside, enables, 0x4200 + ID (002 §6.4.4.3)."""

from functools import partial

from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import NO_DATA, UINT32
from achse.motion import commands

__all__ = ["SWITCHES"]

_output_off = partial(commands.set_drive_output, enabled=False)
_output_on = partial(commands.set_drive_output, enabled=True)

SWITCHES = (
    function(0x01, "reset", commands.reset, NO_DATA, "reset the axis"),
    function(
        0x19,
        "set_external_axis_error",
        commands.set_external_error,
        UINT32,
        "put the axis into an error",
    ),
    function(0x50, "disable", commands.disable, NO_DATA, "disable the complete axis"),
    function(0x51, "enable", commands.enable, NO_DATA, "enable the complete axis"),
    function(0x60, "disable_drive_output", _output_off, NO_DATA, "drive output off"),
    function(0x61, "enable_drive_output", _output_on, NO_DATA, "drive output on"),
)
