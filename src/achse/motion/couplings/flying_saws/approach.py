"""Ways on which a slave comes to run with its master: by the master's position, or by time.

By position the way is one polynomial over the master, or three (two curves and constant velocity
between them). It is the same at any velocity of the master, and the slave goes back on it when the
master does. By time the slave is changed over with limited acceleration and jerk.

Velocities over the master are slave units per master unit; times its velocity they are those of the
axis. u is the share of a span, 0 … 1.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import MutableSequence, Sequence

from achse.codes.axis import MotionState
from achse.codes.nc.choices import AxisType
from achse.motion.couplings.flying_saws.chase import approach_velocity, settle
from achse.motion.couplings.guard import check_ratio
from achse.motion.couplings.masters import leading_acceleration, leading_velocity
from achse.motion.fields.synchronising import SYNC_TERMS
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.states import SynchronisingBit

INACTIVE = 0
BY_POSITION = 1
BY_TIME = 2
LINEAR = 3
STOPPING = 4
SETTLING = 6
"""Methods that make the set point: nothing, a path over the master, a change over in time, the
gear, a stop because the master reversed, the end of a change over to a master that trembles. Number
5 is that of a modulo flying saw.
"""


AT_REST = 1e-9
"""A slower master counts as at standstill: no way over it follows from its velocity."""

NO_WAY = 1e-9
"""A way of the master that is shorter is none."""


def quintic(
    terms: MutableSequence[float],
    first: int,
    length: float,
    begin: float,
    height: float,
    slope: float,
    bend: float,
    end_slope: float,
) -> None:
    """Write the curve of `height` over `length` from velocity and acceleration to `end_slope`.

    It ends without acceleration. Velocities and accelerations are those over the master.
    """
    c1 = slope * length
    c2 = 0.5 * bend * length * length
    a = height - c1 - c2
    b = end_slope * length - c1 - 2.0 * c2
    c = -2.0 * c2
    terms[first] = begin
    terms[first + 1] = c1
    terms[first + 2] = c2
    terms[first + 3] = 10.0 * a - 4.0 * b + 0.5 * c
    terms[first + 4] = -15.0 * a + 7.0 * b - c
    terms[first + 5] = 6.0 * a - 3.0 * b + 0.5 * c


def ramp(
    terms: MutableSequence[float],
    first: int,
    length: float,
    begin: float,
    slope: float,
    end_slope: float,
) -> None:
    """Write a cubic from one velocity to another over `length`; both ends without acceleration."""
    change = (end_slope - slope) * length
    terms[first] = begin
    terms[first + 1] = slope * length
    terms[first + 2] = 0.0
    terms[first + 3] = change
    terms[first + 4] = -0.5 * change
    terms[first + 5] = 0.0


def line(
    terms: MutableSequence[float], first: int, length: float, begin: float, slope: float
) -> None:
    """Write constant velocity over `length`."""
    ramp(terms, first, length, begin, slope, slope)


def weak_ramp(
    terms: MutableSequence[float], first: int, length: float, slope: float, smooth: bool
) -> None:
    """Write a ramp of velocity from rest over `length`: a line, or `smooth` a cubic."""
    if smooth:
        ramp(terms, first, length, 0.0, 0.0, slope)
        return
    line(terms, first, length, 0.0, 0.0)
    terms[first + 2] = 0.5 * slope * length


def place_at(
    terms: Sequence[float], first: int, length: float, u: float
) -> tuple[float, float, float, float]:
    """Position and its three derivatives by the master's way, at the share `u` of a span."""
    c1 = terms[first + 1]
    c2 = terms[first + 2]
    c3 = terms[first + 3]
    c4 = terms[first + 4]
    c5 = terms[first + 5]
    s = terms[first] + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    d1 = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))
    d2 = 2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))
    d3 = 6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)
    return s, d1 / length, d2 / (length * length), d3 / (length * length * length)


def heading_of(velocity: float) -> float:
    """Return its sign; 0 of a master at rest, which may go either way."""
    if abs(velocity) < AT_REST:
        return 0.0
    return 1.0 if velocity > 0.0 else -1.0


