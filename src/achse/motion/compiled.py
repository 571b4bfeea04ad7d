"""The kernel in machine code: `cycle_all` of `achse.motion.kernel` and whatever it calls."""

from achse.kernel.compiled import Kernel
from achse.motion.kernel import cycle_all
from achse.motion.record import LAYOUT, AxisFields

__all__ = ["KERNEL"]

KERNEL = Kernel("motion", cycle_all, {AxisFields: LAYOUT})
"""Called with address and number of the records and the cycle time in seconds."""
