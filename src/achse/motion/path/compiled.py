"""The kernel in machine code: `run` of `achse.motion.path.kernel` and whatever it calls."""

from achse.motion.path.kernel import run
from achse.motion.path.record import (
    AXIS,
    ELEMENT,
    JUNCTION,
    POINT,
    STATE,
    PathAxis,
    PathElement,
    PathJunction,
    PathPlace,
    PathState,
)
from achse.native.compiled import Kernel

KERNEL = Kernel(
    "path",
    run,
    {
        PathAxis: AXIS,
        PathJunction: JUNCTION,
        PathElement: ELEMENT,
        PathPlace: POINT,
        PathState: STATE,
    },
)
"""Called with address and number of elements, junctions and axes, the state's address, numbers,
operation, count."""
