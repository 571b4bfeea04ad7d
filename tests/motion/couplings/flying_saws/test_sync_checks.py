"""Each check of the universal flying saw, at its limit, and the code of each that fails."""

import pytest

from achse.codes import NcError
from achse.motion.couplings.flying_saws.approach import quintic
from achse.motion.couplings.flying_saws.course import SlaveCourse, course_over_master
from achse.motion.couplings.flying_saws.sync_checks import FlyingSawLimits, check_course
from achse.motion.states import SynchronisingBit as Bit

FREE = FlyingSawLimits(1e9, 1e9, 1e9, 1e9)


def course(
    height: float, slope: float, end: float, length: float = 100.0, velocity: float = 10.0
) -> SlaveCourse:
    terms = [0.0] * 6
    quintic(terms, 0, length, 0.0, height, slope, 0.0, end)
    return course_over_master(0.0, velocity, 0.0, [length], terms)


LATE = course(5.0, 1.0, 1.0)
"""Little way at velocities of 1 at both ends: it slows down and turns."""
FAST = course(200.0, 0.5, 1.0)
"""Much way: it is faster than both ends."""
BACK = course(-30.0, 0.0, -1.0)
SWINGS = course(60.0, -2.0, 1.0)
"""It moves back first."""


@pytest.mark.parametrize(
    ("bit", "which", "code"),
    [
        (Bit.UNDERSHOOT_POSITION, SWINGS, NcError.SAW_UNDERSHOOTS_START),
        (Bit.OVERSHOOT_POSITION, LATE, NcError.SAW_OVERSHOOTS_TARGET),
        (Bit.UNDERSHOOT_POSITION, course(-5.0, -1.0, -1.0), NcError.SAW_UNDERSHOOTS_TARGET),
        (Bit.OVERSHOOT_POSITION, course(-60.0, 2.0, -1.0), NcError.SAW_OVERSHOOTS_START),
        (Bit.OVERSHOOT_VELOCITY, FAST, NcError.SAW_VELOCITY_ABOVE_END),
        (Bit.OVERSHOOT_VELOCITY, course(200.0, 1.5, 1.0), NcError.SAW_VELOCITY_ABOVE_START),
        (Bit.UNDERSHOOT_VELOCITY, course(5.0, 0.5, 1.0), NcError.SAW_VELOCITY_BELOW_START),
        (Bit.UNDERSHOOT_VELOCITY, course(5.0, 1.5, 1.0), NcError.SAW_VELOCITY_BELOW_END),
        (Bit.OVERSHOOT_VELOCITY_ZERO, FAST, NcError.SAW_VELOCITY_POSITIVE),
        (Bit.UNDERSHOOT_VELOCITY_ZERO, LATE, NcError.SAW_VELOCITY_NEGATIVE),
        (Bit.UNDERSHOOT_VELOCITY_ZERO, BACK, NcError.SAW_VELOCITY_NEGATIVE),
    ],
)
def test_swings(bit: int, which: SlaveCourse, code: NcError) -> None:
    assert check_course(which, 0, FREE) == 0
    assert check_course(which, ~bit & 0x3F3F, FREE) in (0, NcError.SYNCHRONISING_PROFILE)
    assert check_course(which, bit, FREE) == NcError.SYNCHRONISING_PROFILE
    assert check_course(which, bit | Bit.DETAILED_ERROR_CODES, FREE) == code


@pytest.mark.parametrize(
    ("bit", "name", "which", "order", "code"),
    [
        (Bit.MAX_VELOCITY, "velocity", FAST, 1, NcError.SAW_MAX_VELOCITY),
        (Bit.MAX_VELOCITY, "velocity", BACK, -1, NcError.SAW_MIN_VELOCITY),
        (Bit.MAX_JERK, "jerk", FAST, 3, NcError.SAW_MAX_JERK),
        (Bit.MAX_JERK, "jerk", course(-20.0, 0.0, -1.0), -3, NcError.SAW_MIN_JERK),
    ],
)
def test_a_limit_that_is_just_kept_and_one_that_is_not(
    bit: int, name: str, which: SlaveCourse, order: int, code: NcError
) -> None:
    value = which.most(order).value if order > 0 else -which.least(-order).value
    assert value > 0.0
    just = FREE._replace(**{name: value})
    if not (bit == Bit.MAX_JERK and order < 0 and which.most(3).value > value):
        assert check_course(which, bit | Bit.DETAILED_ERROR_CODES, just) == 0
    less = FREE._replace(**{name: 0.999 * value})
    answer = check_course(which, bit | Bit.DETAILED_ERROR_CODES, less)
    assert answer == code or (bit == Bit.MAX_JERK and answer == NcError.SAW_MAX_JERK)
    assert check_course(which, bit, less) == NcError.SYNCHRONISING_PROFILE
    assert check_course(which, bit, less, nominal=True) == 0


def test_acceleration_and_deceleration_are_distinguished() -> None:
    grows, shrinks = FAST.strongest()
    both = Bit.MAX_ACCELERATION | Bit.MAX_DECELERATION | Bit.DETAILED_ERROR_CODES
    assert check_course(FAST, both, FlyingSawLimits(1e9, grows, shrinks, 1e9)) == 0
    answer = check_course(FAST, both, FlyingSawLimits(1e9, 0.99 * grows, shrinks, 1e9))
    assert answer == NcError.SAW_ACCELERATION
    answer = check_course(FAST, both, FlyingSawLimits(1e9, grows, 0.99 * shrinks, 1e9))
    assert answer == NcError.SAW_DECELERATION


def test_soft_limits() -> None:
    detailed = Bit.MIN_POSITION | Bit.MAX_POSITION | Bit.DETAILED_ERROR_CODES
    low, high = SWINGS.least(0).value, SWINGS.most(0).value
    assert low < -5.0
    limits = FREE._replace(least_position=low, most_position=high)
    assert check_course(SWINGS, detailed, limits) == 0
    below = limits._replace(least_position=low + 0.01)
    assert check_course(SWINGS, detailed, below) == NcError.SAW_MIN_POSITION
    above = limits._replace(most_position=high - 0.01)
    assert check_course(SWINGS, detailed, above) == NcError.SAW_MAX_POSITION
    assert check_course(SWINGS, Bit.DETAILED_ERROR_CODES, below) == 0
