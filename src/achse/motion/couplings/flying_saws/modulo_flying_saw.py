"""Slave type 12, flying saw of modulo axes: the slave turns with its master, at the same angle.

It comes there on the shortest way, half a period at most, with a share of its acceleration
(004 §3.1.4). Parameter 1 commands its operation, at any time: rest (0), turn with its master
(1), turn with its second master (2); it changes over from whatever it does.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence
from math import floor

from achse.codes import NcError
from achse.codes.axis import MotionState
from achse.codes.nc.choices import AxisType
from achse.motion.couplings.flying_saws.approach import (
    LINEAR,
    begin_approach,
    follow_approach,
    run_with,
)
from achse.motion.couplings.flying_saws.chase import approach_place, settle_place
from achse.motion.couplings.masters import (
    leading_acceleration,
    leading_jerk,
    leading_position,
    leading_velocity,
)
from achse.motion.profiles.profile import stopping_distance
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows

_TO_PLACE = 5
"""The slave goes to its place beside the master; other methods are those of `approach`."""
_SETTLING_THERE = 7
"""It has the velocity of a master that trembles, and takes what is left of the way."""

_LEFT = 0.05
"""Share of the largest velocity that is left for the way to the place."""

_REST = 0.0
_SECOND = 2.0


def _leader(ax: AxisFields) -> int:
    """Return the number of the master that the slave follows."""
    return 1 if ax.coupling.parameters[0] == _SECOND else 0


def base(ax: AxisFields, rows: NcRows) -> None:
    """Begin from what the slave does: the place beside the master is the nearest to where it would
    have its velocity."""
    leader = _leader(ax)
    place = leading_position(ax, rows, leader)
    velocity = leading_velocity(ax, rows, leader)
    acceleration = leading_acceleration(ax, rows, leader)
    limit = ax.default_acceleration
    if ax.default_deceleration < limit:
        limit = ax.default_deceleration
    limit *= ax.coupling.parameters[1]
    ax.sync.mask = 0
    ax.sync.acceleration = limit
    ax.sync.deceleration = limit
    ax.sync.jerk = ax.default_jerk
    ax.sync.velocity = ax.max_velocity
    if ax.coupling.parameters[0] == _REST:
        begin_approach(ax, place, velocity, acceleration, 0.0)
        return
    begin_approach(ax, place, velocity, acceleration, 1.0)
    relative = ax.set.velocity - velocity
    bend = ax.set.acceleration
    if rows.axes[ax.coupling.masters[leader]].axis_type != AxisType.ENCODER:
        bend -= acceleration
    offset = ax.set.position - (place + rows.axes[ax.coupling.masters[leader]].leading_value.offset)
    beside = offset + stopping_distance(relative, bend, limit, ax.sync.jerk)
    period = ax.encoder.modulo_factor
    offset -= period * floor(beside / period + 0.5)
    ax.sync.offset = offset
    ax.coupling.slave_base = ax.set.position - offset
    ax.coupling.master_bases[0] = place
    ax.sync.method = _TO_PLACE


def _come_near(ax: AxisFields, rows: NcRows, leader: int, place: float, dt: float) -> bool:
    """One cycle nearer to the place beside the master; whether the slave is there."""
    velocity = leading_velocity(ax, rows, leader)
    acceleration = leading_acceleration(ax, rows, leader)
    jerk = leading_jerk(ax, rows, leader)
    noisy = rows.axes[ax.coupling.masters[leader]].axis_type == AxisType.ENCODER
    if noisy:
        acceleration = 0.0
        jerk = 0.0
    top = ax.sync.velocity - abs(velocity)
    if top < _LEFT * ax.sync.velocity:
        top = _LEFT * ax.sync.velocity
    way = place - ax.sync.last_master_position
    if ax.sync.method == _SETTLING_THERE:
        return settle_place(ax, velocity, way, top, dt)
    there = approach_place(ax, velocity, acceleration, jerk, way, top, dt)
    if noisy and abs(ax.set.velocity - velocity) <= ax.sync.acceleration * dt:
        ax.sync.method = _SETTLING_THERE
        ax.quiet_cycles = 0
        return False
    return there


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law; a phase shift of the slave moves what it sees of its first
    master."""
    leader = _leader(ax)
    place = leading_position(ax, rows, leader)
    if ax.sync.method != _TO_PLACE and ax.sync.method != _SETTLING_THERE:
        velocity = leading_velocity(ax, rows, leader)
        acceleration = leading_acceleration(ax, rows, leader)
        follow_approach(
            ax, rows.axes[ax.coupling.masters[leader]], place, velocity, acceleration, dt
        )
        if ax.coupling.gear == 0.0 and ax.sync.method == LINEAR:
            ax.sync.state = MotionState.INACTIVE
        return
    if _come_near(ax, rows, leader, place, dt):
        ax.set.position = ax.coupling.slave_base + (place - ax.coupling.master_bases[0])
        run_with(ax, ax.set.position, place, 1.0)
    ax.sync.last_master_position = place


def others(parameters: Sequence[float]) -> tuple[float, ...]:
    """Return the second master, parameter 3."""
    return (parameters[2],) if parameters[2] else ()


def check(ax: AxisFields, masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Axes of one period, a share above 0 and not above 1; a table of its own (parameter 4) is not
    approved by the manual. It begins with its first master."""
    known = (_REST, 1.0, _SECOND)[: 1 + len(masters)] if ax.coupling.law else (1.0,)
    if parameters[0] not in known or not 0.0 < parameters[1] <= 1.0 or parameters[3] != 0.0:
        return NcError.SLAVE_COUPLING_PARAMETER
    period = ax.encoder.modulo_factor
    if any(master.encoder.modulo_factor != period for master in masters):
        return NcError.SLAVE_COUPLING_PARAMETER
    return 0
