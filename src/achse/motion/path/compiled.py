"""The kernel in machine code: `run` of `achse.motion.path.kernel` and whatever it calls."""

from achse.motion.path.kernel import run
from achse.motion.path.record import (
    AXIS,
    JUNCTION,
    PIECE,
    POINT,
    STATE,
    PathAxis,
    PathJunction,
    PathPiece,
    PathPlace,
    PathState,
)
from achse.native.compiled import Kernel

KERNEL = Kernel(
    "path",
    run,
    {PathAxis: AXIS, PathJunction: JUNCTION, PathPiece: PIECE, PathPlace: POINT, PathState: STATE},
)
"""Called with address and number of pieces, junctions and axes, the state's address, numbers,
operation, count."""
