"""Open loop: while no position is controlled the set point follows the axis.

So the position loop takes over smoothly whenever it comes back: by a stop, by a motion command or
because an error brakes the axis.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.motion.control.drive import fill_filter
from achse.motion.record import AxisFields


def follow_axis(ax: AxisFields) -> None:
    """Put the set point, and the output filter, to the axis' position and velocity."""
    ax.profile.abrupt = 1
    ax.set.position = ax.encoder.actual_position
    ax.set.velocity = ax.encoder.actual_velocity
    ax.set.acceleration = 0.0
    ax.set.jerk = 0.0
    ax.target_position = ax.set.position
    ax.profile.override = ax.velocity_override
    if ax.drive.filter_count > 0:
        fill_filter(ax, ax.drive)
