"""Phasing: the shift by which a slave sees its master runs along a jerk-limited profile.

The shift stays until the next phasing changes it. It moves an axis only through a coupling.

Kernel source, in the language of `achse.native`.
"""

from achse.motion.features import Feature
from achse.motion.profiles.segments import segment_acceleration, segment_position, segment_velocity
from achse.motion.record import AxisFields


def shift_phase(ax: AxisFields, dt: float) -> None:
    """Run one cycle of the running profile; at its end the shift is exactly the target."""
    if not ax.phasing.active:
        ax.features &= ~Feature.PHASING
        return
    p = ax.phasing.position
    v = ax.phasing.velocity
    a = ax.phasing.acceleration
    left = dt
    while left > 0.0 and ax.phasing.index < ax.phasing.count:
        i = ax.phasing.index
        j = ax.phasing.jerk[i]
        t = ax.phasing.time[i] - ax.phasing.elapsed
        if t > left:
            t = left
            ax.phasing.elapsed += left
        else:
            ax.phasing.index = i + 1
            ax.phasing.elapsed = 0.0
        p = segment_position(t, j, p, v, a)
        v = segment_velocity(t, j, v, a)
        a = segment_acceleration(t, j, a)
        left -= t
    if left > 0.0:
        p = ax.phasing.target
        v = 0.0
        a = 0.0
        ax.phasing.active = 0
    ax.phasing.position = p
    ax.phasing.velocity = v
    ax.phasing.acceleration = a
