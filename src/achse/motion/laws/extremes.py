"""Extreme values of a function made of elements, and its means, exactly.

Between the roots of its derivative a value rises or falls, so its extremes are there or at the ends
of elements. Roots of polynomials come from those of their derivatives, by halving; with sines the
derivative is searched in steps that are short against their turn.
"""

from array import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import copysign, sin, sqrt

from achse.motion.laws.element import (
    BEGIN,
    COEFFICIENT,
    DEGREE,
    RATE,
    SECOND_SIZE,
    SIZE,
    element_values,
    elements_of,
)
from achse.motion.profiles.polynomials import derivative, evaluate

_MOST_STEPS = 60
"""Of a search: each halves, to the last bits."""

_STEPS = 64
"""Of an element with sines, of which each has two turns at most."""

_NODES = (
    (0.09501250983763744, 0.1894506104550685),
    (0.28160355077925891, 0.1826034150449236),
    (0.45801677765722739, 0.1691565193950025),
    (0.61787624440264375, 0.1495959888165767),
    (0.75540440835500303, 0.1246289712555339),
    (0.86563120238783174, 0.0951585116824928),
    (0.94457502307323258, 0.0622535239386479),
    (0.98940093499164993, 0.0271524594117541),
)
"""Gauss and Legendre: places and weights of 16 values, exact to degree 31."""


@dataclass(frozen=True, slots=True)
class Extreme:
    """A value, where on the master it is, and the slave's velocity there."""

    value: float = 0.0
    master: float = 0.0
    velocity: float = 0.0


@dataclass(frozen=True, slots=True)
class Extremes:
    """Least and greatest of each value, at a master velocity of 1; jumps count by their sides."""

    position: tuple[Extreme, Extreme]
    velocity: tuple[Extreme, Extreme]
    acceleration: tuple[Extreme, Extreme]
    jerk: tuple[Extreme, Extreme]
    momentum: tuple[Extreme, Extreme]
    """Velocity times acceleration."""
    mean_velocity: float
    """Mean of its amount."""
    effective_acceleration: float
    """Root of the mean of its square."""


