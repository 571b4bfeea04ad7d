"""Coupled: the axis has no motion of its own; a law makes its set point later in the cycle.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes.nc.choices import MotionPhase
from achse.motion.record import AxisFields


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle: nothing to do; without a coupling the axis rests."""
    if ax.coupling.law == 0:
        ax.set_motion_phase = MotionPhase.NONE
