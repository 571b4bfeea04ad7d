"""Homing, the origin of positions and the scaling, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.table import named_rows
from achse.devices.nc.functions.calling import function
from achse.devices.nc.rows import per_encoder
from achse.motion import commands

_ROWS = named_rows(0x4200)


POSITIONS = (
    *per_encoder(
        function(_ROWS["set_actual_position"], commands.set_actual_position),
        function(_ROWS["set_homed_flag"], commands.set_homed_flag),
        function(_ROWS["set_actual_position_only"], commands.set_actual_position_only),
        function(_ROWS["set_actual_position_in_drive"], commands.set_actual_position_in_drive),
        function(_ROWS["set_encoder_scaling_factor"], commands.set_encoder_scaling_factor),
        function(_ROWS["set_actual_position_on_the_fly"], commands.set_actual_position_on_the_fly),
        function(_ROWS["reinitialize_encoder"], commands.reinitialize_encoder),
    ),
)


HOMING = (
    function(_ROWS["home"], commands.home),
    function(_ROWS["set_homing_state"], commands.set_homing_state),
)
