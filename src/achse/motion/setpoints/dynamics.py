"""The ramps of an axis: what a fault brakes with, and how a weaker jerk takes over.

The acceleration that an axis has was made with the *running* jerk; only that jerk, or a stronger
one, takes it away in time. A command with less jerk begins with a release: the running jerk brings
the acceleration down to what the new jerk can take away, then the new jerk holds.

Kernel source, in the language of `achse.native`.
"""

from math import sqrt

from achse.motion.profiles.segments import segment_acceleration, segment_position, segment_velocity
from achse.motion.record import AxisFields
from achse.motion.rounding import JUST_BELOW

STEEPEST = 1e12
"""Strongest deceleration and jerk that the planner takes; as a jerk it is not a limit."""


def fastest(ax: AxisFields) -> float:
    """Largest velocity that the axis may have: its maximum, or what its drive can do."""
    limit = ax.max_velocity
    if ax.drive.reference_velocity < limit:
        limit = ax.drive.reference_velocity
    return limit


def fault_deceleration(ax: AxisFields) -> float:
    """Strongest deceleration of the axis: of command, table, default and fast axis stop."""
    default = ax.default_deceleration
    if default > ax.max_deceleration:
        default = ax.max_deceleration
    deceleration = ax.job.deceleration
    if ax.profile.deceleration > deceleration:
        deceleration = ax.profile.deceleration
    if default > deceleration:
        deceleration = default
    if ax.fast_axis_stop_deceleration > deceleration:
        deceleration = ax.fast_axis_stop_deceleration
    return deceleration if deceleration < STEEPEST else STEEPEST


def fault_jerk(ax: AxisFields) -> float:
    """Strongest jerk of the axis: of command, table, default and fast axis stop, or running."""
    jerk = ax.job.jerk
    if ax.profile.jerk_limit > jerk:
        jerk = ax.profile.jerk_limit
    if ax.profile.running_jerk > jerk:
        jerk = ax.profile.running_jerk
    if ax.default_jerk > jerk:
        jerk = ax.default_jerk
    if ax.fast_axis_stop_jerk > jerk:
        jerk = ax.fast_axis_stop_jerk
    return jerk if jerk < STEEPEST else STEEPEST


def run_out(ax: AxisFields) -> float:
    """Velocity that an axis reaches while its acceleration is taken away as it was made."""
    v = ax.set.velocity
    a = ax.set.acceleration
    if a * v < 0.0 or a == 0.0 or ax.profile.running_jerk <= 0.0:
        return v
    way = a * a / (2.0 * ax.profile.running_jerk)
    return v + way if a > 0.0 else v - way


def drop_foreign(ax: AxisFields, foreign: float) -> None:
    """End a part of the set acceleration that no jerk limits.

    What makes the axis faster ends at once; what makes it slower is taken away before rest.
    """
    v = ax.set.velocity
    if foreign * v >= 0.0:
        ax.set.acceleration -= foreign
    elif ax.set.acceleration * v < 0.0:
        steep = ax.set.acceleration * ax.set.acceleration / abs(v)
        if steep > 2.0 * ax.profile.running_jerk:
            ax.profile.running_jerk = steep


def shed_foreign(ax: AxisFields, foreign: float) -> None:
    """End a part of the set acceleration that has steps by its nature; its velocity stays.

    What makes the axis faster ends at once. Of a deceleration, what the running jerk could not take
    away before rest ends at once, too; so what comes then keeps that jerk.
    """
    v = ax.set.velocity
    if foreign * v >= 0.0:
        ax.set.acceleration -= foreign
    a = ax.set.acceleration
    most = JUST_BELOW * sqrt(2.0 * ax.profile.running_jerk * abs(v))
    if a * v < 0.0 and abs(a) > most:
        ax.set.acceleration = most if a > 0.0 else -most


def shed_excess(ax: AxisFields, jerk: float) -> int:
    """End what of an acceleration `jerk` cannot take away below the fastest velocity; 1 if it did.

    A group of axes may command any acceleration; an axis that leaves it has its limits again.
    """
    v = ax.set.velocity
    a = ax.set.acceleration
    if ax.profile.running_jerk > jerk:
        jerk = ax.profile.running_jerk
    room = fastest(ax) - abs(v)
    if a * v <= 0.0 or a * a <= 2.0 * jerk * room:
        return 0
    most = sqrt(2.0 * jerk * room) if room > 0.0 else 0.0
    ax.set.acceleration = most if a > 0.0 else -most
    return 1


def release(ax: AxisFields, jerk: float) -> float:
    """Put the state from which `jerk` holds into `plan_…`; the time until then, often 0.

    An acceleration in the direction of travel is taken away whole: no command makes an axis faster
    than its present acceleration does anyway. A deceleration stays as far as `jerk` can take
    it away before rest.
    """
    v = ax.set.velocity
    a = ax.set.acceleration
    ax.profile.plan_position = ax.set.position
    ax.profile.plan_velocity = v
    ax.profile.plan_acceleration = a
    running = ax.profile.running_jerk
    if a == 0.0 or jerk >= running * JUST_BELOW:
        return 0.0
    size = abs(a)
    rest = 0.0
    if v * a < 0.0:
        square = a * a
        if square <= 2.0 * jerk * abs(v):
            return 0.0
        left = jerk * (2.0 * running * abs(v) - square) / (running - jerk)
        if left > 0.0:
            rest = JUST_BELOW * sqrt(left)
    time = (size - rest) / running
    if time <= 0.0:
        return 0.0
    j = -running if a > 0.0 else running
    ax.profile.plan_position = segment_position(time, j, ax.set.position, v, a)
    ax.profile.plan_velocity = segment_velocity(time, j, v, a)
    ax.profile.plan_acceleration = 0.0
    if rest > 0.0:
        ax.profile.plan_acceleration = segment_acceleration(time, j, a)
    return time
