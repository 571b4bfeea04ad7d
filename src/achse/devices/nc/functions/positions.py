"""The origin of positions, 0x4200 + ID (002 §6.4.4.3)."""

from achse.devices.nc.binding import per_element
from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import UINT32, request
from achse.motion import commands

__all__ = ["POSITIONS"]

_POSITION = request(position_type="I", position="d")

POSITIONS = (
    *per_element(
        function(
            0x1A,
            "set_actual_position",
            commands.set_actual_position,
            _POSITION,
            "give the present position another value",
            port=501,
        ),
        function(
            0x1B,
            "set_homed_flag",
            commands.set_homed_flag,
            UINT32,
            "set or clear the homed flag",
        ),
    ),
)
