"""Slave types 2 and 3, flying saws: the slave waits for its master, then runs with it.

With positions (004 §3.1.4) the slave rests until the master is twice the slave's way before the
place where both meet, and then gains its velocity: as a line (type 2) or without a jump of its
acceleration (type 3). Type 2 without positions changes over to the velocity at once, by the
dynamics of the axis (002 §6.4.9). A flying saw at an angle to its master is faster by 1 / sin
angle; 90 degrees are along the master.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence
from math import sin

from achse.codes import NcError
from achse.codes.axis import MotionState
from achse.motion.couplings.flying_saws.approach import (
    BY_POSITION,
    BY_TIME,
    INACTIVE,
    LINEAR,
    NO_WAY,
    SETTLING,
    begin_approach,
    check_gear,
    follow_approach,
    heading_of,
    run_with,
    set_gear,
    weak_ramp,
)
from achse.motion.couplings.masters import (
    as_leader,
    leading_acceleration,
    leading_position,
    leading_velocity,
)
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.states import SlaveType

_DEGREE = 0.017453292519943295
_ALONG = 90.0
_LEAST_ANGLE = 1e-6  # nearer to the normal of the path no slave keeps up with its master
_LARGEST_GEAR = 1e6


def _gear(parameters: Sequence[float]) -> float:
    """Velocity of the slave by that of the master; a gear of 0 is 1."""
    gear = parameters[3]
    if gear == 0.0:
        gear = 1.0
    if parameters[2] == _ALONG:
        return gear
    return gear / sin(parameters[2] * _DEGREE)


def _by_velocity(slave_type: int, parameters: Sequence[float]) -> bool:
    """Return True if the slave synchronises with the velocity alone."""
    return (
        slave_type == SlaveType.FLYING_SAW_VELOCITY
        and parameters[0] == 0.0
        and parameters[1] == 0.0
    )


def base(ax: AxisFields, rows: NcRows) -> None:
    """Begin: wait for the master, or change over to its velocity; so does one that ran with its
    master and had its loop open.

    Where the master is too far already, the slave stays where it is.
    """
    master = rows.axes[ax.coupling.masters[0]]
    here = leading_position(ax, rows, 0)
    velocity = leading_velocity(ax, rows, 0)
    acceleration = leading_acceleration(ax, rows, 0)
    gear = _gear(ax.coupling.parameters)
    again = ax.sync.state == MotionState.SLAVE_SYNCHRONOUS
    ax.sync.mask = 0
    ax.sync.velocity = ax.max_velocity
    ax.sync.acceleration = ax.default_acceleration
    ax.sync.deceleration = ax.default_deceleration
    ax.sync.jerk = ax.default_jerk
    begin_approach(ax, here, velocity, acceleration, gear)
    if again or _by_velocity(ax.coupling.law, ax.coupling.parameters):
        return
    length = 2.0 * (ax.coupling.parameters[1] - ax.set.position) / gear
    heading = 1.0 if length > 0.0 else -1.0
    begin = ax.coupling.parameters[0] - master.leading_value.offset - length
    if heading * length < NO_WAY or (here - begin) * heading > 0.0:
        ax.sync.method = INACTIVE
        ax.sync.state = MotionState.INACTIVE
        return
    ax.sync.method = BY_POSITION
    ax.sync.state = MotionState.SLAVE_PREPHASE
    ax.sync.begin = begin
    ax.sync.heading = heading
    ax.sync.count = 1
    ax.sync.length[0] = heading * length
    smooth = ax.coupling.law == SlaveType.FLYING_SAW_POSITION
    weak_ramp(ax.sync.terms, 0, heading * length, heading * gear, smooth)


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law; a phase shift of the slave moves what it sees of the master."""
    master = rows.axes[ax.coupling.masters[0]]
    velocity = leading_velocity(ax, rows, 0)
    acceleration = leading_acceleration(ax, rows, 0)
    follow_approach(ax, master, leading_position(ax, rows, 0), velocity, acceleration, dt)


def _check(
    slave_type: int, ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]
) -> int:
    """The angle is above 0 and not above 90 degrees; the master has to be before where it begins.

    A slave on its way by position accepts no other parameters; one that runs with its master takes
    another gear alone.
    """
    angle = parameters[2]
    if not _LEAST_ANGLE <= angle <= _ALONG or abs(_gear(parameters)) > _LARGEST_GEAR:
        return NcError.SLAVE_COUPLING_PARAMETER
    if ax.coupling.law:
        if ax.sync.method in (LINEAR, BY_TIME, SETTLING):
            return 0
        if ax.sync.state == MotionState.SLAVE_SYNCHRONISING:
            return NcError.SYNCHRONISING_CONDITIONS
    if _by_velocity(slave_type, parameters):
        return 0
    master = as_leader(masters[0])
    length = 2.0 * (parameters[1] - ax.set.position) / _gear(parameters)
    heading = heading_of(master.leading_value.velocity + ax.phasing.velocity) or 1.0
    begin = parameters[0] - master.leading_value.offset - length
    here = master.leading_value.position + ax.phasing.position
    if length * heading < NO_WAY or (here - begin) * heading > 0.0:
        return NcError.SLAVE_COUPLING_PARAMETER
    return 0


def check_velocity(
    ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]
) -> int:
    """Type 2, see `_check`."""
    return _check(SlaveType.FLYING_SAW_VELOCITY, ax, masters, parameters)


def check_position(
    ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]
) -> int:
    """Type 3, see `_check`."""
    return _check(SlaveType.FLYING_SAW_POSITION, ax, masters, parameters)


def check_change(ax: AxisFields, rows: NcRows, parameters: Sequence[float], dt: float) -> int:
    """Return the code that refuses another gear of a slave that runs with its master, or 0."""
    return check_gear(ax, rows, _gear(parameters), dt)


def change(ax: AxisFields, rows: NcRows) -> None:
    """Apply new parameters: another gear acts at once; a waiting slave waits by the new ones."""
    gear = _gear(ax.coupling.parameters)
    if ax.sync.method == LINEAR:
        run_with(ax, ax.set.position, leading_position(ax, rows, 0), gear)
    elif ax.sync.method == BY_TIME or ax.sync.method == SETTLING:
        set_gear(ax, leading_velocity(ax, rows, 0), leading_acceleration(ax, rows, 0), gear)
    else:
        base(ax, rows)
