"""The NC's physics: axis records, set-point generation, position control, simulated drives.

`Nc` has the axes and steps them; `commands` are the requests to an axis; `Axis` gives access to all
of its values. Positions are in axis units, times in seconds; no module here reads a clock.

Read `kernel` first: the stages of a cycle, in their order. An axis is a record (`record`, its parts
in `fields`) that `Axis` shows from outside (`views`, `axis`, `parts`; `readout` has what no cycle
needs). `setpoints`, `generators` and `couplings` make its set point, on the mathematics of
`profiles`, `laws` and `tables`; `control` carries it out; `monitoring` supervises. Behind the I/O
(`port`) is a simulated `machine` or a `servo` drive on a bus. `groups` and `channels` move several
axes, along a `path` or by a part program.
"""

from achse.codes.axis import (
    ActualPositionType,
    BufferMode,
    CommandState,
    ControlBit,
    MotionState,
    OperationModeBit,
    StartType,
    StateBit,
)
from achse.codes.nc.choices import MotionPhase, OverrideType
from achse.motion import commands
from achse.motion.axis import Axis
from achse.motion.nc import AxisParameters, AxisParametersError, Nc
from achse.motion.states import EndPositionType, NewEndPositionCommand

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
