"""Guard of slaves: refuse a set point that is too far, too fast or too near to a soft limit.

A law may generate any set point. The guard compares it with the last one before the slave takes it:
the way of the cycle and the velocity with the fastest that axis and drive may go, and the way that
the strongest ramp needs to rest with the room before the soft limits.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes import NcError
from achse.motion.record import AxisFields
from achse.motion.setpoints.dynamics import fastest
from achse.motion.setpoints.limits import TOLERANCE, limit_ahead

ROUNDING = 1e-9
"""Part of a velocity, and way in axis units, that may be too much: rounding only."""

_RELATIVE = 1e-12


def check_step(
    ax: AxisFields, way: float, position: float, velocity: float, acceleration: float, dt: float
) -> int:
    """Return the code that refuses a set point `way` behind the last one, or 0.

    Position, velocity and acceleration are those at the end of the cycle.
    """
    limit = fastest(ax) * (1.0 + ROUNDING)
    rounding = ROUNDING + _RELATIVE * abs(position)
    if not (abs(way) <= limit * dt + rounding and abs(velocity) <= limit):
        return NcError.SET_VELOCITY_TOO_HIGH
    if ax.limits.active:
        where = limit_ahead(ax, position, velocity, acceleration, dt)
        if where > 0 or (way > 0.0 and position > ax.limits.high + TOLERANCE + rounding):
            return NcError.SOFT_LIMIT_MAX_PASSED
        if where < 0 or (way < 0.0 and position < ax.limits.low - TOLERANCE - rounding):
            return NcError.SOFT_LIMIT_MIN_PASSED
    return 0


def check_ratio(ax: AxisFields, velocity: float, acceleration: float, dt: float) -> int:
    """Return the code that refuses a new ratio to whose velocity the slave jumps, or 0.

    0x425B if the slave may not be that fast, 0x4229 for no rest before a soft limit. A ratio that
    makes the slave slower is not refused.
    """
    if abs(velocity) <= abs(ax.set.velocity) and velocity * ax.set.velocity >= 0.0:
        return 0
    way = velocity * dt
    code = check_step(ax, way, ax.set.position + way, velocity, acceleration, dt)
    if code == NcError.SET_VELOCITY_TOO_HIGH:
        return NcError.SLAVE_COUPLING_PARAMETER
    return NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS if code else 0
