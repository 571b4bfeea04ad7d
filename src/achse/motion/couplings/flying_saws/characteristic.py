"""Characteristic values of a slave that synchronises (002 §6.4.4.2, 0x4100 + ID:0x26)."""

from typing import TYPE_CHECKING

from achse.motion.couplings.flying_saws.approach import AT_REST
from achse.motion.couplings.flying_saws.course import (
    SlaveCourse,
    course_by_time,
    course_over_master,
)
from achse.motion.states import SlaveType

if TYPE_CHECKING:
    from achse.motion.axis import Axis

CHARACTERISTIC_VALUES = 64
"""Numbers in the answer; those behind the 31 that the manual names are 0."""

_SYNCHRONISING = (
    SlaveType.FLYING_SAW_VELOCITY,
    SlaveType.FLYING_SAW_POSITION,
    SlaveType.SYNCHRONISING_VELOCITY,
    SlaveType.SYNCHRONISING_POSITION,
)


def course_of(slave: "Axis") -> SlaveCourse | None:
    """Return the course on which a slave synchronises or did; None for others.

    It is that of the master's velocity at coupling, of 1 if it stood.
    """
    if slave.coupling.law not in _SYNCHRONISING:
        return None
    (row,) = slave.followed
    begin = slave.sync.begin + slave.rows.axes[row].leading_value.offset
    velocity = slave.sync.master_velocity
    if slave.sync.count:
        if abs(velocity) < AT_REST:
            velocity = slave.sync.heading
        lengths = list(slave.sync.length[: slave.sync.count])
        terms = list(slave.sync.terms)
        return course_over_master(begin, velocity, slave.sync.begin_position, lengths, terms)
    state = slave.sync.begin_position, slave.sync.begin_velocity, slave.sync.begin_acceleration
    limits = slave.sync.acceleration, slave.sync.deceleration, slave.sync.jerk
    return course_by_time(begin, velocity, state, slave.coupling.gear * velocity, limits)


def characteristic_of(course: SlaveCourse) -> list[float]:
    """64 numbers: master velocity, begin and end of both, extremes and where they are, means."""

    def master(time: float) -> float:
        return course.master_begin + course.master_velocity * time

    begin = [master(0.0), *(course.begin(order) for order in range(4))]
    end = [master(course.duration), *(course.end(order) for order in range(4))]
    values = [course.master_velocity, *begin, *end]
    for extreme in (course.least, course.most):
        for order in range(3):
            place = extreme(order)
            values += [master(place.time), place.value]
        velocity = course.velocity_at(place.time)
        values += [velocity, extreme(3).value, velocity * place.value]
    values += [course.mean_speed(), course.effective_acceleration()]
    return values + [0.0] * (CHARACTERISTIC_VALUES - len(values))
