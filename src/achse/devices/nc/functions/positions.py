"""The origin of positions and the scaling, 0x4200 + ID per encoder (002 §6.4.4.3)."""

from achse.devices.nc.binding import per_encoder
from achse.devices.nc.functions.calling import function
from achse.devices.nc.layouts import NO_DATA, UINT32, request
from achse.motion import commands
from achse.server import Layout

__all__ = ["POSITIONS", "POSITION_REQUEST"]

POSITION_REQUEST = request(position_type="I", position="d")

POSITIONS = (
    *per_encoder(
        function(
            0x1A,
            "set_actual_position",
            commands.set_actual_position,
            POSITION_REQUEST,
            "give the present position another value",
        ),
        function(
            0x1B,
            "set_homed_flag",
            commands.set_homed_flag,
            UINT32,
            "set or clear the homed flag",
        ),
        function(
            0x1C,
            "set_actual_position_only",
            commands.set_actual_position_only,
            POSITION_REQUEST,
            "give the actual position another value, not the set position",
        ),
        function(
            0x1D,
            "set_actual_position_in_drive",
            commands.set_actual_position_in_drive,
            POSITION_REQUEST,
            "have a CANopen drive with position interface count from another number",
        ),
        function(
            0x1E,
            "set_encoder_scaling_factor",
            commands.set_encoder_scaling_factor,
            request(scaling_type="H", control_word="H", factor="d"),
            "change the scaling: 1 positions too, 2 from the present position on",
        ),
        function(
            0x1F,
            "set_actual_position_on_the_fly",
            commands.set_actual_position_on_the_fly,
            Layout("<II8xd8x"),
            "give the present position another value while the axis moves",
        ),
        function(
            0x3B,
            "reinitialize_encoder",
            commands.reinitialize_encoder,
            NO_DATA,
            "take the position from the hardware again",
        ),
    ),
)
