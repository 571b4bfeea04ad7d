"""The course of a slave while it synchronises, known before: its extremes, and what they add up to.

A course holds for a master of constant velocity, as its future motion is unknown. It is made
of stretches in time, each a polynomial of at most the fifth degree.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import factorial, sqrt
from typing import NamedTuple

from achse.motion.fields.synchronising import SYNC_TERMS
from achse.motion.profiles.polynomials import derivative, evaluate
from achse.motion.profiles.profile import plan_to_velocity
from achse.motion.profiles.segments import MAX_SEGMENTS, end_state

_HALVINGS = 80


def _zeros(terms: Sequence[float], end: float) -> list[float]:
    """Places between 0 and `end` where a polynomial changes its sign, rising."""
    if not any(terms[1:]):
        return []
    places = [0.0, *_zeros(derivative(terms), end), end]
    zeros = []
    for low, high in pairwise(places):
        below = evaluate(terms, low)
        if below * evaluate(terms, high) < 0.0:
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if evaluate(terms, middle) * below > 0.0:
                    low = middle
                else:
                    high = middle
            zeros.append(0.5 * (low + high))
    return zeros


@dataclass(frozen=True)
class Stretch:
    """A polynomial of the time since it begins, in slave units; it lasts `duration` seconds."""

    duration: float
    terms: tuple[float, ...]

    def derived(self, order: int) -> list[float]:
        """Terms of its derivative: 0 position, 1 velocity, 2 acceleration, 3 jerk."""
        terms = list(self.terms)
        for _ in range(order):
            terms = derivative(terms) or [0.0]
        return terms

    def places(self, order: int) -> list[float]:
        """Begin, end and all times between them where that derivative may have an extreme."""
        inner = _zeros(self.derived(order + 1), self.duration)
        return [0.0, *inner, self.duration]


class TimedValue(NamedTuple):
    """A value of a course and the time when it has it."""

    time: float
    value: float


@dataclass(frozen=True)
class SlaveCourse:
    """Motion of a slave until it runs with a master of constant velocity."""

    master_begin: float
    master_velocity: float
    stretches: tuple[Stretch, ...]

    @property
    def duration(self) -> float:
        """Seconds until it runs with its master."""
        return sum(stretch.duration for stretch in self.stretches)

    def begin(self, order: int) -> float:
        """Position, velocity, acceleration or jerk at the begin."""
        return evaluate(self.stretches[0].derived(order), 0.0) if self.stretches else 0.0

    def end(self, order: int) -> float:
        """Return the same at the end."""
        if not self.stretches:
            return 0.0
        return evaluate(self.stretches[-1].derived(order), self.stretches[-1].duration)

    def _timed(self) -> Iterator[tuple[float, Stretch]]:
        time = 0.0
        for stretch in self.stretches:
            yield time, stretch
            time += stretch.duration

    def _values(self, order: int) -> Iterator[TimedValue]:
        for time, stretch in self._timed():
            terms = stretch.derived(order)
            for place in stretch.places(order):
                yield TimedValue(time + place, evaluate(terms, place))

    def least(self, order: int) -> TimedValue:
        """Return value and time of the least position, velocity, acceleration or jerk."""
        return min(self._values(order), key=lambda place: place.value)

    def most(self, order: int) -> TimedValue:
        """Return value and time of the largest one."""
        return max(self._values(order), key=lambda place: place.value)

    def velocity_at(self, time: float) -> float:
        """Velocity after that many seconds."""
        for begin, stretch in self._timed():
            if time <= begin + stretch.duration:
                return evaluate(stretch.derived(1), time - begin)
        return self.end(1)

    def strongest(self) -> tuple[float, float]:
        """Largest acceleration and largest deceleration, by size: the speed grows, or shrinks."""
        grows = shrinks = 0.0
        for stretch in self.stretches:
            velocity, acceleration = stretch.derived(1), stretch.derived(2)
            turns = [0.0, *_zeros(velocity, stretch.duration), stretch.duration]
            for low, high in pairwise(turns):
                sign = 1.0 if evaluate(velocity, 0.5 * (low + high)) >= 0.0 else -1.0
                inner = [x for x in stretch.places(2) if low < x < high]
                for x in (low, *inner, high):
                    value = sign * evaluate(acceleration, x)
                    grows, shrinks = max(grows, value), max(shrinks, -value)
        return grows, shrinks

    def mean_speed(self) -> float:
        """Mean of the velocity by size."""
        way = 0.0
        for stretch in self.stretches:
            turns = [0.0, *_zeros(stretch.derived(1), stretch.duration), stretch.duration]
            places = [evaluate(stretch.terms, x) for x in turns]
            way += sum(abs(after - before) for before, after in pairwise(places))
        return way / self.duration if self.duration else 0.0

    def effective_acceleration(self) -> float:
        """Root of the mean square of the acceleration."""
        total = 0.0
        for stretch in self.stretches:
            terms = stretch.derived(2)
            for n, first in enumerate(terms):
                for m, second in enumerate(terms):
                    total += first * second * stretch.duration ** (n + m + 1) / (n + m + 1)
        return sqrt(total / self.duration) if self.duration else 0.0


def course_over_master(
    master_begin: float,
    master_velocity: float,
    slave_begin: float,
    lengths: Iterable[float],
    terms: Sequence[float],
) -> SlaveCourse:
    """Return the course over a master that moves with this velocity, not 0, by spans of
    `approach`."""
    stretches = []
    for n, length in enumerate(lengths):
        duration = length / abs(master_velocity)
        own = list(terms[SYNC_TERMS * n : SYNC_TERMS * (n + 1)])
        own[0] += slave_begin
        scaled = tuple(term / duration**power for power, term in enumerate(own))
        stretches.append(Stretch(duration, scaled))
    return SlaveCourse(master_begin, master_velocity, tuple(stretches))


def course_by_time(
    master_begin: float,
    master_velocity: float,
    slave: tuple[float, float, float],
    end_velocity: float,
    limits: tuple[float, float, float],
) -> SlaveCourse:
    """Return the course from position, velocity and acceleration to a velocity, by limits
    (acceleration, deceleration, jerk)."""
    times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    count = plan_to_velocity(times, jerks, slave[1], slave[2], end_velocity, *limits)
    stretches = []
    state = slave
    for n in range(max(count, 0)):
        terms = (*state, jerks[n])
        scaled = tuple(term / factorial(power) for power, term in enumerate(terms))
        stretches.append(Stretch(times[n], scaled))
        state = end_state(times[n : n + 1], jerks[n : n + 1], 1, *state)
    if not stretches:
        stretches.append(Stretch(0.0, slave[:2]))
    return SlaveCourse(master_begin, master_velocity, tuple(stretches))
