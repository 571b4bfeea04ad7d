"""Slave type 16, bi-linear: s = s0 + g1 · (M1 - M10) + g2 · (M2 - M20), for example to tap threads.

The slave has set values only while master 1 moves logically: it has a job, at override 0 too, or
its set point moves. Else the slave is at standstill, whatever master 2 does, and counts from there.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
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
    """Count from here: where the slave and both masters are now."""
    ax.coupling.slave_base = ax.set.position
    ax.coupling.master_bases[0] = leading_position(ax, rows, 0)
    ax.coupling.master_bases[1] = leading_position(ax, rows, 1)
    ax.coupling.gear = ax.coupling.parameters[0]
    ax.set_gear_ratio = ax.coupling.gear


def _moves(ax: AxisFields, rows: NcRows) -> int:
    """Return 1 if master 1 moves logically, else 0."""
    phase = rows.axes[ax.coupling.masters[0]].set_motion_phase
    if phase != MotionPhase.NONE and phase != MotionPhase.COUPLED:
        return 1
    return 1 if leading_velocity(ax, rows, 0) != 0.0 else 0


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law."""
    moves = _moves(ax, rows)
    first = ax.coupling.parameters[0]
    second = ax.coupling.parameters[1]
    if moves or ax.coupling.master_moved:  # the last part of its way, too
        ax.set.position = (
            ax.coupling.slave_base
            + first * (leading_position(ax, rows, 0) - ax.coupling.master_bases[0])
            + second * (leading_position(ax, rows, 1) - ax.coupling.master_bases[1])
        )
        ax.set.velocity = first * leading_velocity(ax, rows, 0) + second * leading_velocity(
            ax, rows, 1
        )
        ax.set.acceleration = first * leading_acceleration(ax, rows, 0)
        ax.set.acceleration += second * leading_acceleration(ax, rows, 1)
        ax.set.jerk = first * leading_jerk(ax, rows, 0)
        ax.set.jerk += second * leading_jerk(ax, rows, 1)
    if moves == 0:
        ax.set.velocity = 0.0
        ax.set.acceleration = 0.0
        ax.set.jerk = 0.0
        base(ax, rows)
    ax.coupling.master_moved = moves


def check(ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Parameters 1 and 2 are the gear ratios, not 0; parameter 3 is the id of master 2."""
    if parameters[0] == 0.0 or parameters[1] == 0.0:
        return NcError.GEAR_FACTOR_ZERO
    return NcError.SLAVE_COUPLING_PARAMETER if masters[0] == masters[1] else 0


def check_change(ax: AxisFields, rows: NcRows, parameters: Sequence[float], dt: float) -> int:
    """Return the code that refuses the velocity of the next cycle with new ratios, or 0."""
    if _moves(ax, rows) == 0:
        return 0
    first, second = parameters[0], parameters[1]
    velocity = first * leading_velocity(ax, rows, 0) + second * leading_velocity(ax, rows, 1)
    acceleration = first * leading_acceleration(ax, rows, 0)
    acceleration += second * leading_acceleration(ax, rows, 1)
    return check_ratio(ax, velocity, acceleration, dt)


def others(parameters: Sequence[float]) -> tuple[float, ...]:
    """Id of master 2."""
    return (parameters[2],)
