"""Slave type 1, linear: s = s0 + g · (M - M0), positions and all derivatives.

A new gear ratio acts at once: the velocity jumps, the position does not (004 §3.1.4). It is refused
if the slave would then be faster than it may, or could not stop before a soft limit.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence

from achse.codes import NcError
from achse.motion.couplings.guard import check_ratio
from achse.motion.couplings.masters import (
    leading_acceleration,
    leading_jerk,
    leading_position,
    leading_velocity,
)
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows


def base(ax: AxisFields, rows: NcRows) -> None:
    """Count from here: where the slave and its master are now."""
    ax.coupling.slave_base = ax.set.position
    ax.coupling.master_bases[0] = leading_position(ax, rows, 0)
    ax.coupling.gear = ax.coupling.parameters[0]
    ax.set_gear_ratio = ax.coupling.gear


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law."""
    ax.set.position = ax.coupling.slave_base + ax.coupling.gear * (
        leading_position(ax, rows, 0) - ax.coupling.master_bases[0]
    )
    ax.set.velocity = ax.coupling.gear * leading_velocity(ax, rows, 0)
    ax.set.acceleration = ax.coupling.gear * leading_acceleration(ax, rows, 0)
    ax.set.jerk = ax.coupling.gear * leading_jerk(ax, rows, 0)


def check(ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Parameter 1 is the gear ratio, not 0."""
    return NcError.GEAR_FACTOR_ZERO if parameters[0] == 0.0 else 0


def check_change(ax: AxisFields, rows: NcRows, parameters: Sequence[float], dt: float) -> int:
    """Return the code that refuses the velocity of the next cycle with a new ratio, or 0."""
    velocity = parameters[0] * leading_velocity(ax, rows, 0)
    return check_ratio(ax, velocity, parameters[0] * leading_acceleration(ax, rows, 0), dt)