def begin_approach(
    ax: AxisFields, master_position: float, velocity: float, acceleration: float, gear: float
) -> None:
    """Count from here, where the slave sees its master at a position and with a velocity."""
    ax.coupling.gear = gear
    ax.set_gear_ratio = gear
    ax.coupling.slave_base = ax.set.position
    ax.sync.last_master_position = master_position
    ax.sync.begin = master_position
    ax.sync.moved = 1 if ax.set.velocity != 0.0 or ax.set.acceleration != 0.0 else 0
    ax.sync.begin_position = ax.set.position
    ax.sync.begin_velocity = ax.set.velocity
    ax.sync.begin_acceleration = ax.set.acceleration
    ax.sync.master_velocity = velocity
    ax.sync.master_acceleration = acceleration
    ax.sync.pursued_velocity = gear * velocity
    ax.sync.pursued_acceleration = gear * acceleration
    ax.sync.heading = heading_of(velocity)
    ax.sync.offset = 0.0
    ax.sync.count = 0
    ax.sync.method = BY_TIME
    ax.sync.state = MotionState.SLAVE_SYNCHRONISING


def meet(ax: AxisFields, master_way: float, slave_way: float) -> None:
    """Meet the master where it will be after its way; the slave goes `slave_way` until then.

    By one polynomial of the fifth degree; `begin_approach` was before. Where slave or master have
    an acceleration it begins with that, unless it is to be ignored.
    """
    heading = -1.0 if master_way < 0.0 else 1.0
    velocity = heading * ax.sync.master_velocity
    slope = 0.0
    bend = 0.0
    if abs(velocity) >= AT_REST:
        slope = ax.sync.begin_velocity / velocity
        own = 0.0
        if ax.sync.mask & SynchronisingBit.IGNORE_SLAVE_ACCELERATION == 0:
            own = ax.sync.begin_acceleration
        if ax.sync.mask & SynchronisingBit.IGNORE_MASTER_ACCELERATION == 0:
            own -= slope * heading * ax.sync.master_acceleration
        bend = own / (velocity * velocity)
    ax.sync.heading = heading
    ax.sync.length[0] = heading * master_way
    ax.sync.count = 1
    ax.sync.method = BY_POSITION
    end_slope = heading * ax.coupling.gear
    quintic(ax.sync.terms, 0, heading * master_way, 0.0, slave_way, slope, bend, end_slope)


def run_with(ax: AxisFields, slave: float, master: float, gear: float) -> None:
    """Run with the master from now on: the slave is at `slave` where it sees it at `master`."""
    ax.coupling.slave_base = slave
    ax.coupling.master_bases[0] = master
    ax.coupling.gear = gear
    ax.set_gear_ratio = gear
    ax.sync.method = LINEAR
    ax.sync.state = MotionState.SLAVE_SYNCHRONOUS


def check_gear(ax: AxisFields, rows: NcRows, gear: float, dt: float) -> int:
    """Return the code that refuses another gear of a slave that runs with its master, or 0.

    On the way in time the slave comes to another gear by its limits.
    """
    if ax.sync.method != LINEAR:
        return 0
    velocity = gear * leading_velocity(ax, rows, 0)
    return check_ratio(ax, velocity, gear * leading_acceleration(ax, rows, 0), dt)


def set_gear(ax: AxisFields, velocity: float, acceleration: float, gear: float) -> None:
    """Approach another gear in time, where the slave sees its master move like this."""
    ax.coupling.gear = gear
    ax.set_gear_ratio = gear
    ax.sync.pursued_velocity = gear * velocity
    ax.sync.pursued_acceleration = gear * acceleration
    ax.sync.method = BY_TIME


def _stand(ax: AxisFields) -> None:
    ax.set.velocity = 0.0
    ax.set.acceleration = 0.0
    ax.set.jerk = 0.0


def _stop_because_it_goes_back(ax: AxisFields) -> None:
    """Stop and stay: the master is behind where it was at coupling."""
    ax.sync.method = STOPPING
    ax.sync.state = MotionState.INACTIVE
    ax.sync.pursued_velocity = 0.0
    ax.sync.pursued_acceleration = 0.0
    if ax.sync.mask & SynchronisingBit.INSTANT_STOP_ON_ROLLBACK:
        ax.sync.method = INACTIVE


