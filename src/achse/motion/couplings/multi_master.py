"""A slave of one to four masters: v = Σ g · v, reached within the dynamics of the coupling.

The ratios come in each cycle (`gear_ratio_1` … 4 of the cyclic interface). Where a new one, or the
masters, exceed the dynamics, the slave runs behind and catches up with the
velocity; from then on positions follow too: s = s0 + Σ g · (M - M0). Without a jerk limit the
velocity bends abruptly; with one, the slave is in gear again once the masters' velocities are
constant.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.motion.couplings.masters import (
    leading_acceleration,
    leading_jerk,
    leading_position,
    leading_velocity,
)
from achse.motion.profiles.profile import plan_to_velocity
from achse.motion.profiles.segments import segment_acceleration, segment_position, segment_velocity
from achse.motion.record import AxisFields
from achse.motion.rounding import JUST_ABOVE
from achse.motion.rows import NcRows

MOST = 1e6
"""Largest ratio; a larger one, or one that is not a number, changes nothing."""


def _ratio(ax: AxisFields, place: int) -> float:
    """Return the requested ratio."""
    if place == 0:
        return ax.gear_ratio_1
    if place == 1:
        return ax.gear_ratio_2
    if place == 2:
        return ax.gear_ratio_3
    return ax.gear_ratio_4


def base(ax: AxisFields, rows: NcRows) -> None:
    """Begin with the velocity that the slave has."""
    for n in range(ax.coupling.master_count):
        ax.coupling.master_bases[n] = leading_position(ax, rows, n)
    ax.coupling.slave_base = ax.set.position
    ax.coupling.in_gear = 0


def apply_ratios(ax: AxisFields) -> None:
    """Accept the ratios of the cyclic interface."""
    for n in range(ax.coupling.master_count):
        ratio = _ratio(ax, ax.coupling.ratio_places[n])
        if ratio != ax.coupling.ratios[n] and abs(ratio) <= MOST:
            ax.coupling.ratios[n] = ratio
            ax.coupling.in_gear = 0
    ax.set_gear_ratio = ax.coupling.ratios[0]


def _limit(ax: AxisFields, v: float, change: float) -> float:
    """Return the acceleration that limits a change of velocity."""
    return ax.coupling.acceleration if v * change >= 0.0 else ax.coupling.deceleration


def _bend(ax: AxisFields, goal: float, dt: float) -> int:
    """Come nearer to the goal velocity, as no jerk limits it; whether it is reached."""
    v = ax.set.velocity
    aim = goal if v * goal >= 0.0 else 0.0
    change = aim - v
    limit = _limit(ax, v, change)
    if abs(change) <= limit * dt * JUST_ABOVE:
        bending = abs(change) / limit
        ax.set.position += 0.5 * (v + aim) * bending + aim * (dt - bending)
        ax.set.velocity = aim
        ax.set.acceleration = change / dt
        return 1 if aim == goal else 0
    a = limit if change > 0.0 else -limit
    ax.set.position += dt * (v + 0.5 * a * dt)
    ax.set.velocity = v + a * dt
    ax.set.acceleration = a
    return 0


def _swing(ax: AxisFields, goal: float, dt: float) -> int:
    """Come nearer to the goal velocity along a ramp of limited jerk; whether it is reached."""
    p = ax.set.position
    v = ax.set.velocity
    a = ax.set.acceleration
    count = plan_to_velocity(
        ax.profile.time,
        ax.profile.jerk,
        v,
        a,
        goal,
        ax.coupling.acceleration,
        ax.coupling.deceleration,
        ax.coupling.jerk,
    )
    left = dt
    reached = 1
    ax.set.jerk = 0.0
    for i in range(count):
        t = ax.profile.time[i]
        if t > left:
            t = left
            reached = 0
        if t > 0.0:
            j = ax.profile.jerk[i]
            p = segment_position(t, j, p, v, a)
            v = segment_velocity(t, j, v, a)
            a = segment_acceleration(t, j, a)
            left -= t
            ax.set.jerk = 0.0 if reached else j
        if reached == 0:
            break
    if reached:
        v = goal
        a = 0.0
        p += v * left
    ax.set.position = p
    ax.set.velocity = v
    ax.set.acceleration = a
    return reached


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law."""
    apply_ratios(ax)
    way = 0.0
    goal = 0.0
    a = 0.0
    j = 0.0
    for n in range(ax.coupling.master_count):
        ratio = ax.coupling.ratios[n]
        way += ratio * (leading_position(ax, rows, n) - ax.coupling.master_bases[n])
        goal += ratio * leading_velocity(ax, rows, n)
        a += ratio * leading_acceleration(ax, rows, n)
        j += ratio * leading_jerk(ax, rows, n)
    most = ax.coupling.velocity
    capped = most > 0.0 and abs(goal) > most
    if capped:
        goal = most if goal > 0.0 else -most
        ax.coupling.in_gear = 0
    change = goal - ax.set.velocity
    if abs(change) > _limit(ax, ax.set.velocity, change) * dt * JUST_ABOVE:
        ax.coupling.in_gear = 0
    if ax.coupling.jerk > 0.0 and abs(a - ax.set.acceleration) > ax.coupling.jerk * dt * JUST_ABOVE:
        ax.coupling.in_gear = 0
    if ax.coupling.in_gear:
        ax.set.position = ax.coupling.slave_base + way
        ax.set.velocity = goal
        ax.set.acceleration = a
        ax.set.jerk = j
        return
    ax.set.jerk = 0.0
    reached = _swing(ax, goal, dt) if ax.coupling.jerk > 0.0 else _bend(ax, goal, dt)
    base(ax, rows)
    ax.coupling.in_gear = 0 if capped else reached


def change(ax: AxisFields, rows: NcRows) -> None:
    """Accept new ratios of the service (0x42) as if the cyclic interface had brought them."""
    ax.gear_ratio_1 = ax.coupling.parameters[0]
    ax.gear_ratio_2 = ax.coupling.parameters[1]
    ax.gear_ratio_3 = ax.coupling.parameters[2]
    ax.gear_ratio_4 = ax.coupling.parameters[3]
    apply_ratios(ax)
