"""Universal flying saw: let an axis in any motion come to run with its master (0x4B)."""

from collections.abc import Callable, Sequence
from math import isfinite, sqrt
from typing import NamedTuple

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.commands.slaves.couplings import LARGEST_PARAMETER, begin_coupling, check_slave
from achse.motion.couplings.flying_saws.approach import AT_REST, NO_WAY, line, quintic, ramp
from achse.motion.couplings.flying_saws.course import (
    SlaveCourse,
    course_by_time,
    course_over_master,
)
from achse.motion.couplings.flying_saws.sync_checks import FlyingSawLimits, check_course
from achse.motion.couplings.masters import as_leader
from achse.motion.fields.synchronising import SYNC_SPANS, SYNC_TERMS
from achse.motion.record import AxisFields
from achse.motion.states import SlaveType, SynchronisingBit

_HALVINGS = 80

_FARTHEST = 1e12
"""Positions beyond are none of an axis, and NaN is none at all."""

_TYPES = SlaveType.SYNCHRONISING_VELOCITY, SlaveType.SYNCHRONISING_POSITION


class _Request(NamedTuple):
    """Request of the service; limits are those in force."""

    by_position: bool
    gear: float
    master_position: float
    slave_position: float
    limits: FlyingSawLimits
    mask: int


class _Way(NamedTuple):
    """A way over the master in spans of `approach`."""

    lengths: list[float]
    terms: list[float]


def synchronise(
    slave: Axis,
    slave_type: int,
    master_id: int,
    master_subindex: int,
    slave_subindex: int,
    gear: float,
    master_position: float = 0.0,
    slave_position: float = 0.0,
    velocity: float = 0.0,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    jerk: float = 0.0,
    mask: int = 0,
) -> int:
    """Let an axis run with a master: its velocity (type 5), or from places of both on (type 6).

    Limits of 0 are those of the axis. Both may move; a slave that moves while its master is at
    standstill is refused. Of the mask see `SynchronisingBit`, unknown bits mean nothing. A
    universal flying saw that runs can be given new places, a new gear and new limits by the same
    command.
    """
    if slave_type not in _TYPES:
        return NcError.SLAVE_TYPE
    if master_subindex or slave_subindex:
        return NcError.SLAVE_COUPLING_PARAMETER
    if not (
        abs(gear) <= LARGEST_PARAMETER
        and abs(master_position) <= _FARTHEST
        and abs(slave_position) <= _FARTHEST
    ):
        return NcError.SLAVE_COUPLING_PARAMETER
    if gear == 0.0:
        return NcError.GEAR_FACTOR_ZERO
    commanded = velocity, acceleration, deceleration, jerk
    if not all(isfinite(limit) and limit >= 0.0 for limit in commanded):
        return NcError.SYNCHRONISING_DYNAMICS
    code = check_slave(slave)
    if code and not (code == NcError.SLAVE_ADDRESS and slave.coupling.law in _TYPES):
        return code
    by_position = slave_type == SlaveType.SYNCHRONISING_POSITION
    limits = _limits(slave, *commanded)
    request = _Request(by_position, gear, master_position, slave_position, limits, mask)
    ways: list[_Way] = []

    def check(masters: Sequence[Axis]) -> int:
        code, way = _plan(slave, as_leader(masters[0]), request)
        ways.extend(way)
        return code

    def fill() -> None:
        slave.sync.mask = mask
        slave.sync.velocity, slave.sync.acceleration = limits.velocity, limits.acceleration
        slave.sync.deceleration, slave.sync.jerk = limits.deceleration, limits.jerk

    code = begin_coupling(
        slave,
        slave_type,
        (master_id,),
        (gear, master_position, slave_position, 0.0),
        moving=True,
        slave_moves=True,
        check=check,
        fill=fill,
    )
    if not code and ways:
        _apply(slave, ways[0])
    return code


def _limits(
    slave: Axis, velocity: float, acceleration: float, deceleration: float, jerk: float
) -> FlyingSawLimits:
    encoder = slave.encoder
    return FlyingSawLimits(
        velocity or slave.max_velocity,
        acceleration or slave.default_acceleration,
        deceleration or slave.default_deceleration,
        jerk or slave.default_jerk,
        encoder.soft_limit_min if encoder.soft_limit_min_enable else None,
        encoder.soft_limit_max if encoder.soft_limit_max_enable else None,
    )


def _apply(slave: Axis, way: _Way) -> None:
    """Go this way instead of the one in a single span."""
    slave.sync.count = len(way.lengths)
    for n, length in enumerate(way.lengths):
        slave.sync.length[n] = length
    for n, term in enumerate(way.terms):
        slave.sync.terms[n] = term


