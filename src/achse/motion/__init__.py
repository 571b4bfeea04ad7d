"""The NC's physics: axis records, set-point generation, position control, simulated drives.

`Nc` holds the axes and steps them; `commands` are what can be asked of an axis; `Axis` is access to
everything it shows. Positions are in axis units, times in seconds; nothing here reads a clock.
"""

from achse.motion import commands
from achse.motion.axis import Axis
from achse.motion.nc import AxisParameters, AxisParametersError, Nc
from achse.motion.states import (
    ActualPositionType,
    BufferMode,
    CommandState,
    ControlBit,
    EndPositionType,
    MotionPhase,
    MotionState,
    NewEndPositionCommand,
    OperationModeBit,
    OverrideType,
    StartType,
    StateBit,
)

__all__ = [
    "ActualPositionType",
    "Axis",
    "AxisParameters",
    "AxisParametersError",
    "BufferMode",
    "CommandState",
    "ControlBit",
    "EndPositionType",
    "MotionPhase",
    "MotionState",
    "Nc",
    "NewEndPositionCommand",
    "OperationModeBit",
    "OverrideType",
    "StartType",
    "StateBit",
    "commands",
]