def _product(left: Sequence[float], right: Sequence[float]) -> list[float]:
    product = [0.0] * max(len(left) + len(right) - 1, 0)
    for i, one in enumerate(left):
        for k, other in enumerate(right):
            product[i + k] += one * other
    return product


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a function that changes its sign between `low` and `high`."""
    before, after = function(low), function(high)
    for _ in range(_MOST_STEPS):
        rise = after - before  # 0 where both are too small to halve
        place = high - after * (high - low) / rise if rise else 0.5 * (low + high)
        if not low < place < high:
            place = 0.5 * (low + high)
            if not low < place < high:
                break
        value = function(place)
        if value == 0.0:
            return place
        width = high - low
        if (value < 0.0) == (before < 0.0):
            low, before, after = place, value, 0.5 * after
        else:
            high, after, before = place, value, 0.5 * before
        if high - low > 0.5 * width:  # the chord has not halved it
            place = 0.5 * (low + high)
            value = function(place)
            if (value < 0.0) == (before < 0.0):
                low, before = place, value
            else:
                high, after = place, value
    return 0.5 * (low + high)


def _crossings(function: Callable[[float], float], places: Sequence[float]) -> list[float]:
    """Roots of a function that has at most one between any two neighbours of `places`."""
    values = [function(each) for each in places]
    roots = [each for each, value in zip(places, values, strict=True) if value == 0.0]
    for (low, before), (high, after) in pairwise(zip(places, values, strict=True)):
        if before and after and (before < 0.0) != (after < 0.0):
            roots.append(_root(function, low, high))
    return sorted(roots)


def _polynomial_roots(coefficients: Sequence[float], width: float) -> list[float]:
    """Roots within 0..width; none of what is 0 everywhere."""
    trimmed = list(coefficients)
    while trimmed and trimmed[-1] == 0.0:
        trimmed.pop()
    if len(trimmed) < 2:
        return []
    if len(trimmed) == 2:
        root = -trimmed[0] / trimmed[1]
        return [root] if 0.0 <= root <= width else []
    if len(trimmed) == 3:
        return [root for root in _quadratic_roots(*trimmed) if 0.0 <= root <= width]
    turns = _polynomial_roots(derivative(trimmed), width)
    return _crossings(lambda w: evaluate(trimmed, w), [0.0, *turns, width])


def _quadratic_roots(c: float, b: float, a: float) -> list[float]:
    """Roots of a x² + b x + c, a not 0, the smaller first."""
    inner = b * b - 4.0 * a * c
    if inner < 0.0:
        return []
    sum_of = -0.5 * (b + copysign(sqrt(inner), b))
    return sorted((sum_of / a, c / sum_of if sum_of else 0.0))


def _width(element: "array[float]", end: float) -> float:
    return (end - element[BEGIN]) * element[RATE]


def _critical(element: "array[float]", end: float) -> Iterator[list[float]]:
    """Master positions where position, velocity, acceleration, jerk and momentum may be extreme."""
    width = _width(element, end)
    roots_by_order: list[list[float]]
    if element[SIZE] == 0.0 and element[SECOND_SIZE] == 0.0:
        first = derivative(element[COEFFICIENT : COEFFICIENT + int(element[DEGREE]) + 1])
        second = derivative(first)
        third = derivative(second)
        square, cross = _product(second, second), _product(first, third)
        cross += [0.0] * (len(square) - len(cross))
        momentum = [one + other for one, other in zip(square, cross, strict=False)]
        roots_by_order = [
            _polynomial_roots(each, width)
            for each in (first, second, third, derivative(third), momentum)
        ]
    else:
        places = [width * n / _STEPS for n in range(_STEPS + 1)]

        def at(order: int) -> Callable[[float], float]:
            return lambda w: element_values(element, 0, element[BEGIN] + w / element[RATE])[order]

        def snap(w: float) -> float:
            """Fourth derivative: that of the sines, beside which no polynomial has one."""
            return sum(
                size * turn**4 * sin(turn * w + lead)
                for size, turn, lead in (
                    element[SIZE:SECOND_SIZE],
                    element[SECOND_SIZE:COEFFICIENT],
                )
            )

        def momentum_slope(w: float) -> float:
            _, v, a, j = element_values(element, 0, element[BEGIN] + w / element[RATE])
            return a * a + v * j

        roots_by_order = [
            _crossings(each, places) for each in (at(1), at(2), at(3), snap, momentum_slope)
        ]
    for roots in roots_by_order:
        yield [element[BEGIN] + w / element[RATE] for w in roots]


class _Range:
    """Least and greatest so far."""

    def __init__(self) -> None:
        self.least: Extreme | None = None
        self.most: Extreme | None = None

    def take(self, value: float, master: float, velocity: float) -> None:
        if self.least is None or value < self.least.value:
            self.least = Extreme(value, master, velocity)
        if self.most is None or value > self.most.value:
            self.most = Extreme(value, master, velocity)

    @property
    def pair(self) -> tuple[Extreme, Extreme]:
        return self.least or Extreme(), self.most or Extreme()


def _square_of_acceleration(element: "array[float]", end: float) -> float:
    """Return its integral over the master."""
    half = 0.5 * (end - element[BEGIN])
    middle = element[BEGIN] + half
    return half * sum(
        weight * element_values(element, 0, middle + side * half * place)[2] ** 2
        for place, weight in _NODES
        for side in (-1.0, 1.0)
    )


def turning_places(numbers: "array[float]") -> list[float]:
    """Master positions between which a function rises or falls only: ends of elements, and where
    the slave turns round."""
    places = []
    elements = list(elements_of(numbers))
    for element, following in pairwise(elements):
        places += [element[BEGIN], *next(_critical(element, following[BEGIN]))]
    return [*places, elements[-1][BEGIN]]


def extremes_of(numbers: "array[float]") -> Extremes:
    """Extremes and means of a function, given as its elements; the last one is at rest."""
    ranges = [_Range() for _ in range(5)]
    way = square = 0.0
    elements = list(elements_of(numbers))
    for element, following in pairwise(elements):
        end = following[BEGIN]
        if end <= element[BEGIN]:
            continue
        turns, *others = _critical(element, end)
        places = (element[BEGIN], *turns, end)
        positions = [element_values(element, 0, each)[0] for each in places]
        way += sum(abs(after - before) for before, after in pairwise(positions))
        square += _square_of_acceleration(element, end)
        for order, roots in enumerate((turns, *others)):
            for place in (element[BEGIN], *roots, end):
                s, v, a, j = element_values(element, 0, place)
                ranges[order].take((s, v, a, j, v * a)[order], place, v)
    last = elements[-1]
    ranges[0].take(last[COEFFICIENT], last[BEGIN], 0.0)
    span = last[BEGIN] - elements[0][BEGIN]
    position, velocity, acceleration, jerk, momentum = (each.pair for each in ranges)
    return Extremes(
        *(position, velocity, acceleration, jerk, momentum),
        *((way / span, sqrt(square / span)) if span > 0.0 else (0.0, 0.0)),
    )
