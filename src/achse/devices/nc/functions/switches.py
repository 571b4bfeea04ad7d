"""Switches: reset, errors from outside, enables, 0x4200 + ID (002 §6.4.4.3)."""

from functools import partial

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.motion import commands

_ROWS = named_rows(0x4200)

_output_off = partial(commands.set_drive_output, enabled=False)
_output_on = partial(commands.set_drive_output, enabled=True)

SWITCHES = (
    function(_ROWS["reset"], commands.reset),
    function(_ROWS["set_external_axis_error"], commands.set_external_error),
    function(_ROWS["disable"], commands.disable),
    function(_ROWS["enable"], commands.enable),
    function(_ROWS["disable_drive_output"], _output_off),
    function(_ROWS["enable_drive_output"], _output_on),
)
