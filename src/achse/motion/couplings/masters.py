"""Leading values: set values, or actual values where parameters say so, as followers receive them.

An axis that is not ready, that is whose control loop is open, holds what it shows, and comes to
rest there; with parameter 0x1C its actual values lead then. An encoder axis has no others; it is
seen where it will be after the dead time of its group (0x3000 + ID:0x606). Between set and actual
values, and between dead times, what followers see fades, with the acceleration of parameter 0x1D.
Whatever is renamed or closed again, it does not jump.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from math import sqrt

from achse.codes.nc.choices import AxisType
from achse.motion.record import LAYOUT, AxisFields
from achse.motion.rows import NcRows
from achse.native.declare import assign, reset

SINGLE = 0
MASTER = 1
MASTER_AND_SLAVE = 2
SLAVE = 3
"""Coupling states (004 §5.1.1)."""


def show_coupling(ax: AxisFields) -> None:
    """Show the coupling state of an axis (state 0x20)."""
    if ax.coupling.law:
        ax.coupling_state = MASTER_AND_SLAVE if ax.followers else SLAVE
    else:
        ax.coupling_state = MASTER if ax.followers else SINGLE


def leading_position(ax: AxisFields, rows: NcRows, n: int) -> float:
    """Position of master n as its slave sees it: a phase shift moves the first one."""
    position = rows.axes[ax.coupling.masters[n]].leading_value.position
    return position + ax.phasing.position if n == 0 else position


def leading_velocity(ax: AxisFields, rows: NcRows, n: int) -> float:
    """Velocity of master n as its slave sees it."""
    velocity = rows.axes[ax.coupling.masters[n]].leading_value.velocity
    return velocity + ax.phasing.velocity if n == 0 else velocity


def leading_acceleration(ax: AxisFields, rows: NcRows, n: int) -> float:
    """Acceleration of master n as its slave sees it."""
    acceleration = rows.axes[ax.coupling.masters[n]].leading_value.acceleration
    return acceleration + ax.phasing.acceleration if n == 0 else acceleration


def leading_jerk(ax: AxisFields, rows: NcRows, n: int) -> float:
    """Jerk of master n; that of a phase shift is left out."""
    return rows.axes[ax.coupling.masters[n]].leading_value.jerk


def leading_value_of_row(
    ax: AxisFields, rows: NcRows, row: int
) -> tuple[float, float, float, float]:
    """Position, velocity, acceleration and jerk of the axis of a row, as a slave sees it.

    A phase shift moves the first master alone. An axis without a coupling yet looks at the one
    that it is to follow first.
    """
    value = rows.axes[row].leading_value
    position = value.position
    velocity = value.velocity
    acceleration = value.acceleration
    if ax.coupling.law == 0 or row == ax.coupling.masters[0]:
        position += ax.phasing.position
        velocity += ax.phasing.velocity
        acceleration += ax.phasing.acceleration
    return position, velocity, acceleration, value.jerk


def end_coupling(ax: AxisFields, rows: NcRows) -> None:
    """End all couplings; set values stay what they are.

    Every coupling ends here.
    """
    for n in range(ax.coupling.master_count):
        master = rows.axes[ax.coupling.masters[n]]
        master.followers -= 1
        show_coupling(master)
    reset(ax.coupling)
    ax.sync.state = 0
    reset(ax.camming)
    ax.controller.following_error_difference = 0.0
    ax.set_gear_ratio = 0.0
    show_coupling(ax)


def _fading_acceleration(ax: AxisFields) -> float:
    """Parameter 0x1D; 0 is the smaller one of the default acceleration and deceleration."""
    if ax.fading_acceleration > 0.0:
        return ax.fading_acceleration
    if ax.default_deceleration < ax.default_acceleration:
        return ax.default_deceleration
    return ax.default_acceleration


def _hold(ax: AxisFields, dt: float) -> None:
    """Let followers see the axis at standstill, or come to rest with the fading acceleration."""
    value = ax.leading_value
    v = value.velocity
    a = _fading_acceleration(ax)
    time = abs(v) / a
    if time > dt:
        time = dt
        ax.quiet_cycles = 0
    if v > 0.0:
        a = -a
    value.position += time * (v + 0.5 * a * time)
    value.velocity = v + a * time if time == dt else 0.0
    value.acceleration = a if value.velocity != 0.0 else 0.0
    value.jerk = 0.0
    value.offset = ax.set.position - value.position
    value.frozen = 1


def _fade(ax: AxisFields, dt: float) -> None:
    """Take the difference between set and actual values away, as fast as the acceleration lets.

    Twice the same acceleration: away from where it goes, then to rest where there is none.
    """
    d = ax.fading.position_difference
    v = ax.fading.relative_velocity
    if d == 0.0 and v == 0.0:
        ax.fading.relative_acceleration = 0.0
        return
    ax.quiet_cycles = 0
    a = _fading_acceleration(ax)
    sign = 1.0 if d + v * abs(v) / (2.0 * a) > 0.0 else -1.0
    top = a * d * sign + 0.5 * v * v
    top = sqrt(top) if top > 0.0 else 0.0
    first = (sign * v + top) / a
    if first < 0.0:
        first = 0.0
    second = top / a
    if dt >= first + second:
        reset(ax.fading)
        return
    if first > dt:
        first = dt
    d += first * (v - 0.5 * sign * a * first)
    v -= sign * a * first
    left = dt - first
    ax.fading.relative_acceleration = sign * a if left > 0.0 else -sign * a
    d += left * (v + 0.5 * sign * a * left)
    v += sign * a * left
    ax.fading.position_difference = d
    ax.fading.relative_velocity = v


def begin_leading_value(ax: AxisFields) -> None:
    """Begin the leading value for a first follower: the present values, without any history."""
    value = ax.leading_value
    value.frozen = 0
    value.offset = 0.0
    value.by_actual = _by_actual_values(ax)
    value.dead_time = ax.coupling_dead_time if ax.axis_type == AxisType.ENCODER else 0.0
    value.velocity = 0.0
    reset(ax.fading)
    update_leading_value(ax, 0.0)


def _by_actual_values(ax: AxisFields) -> int:
    if ax.axis_type == AxisType.ENCODER:
        return 1
    return 1 if ax.loop_closed == 0 and ax.couple_slaves_by_actual_values == 1 else 0


def update_leading_value(ax: AxisFields, dt: float) -> None:
    """Compute the leading value of this cycle."""
    value = ax.leading_value
    by_actual = _by_actual_values(ax)
    if by_actual == 0 and (ax.loop_closed == 0 or value.frozen):
        _hold(ax, dt)
        if ax.loop_closed and value.velocity == 0.0:
            value.frozen = 0
        value.by_actual = 0
        return
    position = ax.set.position
    velocity = ax.set.velocity
    acceleration = ax.set.acceleration
    jerk = ax.set.jerk
    if by_actual:
        encoder = ax.encoder
        position = encoder.actual_position
        velocity = encoder.actual_velocity
        acceleration = encoder.actual_acceleration
        jerk = 0.0
    ahead = ax.coupling_dead_time
    if ax.axis_type != AxisType.ENCODER:
        ahead = 0.0
    if ahead != 0.0:
        position += ahead * velocity
        velocity += ahead * acceleration
    position -= value.offset
    if by_actual != value.by_actual or ahead != value.dead_time:
        value.by_actual = by_actual
        value.dead_time = ahead
        ax.fading.position_difference = value.position + value.velocity * dt - position
        ax.fading.relative_velocity = value.velocity - velocity
    else:
        _fade(ax, dt)
    value.position = position + ax.fading.position_difference
    value.velocity = velocity + ax.fading.relative_velocity
    value.acceleration = acceleration + ax.fading.relative_acceleration
    value.jerk = jerk
    value.frozen = 0


def as_leader(ax: AxisFields) -> AxisFields:
    """Return the axis as a follower sees it: for one without followers a copy is the master."""
    if ax.followers:
        return ax
    leader: AxisFields = LAYOUT.plain()
    assign(leader.set, ax.set)
    assign(leader.leading_value, ax.leading_value)
    for name in _LEADING:
        setattr(leader, name, getattr(ax, name))
    begin_leading_value(leader)
    return leader


_LEADING = (
    *("encoder", "axis_type", "loop_closed", "couple_slaves_by_actual_values"),
    *("fading_acceleration", "default_acceleration", "default_deceleration"),
    "coupling_dead_time",
)
"""Fields that decide what a first follower sees."""
