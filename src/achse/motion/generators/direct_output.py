"""Direct output: the drive gets a velocity past the position controller (0x26 … 0x28).

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.motion.control.open_loop import follow_axis
from achse.motion.record import AxisFields


def heading(ax: AxisFields) -> float:
    """Return the direction in which the output drives the axis, by its sign."""
    return ax.direct_output


def step(ax: AxisFields, dt: float) -> None:
    """Let the set point follow the axis meanwhile."""
    follow_axis(ax)
