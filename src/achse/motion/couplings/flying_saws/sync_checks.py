"""Checks of the universal flying saw (0x4B) before it begins, and the code that refuses it.

A requested check that fails answers 0x42DF, or with the bit for detailed codes a code of its
own. Which codes stand for which swing of the velocity is a choice (decision 0037).
"""

from collections.abc import Iterator
from typing import NamedTuple

from achse.codes import NcError
from achse.motion.couplings.flying_saws.course import SlaveCourse
from achse.motion.states import SynchronisingBit

_ROUNDED = 1e-9

_ABOVE = NcError.SAW_VELOCITY_ABOVE_END, NcError.SAW_VELOCITY_ABOVE_START
_BELOW = NcError.SAW_VELOCITY_BELOW_START, NcError.SAW_VELOCITY_BELOW_END
"""Of a velocity that rises, and of one that falls."""

_FORWARDS, _BACKWARDS = NcError.SAW_MAX_VELOCITY, NcError.SAW_MIN_VELOCITY
_GROWS, _SHRINKS = NcError.SAW_ACCELERATION, NcError.SAW_DECELERATION
_JERK, _JERK_BACK = NcError.SAW_MAX_JERK, NcError.SAW_MIN_JERK


class FlyingSawLimits(NamedTuple):
    """Limits of a slave while it synchronises; soft limits are None where there is none."""

    velocity: float
    acceleration: float
    deceleration: float
    jerk: float
    least_position: float | None = None
    most_position: float | None = None


class _Check(NamedTuple):
    """A check that a bit enables: a value is not above its limit, but for its rounding."""

    bit: SynchronisingBit
    value: float
    limit: float
    scale: float
    code: NcError


def _positions(course: SlaveCourse, limits: FlyingSawLimits) -> Iterator[_Check]:
    start, target = course.begin(0), course.end(0)
    least, most = course.least(0).value, course.most(0).value
    scale = max(abs(start), abs(target), abs(target - start), 1.0)
    if limits.least_position is not None:
        code = NcError.SAW_MIN_POSITION
        yield _Check(SynchronisingBit.MIN_POSITION, limits.least_position, least, scale, code)
    if limits.most_position is not None:
        code = NcError.SAW_MAX_POSITION
        yield _Check(SynchronisingBit.MAX_POSITION, most, limits.most_position, scale, code)
    back = target < start
    code = NcError.SAW_UNDERSHOOTS_TARGET if back else NcError.SAW_UNDERSHOOTS_START
    yield _Check(SynchronisingBit.UNDERSHOOT_POSITION, min(start, target), least, scale, code)
    code = NcError.SAW_OVERSHOOTS_START if back else NcError.SAW_OVERSHOOTS_TARGET
    yield _Check(SynchronisingBit.OVERSHOOT_POSITION, most, max(start, target), scale, code)


def _velocities(course: SlaveCourse) -> Iterator[_Check]:
    start, end = course.begin(1), course.end(1)
    least, most = course.least(1).value, course.most(1).value
    scale = max(abs(most), abs(least))
    falls = int(end < start)
    bit = SynchronisingBit.OVERSHOOT_VELOCITY
    yield _Check(bit, most, max(start, end), scale, _ABOVE[falls])
    bit = SynchronisingBit.UNDERSHOOT_VELOCITY
    yield _Check(bit, min(start, end), least, scale, _BELOW[falls])
    bit = SynchronisingBit.OVERSHOOT_VELOCITY_ZERO
    yield _Check(bit, most, 0.0, scale, NcError.SAW_VELOCITY_POSITIVE)
    bit = SynchronisingBit.UNDERSHOOT_VELOCITY_ZERO
    yield _Check(bit, 0.0, least, scale, NcError.SAW_VELOCITY_NEGATIVE)


def _dynamics(course: SlaveCourse, limits: FlyingSawLimits) -> Iterator[_Check]:
    grows, shrinks = course.strongest()
    for bit, value, limit, code in (
        (SynchronisingBit.MAX_VELOCITY, course.most(1).value, limits.velocity, _FORWARDS),
        (SynchronisingBit.MAX_VELOCITY, -course.least(1).value, limits.velocity, _BACKWARDS),
        (SynchronisingBit.MAX_ACCELERATION, grows, limits.acceleration, _GROWS),
        (SynchronisingBit.MAX_DECELERATION, shrinks, limits.deceleration, _SHRINKS),
        (SynchronisingBit.MAX_JERK, course.most(3).value, limits.jerk, _JERK),
        (SynchronisingBit.MAX_JERK, -course.least(3).value, limits.jerk, _JERK_BACK),
    ):
        yield _Check(bit, value, limit, limit, code)


def check_course(
    course: SlaveCourse, mask: int, limits: FlyingSawLimits, *, nominal: bool = False
) -> int:
    """Code of the first check of the mask that the course fails, or 0.

    `nominal`: the master is at standstill, so the slave's velocity is unknown and not checked.
    """
    checks = [*_positions(course, limits), *_velocities(course)]
    if not nominal:
        checks += _dynamics(course, limits)
    for check in checks:
        if mask & check.bit and check.value > check.limit + _ROUNDED * check.scale:
            detailed = mask & SynchronisingBit.DETAILED_ERROR_CODES
            return check.code if detailed else NcError.SYNCHRONISING_PROFILE
    return 0
