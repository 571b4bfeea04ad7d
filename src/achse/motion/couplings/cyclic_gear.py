"""Slave type 15: a gear ratio that the PLC gives in each cycle, and a limit to its change.

The ratio is `operation_mode_value` of the cyclic interface (fAxisModeLReal, 004 §3.1.4), or
`gear_ratio_1` while that is 0 (GearRatio1, where newer libraries write it). It begins at 0 and
changes by p_a = a_max / v_max each second at most, parameter 1. Ways count by the mean ratio of the
time in which it changes, so that they do not depend on the cycle time.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence

from achse.codes import NcError
from achse.motion.couplings.masters import (
    leading_acceleration,
    leading_jerk,
    leading_position,
    leading_velocity,
)
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows

MOST = 1e6
"""Largest ratio (002 §6.4.4.2, state 0x23); a larger one, or NaN, changes
nothing."""


def base(ax: AxisFields, rows: NcRows) -> None:
    """Count from here, with a ratio of 0."""
    ax.coupling.slave_base = ax.set.position
    ax.coupling.master_bases[0] = leading_position(ax, rows, 0)
    ax.coupling.masters_before[0] = ax.coupling.master_bases[0]
    ax.coupling.gear = 0.0
    ax.set_gear_ratio = 0.0
    ax.coupling.gear_weight = 1.0


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law."""
    turn(ax, rows, 1.0, dt)


def turn(ax: AxisFields, rows: NcRows, weight: float, dt: float) -> None:
    """Run one cycle by the ratio times `weight`, way of the slave for a way of its master."""
    goal = ax.operation_mode_value
    if goal == 0.0:
        goal = ax.gear_ratio_1
    if not abs(goal) <= MOST:
        goal = ax.coupling.gear
    before = ax.coupling.gear
    slope = ax.coupling.parameters[0]
    share = 1.0
    if goal - before > slope * dt:
        ax.coupling.gear = before + slope * dt
    elif before - goal > slope * dt:
        slope = -slope
        ax.coupling.gear = before + slope * dt
    else:
        share = abs(goal - before) / (slope * dt)
        slope = 0.0
        ax.coupling.gear = goal
    if ax.coupling.gear != before:
        ax.quiet_cycles = 0  # it does not rest
    position = leading_position(ax, rows, 0)
    v = leading_velocity(ax, rows, 0)
    ratio = ax.coupling.gear * weight
    if ax.coupling.gear == before and weight == ax.coupling.gear_weight:
        ax.set.position = ax.coupling.slave_base + ratio * (position - ax.coupling.master_bases[0])
    else:
        mean = 0.5 * (before + ax.coupling.gear) * share + ax.coupling.gear * (1.0 - share)
        mean *= 0.5 * (ax.coupling.gear_weight + weight)
        ax.set.position += mean * (position - ax.coupling.masters_before[0])
        ax.coupling.slave_base = ax.set.position
        ax.coupling.master_bases[0] = position
        ax.coupling.gear_weight = weight
    ax.coupling.masters_before[0] = position
    a = leading_acceleration(ax, rows, 0)
    ax.set.velocity = ratio * v
    ax.set.acceleration = ratio * a + slope * weight * v
    ax.set.jerk = ratio * leading_jerk(ax, rows, 0) + 2.0 * slope * weight * a
    ax.set_gear_ratio = ratio


def check(ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Parameter 1 is the limit, above 0; the others are reserved."""
    return 0 if parameters[0] > 0.0 else NcError.SLAVE_COUPLING_PARAMETER
