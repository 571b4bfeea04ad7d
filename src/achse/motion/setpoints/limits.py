"""Soft limits: how far a table or the axis itself leads, and what of that is too far.

A table ends at a soft limit before it passes it. What is not planned by a table is watched: it is
stopped as long as the strongest ramp of the axis still ends before the limit.

Kernel source, in the language of `achse.native`.
"""

from math import inf

from achse.motion.profiles.segments import segment_acceleration, segment_position, segment_velocity
from achse.motion.record import AxisFields
from achse.motion.setpoints.dynamics import fastest, fault_deceleration

TOLERANCE = 1e-6
"""Tolerance of a set position beyond a soft limit, in axis units: rounding only."""

_RELATIVE = 1e-12
_FARTHEST = 1e15


def adapt_limits(ax: AxisFields) -> None:
    """Set the limits in force; an axis that moves checks them again."""
    encoder = ax.encoder
    low = -inf
    high = inf
    if encoder.soft_limit_min_enable and encoder.soft_limit_min > -_FARTHEST:
        low = encoder.soft_limit_min
    if encoder.soft_limit_max_enable and encoder.soft_limit_max < _FARTHEST:
        high = encoder.soft_limit_max
    if low != ax.limits.low or high != ax.limits.high or fastest(ax) != ax.profile.fastest:
        ax.limits.recheck = 1
    ax.limits.low = low
    ax.limits.high = high
    ax.limits.active = 1 if low > -inf or high < inf else 0


def goes_alone(ax: AxisFields) -> bool:
    """Return True if no external set point moves the axis besides what it does by itself.

    Only then a table knows how far it leads (decision 0218).
    """
    return ax.external_setpoint_active == 0 or (
        ax.external_set.velocity == 0.0
        and ax.external.velocity == 0.0
        and ax.external.acceleration == 0.0
        and ax.external_set.position == ax.external.position
    )


def _additional_way(ax: AxisFields) -> float:
    """Signed way that a section compensation still adds to the table."""
    if ax.compensating == 0:
        return 0.0
    return ax.superposed.sign * (ax.superposed.distance - ax.superposed.position)


def lowest_rest(ax: AxisFields) -> float:
    """Return the lowest position where a profile may end."""
    more = _additional_way(ax)
    return ax.limits.low - more if more < 0.0 else ax.limits.low


def highest_rest(ax: AxisFields) -> float:
    """Return the highest position where a profile may end."""
    more = _additional_way(ax)
    return ax.limits.high - more if more > 0.0 else ax.limits.high


def _tolerance(ax: AxisFields) -> float:
    return TOLERANCE + _RELATIVE * abs(ax.set.position)


def passes(ax: AxisFields, first: int, count: int, p: float, v: float, a: float) -> int:
    """Return the limit that the segments `first` … `count` - 1 pass: 1 upper, -1 lower, 0 none.

    They begin at (p, v, a). Farther out than the axis is already counts where it is beyond.
    """
    tolerance = _tolerance(ax)
    high = highest_rest(ax)
    if ax.set.position > high:
        high = ax.set.position
    low = lowest_rest(ax)
    if ax.set.position < low:
        low = ax.set.position
    high += tolerance
    low -= tolerance
    for i in range(first, count):
        t = ax.profile.time[i]
        j = ax.profile.jerk[i]
        p = segment_position(t, j, p, v, a)
        v = segment_velocity(t, j, v, a)
        a = segment_acceleration(t, j, a)
        if p > high:
            return 1
        if p < low:
            return -1
    return 0


def table_passes(ax: AxisFields) -> int:
    """Return the limit that the rest of the present profile passes, as in `passes`."""
    return passes(
        ax,
        ax.profile.index,
        ax.profile.count,
        ax.profile.position,
        ax.profile.velocity,
        ax.profile.acceleration,
    )


def running_into(ax: AxisFields, v: float, dt: float) -> int:
    """Return the limit before which an axis at `v` must brake now: 1 upper, -1 lower, 0 not yet.

    For motions without a table: no jerk limits them, nor their stop.
    """
    return limit_ahead(ax, ax.set.position, v, ax.set.acceleration, dt)


def limit_ahead(ax: AxisFields, p: float, v: float, a: float, dt: float) -> int:
    """Return the limit before which an axis at `p` could not rest, as `running_into`."""
    sign = 1.0 if v > 0.0 else -1.0
    room = ax.limits.high - p if v > 0.0 else p - ax.limits.low
    if v == 0.0 or room == inf:
        return 0
    a *= sign
    v = abs(v)
    faster = v + a * dt if a > 0.0 else v
    rest = v * dt + faster * faster / (2.0 * fault_deceleration(ax))
    if rest <= room + TOLERANCE + _RELATIVE * abs(p):
        return 0
    return 1 if sign > 0.0 else -1
