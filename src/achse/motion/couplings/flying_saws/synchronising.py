"""Slave types 5 and 6, the universal flying saw: a slave in any motion comes to its master.

Type 5 changes over to the velocity of the master in time, with the limits of the service. Type 6 is
at a place of its own when the master is at another one; its way is a polynomial of the fifth degree
over the master, from the velocity and acceleration that it has. Once it runs with the master it is
a linear coupling. What is checked before is in `sync_checks`.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence

from achse.codes import NcError
from achse.codes.axis import MotionState
from achse.motion.couplings.flying_saws.approach import (
    BY_POSITION,
    BY_TIME,
    INACTIVE,
    NO_WAY,
    SETTLING,
    begin_approach,
    check_gear,
    meet,
    run_with,
    set_gear,
)
from achse.motion.couplings.masters import leading_acceleration, leading_position, leading_velocity
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.states import SlaveType


def base(ax: AxisFields, rows: NcRows) -> None:
    """Begin where both are now; one that ran with its master and had its loop open changes over.

    Where the master is not before the place any more, the slave stays where it is.
    """
    master = rows.axes[ax.coupling.masters[0]]
    here = leading_position(ax, rows, 0)
    velocity = leading_velocity(ax, rows, 0)
    acceleration = leading_acceleration(ax, rows, 0)
    again = ax.sync.state == MotionState.SLAVE_SYNCHRONOUS
    begin_approach(ax, here, velocity, acceleration, ax.coupling.parameters[0])
    if again or ax.coupling.law == SlaveType.SYNCHRONISING_VELOCITY:
        return
    way = ax.coupling.parameters[1] - master.leading_value.offset - here
    if abs(way) < NO_WAY or way * ax.sync.heading < 0.0:
        ax.sync.method = INACTIVE
        ax.sync.state = MotionState.INACTIVE
        return
    meet(ax, way, ax.coupling.parameters[2] - ax.set.position)


def check(ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Return a slave that runs with its master, or changes over in time, takes another gear ratio.

    The service by four parameters (0x40) does not couple these types.
    """
    if ax.coupling.law not in (SlaveType.SYNCHRONISING_VELOCITY, SlaveType.SYNCHRONISING_POSITION):
        return NcError.SLAVE_TYPE
    if parameters[0] == 0.0:
        return NcError.GEAR_FACTOR_ZERO
    return NcError.SYNCHRONISING_CONDITIONS if ax.sync.method == BY_POSITION else 0


def check_change(ax: AxisFields, rows: NcRows, parameters: Sequence[float], dt: float) -> int:
    """Return the code that refuses another gear of a slave that runs with its master, or 0."""
    return check_gear(ax, rows, parameters[0], dt)


def change(ax: AxisFields, rows: NcRows) -> None:
    """Apply another gear ratio, at once if the slave runs with its master."""
    gear = ax.coupling.parameters[0]
    if ax.sync.method == BY_TIME or ax.sync.method == SETTLING:
        set_gear(ax, leading_velocity(ax, rows, 0), leading_acceleration(ax, rows, 0), gear)
    elif ax.sync.state == MotionState.SLAVE_SYNCHRONOUS:
        run_with(ax, ax.set.position, leading_position(ax, rows, 0), gear)
    else:  # it is at standstill, or comes to it, and stays there
        ax.coupling.gear = gear
        ax.set_gear_ratio = gear
