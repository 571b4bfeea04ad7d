"""Commands to an axis: checked here, carried out from the next cycle on.

Each function answers 0 or the number of the NC error that refuses it (`NcError`); a refused command
changes nothing. Functions carry the index offset of 0x4200 + axis id that they stand for (002
§6.4.4.3). Positions are in axis units, velocities per second; acceleration, deceleration and jerk
of 0 mean the axis default.
"""

from achse.motion.commands.changes import (
    new_dynamics,
    new_end_position,
    new_end_position_and_velocity,
)
from achse.motion.commands.positions import set_actual_position, set_homed_flag
from achse.motion.commands.starts import start, universal_start
from achse.motion.commands.stops import (
    emergency_stop,
    parameterized_stop,
    release_lock,
    stop,
    stop_information,
)
from achse.motion.commands.switches import (
    disable,
    enable,
    reset,
    set_drive_output,
    set_external_error,
)

__all__ = [
    "disable",
    "emergency_stop",
    "enable",
    "new_dynamics",
    "new_end_position",
    "new_end_position_and_velocity",
    "parameterized_stop",
    "release_lock",
    "reset",
    "set_actual_position",
    "set_drive_output",
    "set_external_error",
    "set_homed_flag",
    "start",
    "stop",
    "stop_information",
    "universal_start",
]