def _plan(slave: Axis, master: AxisFields, request: _Request) -> tuple[int, list[_Way]]:
    """Code that refuses it; the way to take, if it is not in a single span."""
    master_position = master.leading_value.position + slave.phasing.position
    velocity = master.leading_value.velocity + slave.phasing.velocity
    if abs(velocity) < AT_REST:
        velocity = 0.0
    state = slave.set.position, slave.set.velocity, slave.set.acceleration
    if velocity == 0.0 and slave.set.velocity != 0.0:
        return NcError.FLYING_COUPLING_MASTER_STANDS, []
    limits, mask = request.limits, request.mask
    if not request.by_position:
        begin = master_position + master.leading_value.offset
        course = course_by_time(begin, velocity, state, request.gear * velocity, limits[1:4])
        return check_course(course, mask, limits), []
    master_way = request.master_position - master.leading_value.offset - master_position
    slave_way = request.slave_position - slave.set.position
    if abs(master_way) < NO_WAY or master_way * velocity < 0.0:
        return NcError.SYNCHRONISING_PROFILE, []
    if slave_way * request.gear * master_way <= 0.0:
        return NcError.SYNCHRONISING_PROFILE, []
    heading = 1.0 if master_way > 0.0 else -1.0
    nominal = velocity or heading
    ways = [_in_one(slave, master, request, nominal, master_way, slave_way)]
    if mask & SynchronisingBit.PREFER_CONSTANT_VELOCITY and velocity:
        ways[:0] = _with_constant(slave, request, velocity, master_way, slave_way)

    def course_on(way: _Way) -> SlaveCourse:
        begin = master_position + master.leading_value.offset
        return course_over_master(begin, nominal, state[0], way.lengths, way.terms)

    codes = [check_course(course_on(way), mask, limits, nominal=not velocity) for way in ways]
    if codes[0] == OK:
        return OK, ways[:-1]
    return codes[-1], []


def _in_one(
    slave: Axis,
    master: AxisFields,
    request: _Request,
    velocity: float,
    way: float,
    height: float,
) -> _Way:
    """Return the way of `achse.motion.couplings.flying_saws.approach.meet`."""
    heading = 1.0 if way > 0.0 else -1.0
    speed = heading * velocity
    slope = slave.set.velocity / speed
    own = 0.0
    if not request.mask & SynchronisingBit.IGNORE_SLAVE_ACCELERATION:
        own = slave.set.acceleration
    if not request.mask & SynchronisingBit.IGNORE_MASTER_ACCELERATION:
        own -= slope * heading * (master.leading_value.acceleration + slave.phasing.acceleration)
    bend = own / (speed * speed)
    terms = [0.0] * SYNC_TERMS
    quintic(terms, 0, heading * way, 0.0, height, slope, bend, heading * request.gear)
    return _Way([heading * way], terms)


def _last(holds: Callable[[float], bool], here: float, there: float) -> float:
    """Return the last place from here to there where something holds, which does at first."""
    if holds(there):
        return there
    for _ in range(_HALVINGS):
        middle = 0.5 * (here + there)
        if holds(middle):
            here = middle
        else:
            there = middle
    return here


def _with_constant(
    slave: Axis, request: _Request, velocity: float, way: float, height: float
) -> list[_Way]:
    """Return a way with a stretch of constant velocity, by the full acceleration; none if there is
    none.

    Its curves begin without acceleration, so a slave that has one goes in one span, unless its
    acceleration is to be ignored.
    """
    ignored = request.mask & SynchronisingBit.IGNORE_SLAVE_ACCELERATION
    if slave.set.acceleration != 0.0 and not ignored:
        return []
    total = way / velocity
    begin, end = slave.set.velocity, request.gear * velocity
    limits = request.limits
    jerk = limits.jerk if request.mask & SynchronisingBit.MAX_JERK else None

    def ramp_time(start: float, goal: float) -> float:
        change = abs(goal - start)
        limit = limits.acceleration if abs(goal) >= abs(start) else limits.deceleration
        if start * goal < 0.0:
            limit = min(limits.acceleration, limits.deceleration)
        time = 1.5 * change / limit
        return max(time, sqrt(6.0 * change / jerk)) if jerk else time

    def left(constant: float) -> float:
        """Seconds with constant velocity."""
        return total - ramp_time(begin, constant) - ramp_time(constant, end)

    def covered(constant: float) -> float:
        first, last = ramp_time(begin, constant), ramp_time(constant, end)
        return 0.5 * ((begin + constant) * first + (constant + end) * last) + constant * left(
            constant
        )

    base = max(begin, end, key=left)
    low = _last(lambda constant: left(constant) > 0.0, base, -limits.velocity)
    high = _last(lambda constant: left(constant) > 0.0, base, limits.velocity)
    constant = _last(lambda constant: covered(constant) <= height, low, high)
    if left(constant) <= 0.0 or abs(covered(constant) - height) > 1e-9 * abs(height):
        return []
    heading = 1.0 if way > 0.0 else -1.0
    speed = heading * velocity
    lengths = [ramp_time(begin, constant) * speed, left(constant) * speed]
    lengths.append(heading * way - sum(lengths))
    terms = [0.0] * (SYNC_SPANS * SYNC_TERMS)
    between = 0.5 * (begin + constant) / speed * lengths[0]
    last = height - 0.5 * (constant + end) / speed * lengths[2]
    ramp(terms, 0, lengths[0], 0.0, begin / speed, constant / speed)
    line(terms, SYNC_TERMS, lengths[1], between, constant / speed)
    ramp(terms, 2 * SYNC_TERMS, lengths[2], last, constant / speed, end / speed)
    return [_Way(lengths, terms)] if min(lengths) > NO_WAY else []