def _by_position(
    ax: AxisFields, master_position: float, velocity: float, acceleration: float, jerk: float
) -> None:
    """Run one cycle of the way over the master."""
    way = ax.sync.heading * (master_position - ax.sync.begin)
    if way < 0.0:
        if ax.sync.moved:
            _stop_because_it_goes_back(ax)
            return
        ax.set.position = ax.coupling.slave_base
        ax.sync.state = MotionState.SLAVE_PREPHASE
        _stand(ax)
        return
    span = 0
    for _ in range(ax.sync.count):
        if way < ax.sync.length[span]:
            break
        way -= ax.sync.length[span]
        span += 1
    last = ax.sync.count - 1
    if span > last:
        length = ax.sync.length[last]
        s, _, _, _ = place_at(ax.sync.terms, SYNC_TERMS * last, length, 1.0)
        met = master_position - ax.sync.heading * way
        run_with(ax, ax.coupling.slave_base + s, met, ax.coupling.gear)
        return
    length = ax.sync.length[span]
    s, d1, d2, d3 = place_at(ax.sync.terms, SYNC_TERMS * span, length, way / length)
    v = ax.sync.heading * velocity
    a = ax.sync.heading * acceleration
    ax.set.position = ax.coupling.slave_base + s
    ax.set.velocity = d1 * v
    ax.set.acceleration = d2 * v * v + d1 * a
    ax.set.jerk = d3 * v * v * v + 3.0 * d2 * v * a + d1 * ax.sync.heading * jerk
    ax.sync.state = MotionState.SLAVE_SYNCHRONISING


def _by_time(
    ax: AxisFields,
    master: AxisFields,
    master_position: float,
    velocity: float,
    acceleration: float,
    dt: float,
) -> None:
    """Run one cycle of a change over to the velocity of the master."""
    noisy = master.axis_type == AxisType.ENCODER
    wanted = ax.coupling.gear * velocity
    rising = 0.0 if noisy else ax.coupling.gear * acceleration
    jerk = 0.0 if noisy else ax.coupling.gear * master.leading_value.jerk
    way = ax.coupling.gear * (master_position - ax.sync.last_master_position)
    too_fast = ax.sync.mask & SynchronisingBit.MAX_VELOCITY and abs(wanted) > ax.sync.velocity
    if too_fast:
        wanted = ax.sync.velocity if wanted > 0.0 else -ax.sync.velocity
        rising = 0.0
        jerk = 0.0
        way = wanted * dt
    if ax.sync.method == SETTLING and not too_fast:
        if settle(ax, wanted, way, dt):
            run_with(ax, ax.set.position, master_position, ax.coupling.gear)
        return
    ax.sync.method = BY_TIME
    if approach_velocity(ax, wanted, rising, jerk, way, noisy, dt) and not too_fast:
        if noisy:
            ax.sync.method = SETTLING
            ax.quiet_cycles = 0
        else:
            run_with(ax, ax.set.position, master_position, ax.coupling.gear)


def follow_approach(
    ax: AxisFields,
    master: AxisFields,
    master_position: float,
    velocity: float,
    acceleration: float,
    dt: float,
) -> None:
    """Run one cycle of a slave that comes to its master, or runs with it."""
    if ax.sync.heading == 0.0:
        ax.sync.heading = heading_of(velocity)
    behind = ax.sync.heading * (master_position - ax.sync.begin) < 0.0
    if behind and ax.sync.method == LINEAR and ax.sync.mask & SynchronisingBit.ROLLBACK_LOCK:
        _stop_because_it_goes_back(ax)
    if ax.sync.method == BY_POSITION:
        _by_position(ax, master_position, velocity, acceleration, master.leading_value.jerk)
    if ax.sync.method == BY_TIME or ax.sync.method == SETTLING:
        _by_time(ax, master, master_position, velocity, acceleration, dt)
    elif ax.sync.method == STOPPING and approach_velocity(ax, 0.0, 0.0, 0.0, 0.0, False, dt):
        ax.sync.method = INACTIVE
    if ax.sync.method == INACTIVE:
        ax.sync.state = MotionState.INACTIVE
        _stand(ax)
    elif ax.sync.method == LINEAR:
        ax.set.position = ax.coupling.slave_base + ax.coupling.gear * (
            master_position - ax.coupling.master_bases[0]
        )
        ax.set.velocity = ax.coupling.gear * velocity
        ax.set.acceleration = ax.coupling.gear * acceleration
        ax.set.jerk = ax.coupling.gear * master.leading_value.jerk
    ax.sync.last_master_position = master_position
