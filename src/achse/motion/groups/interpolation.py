"""Interpolation between the rows of a FIFO: a line, a cubic through 4 rows, a spline through 6.

All curves go through the rows, so that the next interval begins where the last one ends. Near the
ends of what is known the nearest rows serve. Each function takes rows of one axis.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

from achse.motion.groups.states import FifoInterpolation


def _linear(points: Sequence[float], first: int, share: float) -> float:
    """On the line from point `first` to the next; `share` of the way, 0..1."""
    begin = points[first]
    return begin + (points[first + 1] - begin) * share


def _four_point(points: Sequence[float], first: int, share: float) -> float:
    """On the cubic through all points, two to four of them (Lagrange)."""
    x = first + share
    value = 0.0
    for i, point in enumerate(points):
        weight = 1.0
        for j in range(len(points)):
            if j != i:
                weight *= (x - j) / (i - j)
        value += weight * point
    return value


@cache
def _bends(count: int) -> tuple[tuple[float, ...], ...]:
    """By point: second derivatives of the natural spline that is 1 there and 0 at the others."""
    rows = []
    for unit in range(count):
        points = [float(n == unit) for n in range(count)]
        diagonal = [4.0] * (count - 2)
        right = [6.0 * (points[n] - 2 * points[n + 1] + points[n + 2]) for n in range(count - 2)]
        for n in range(1, count - 2):
            right[n] -= right[n - 1] / diagonal[n - 1]
            diagonal[n] -= 1.0 / diagonal[n - 1]
        bend = [0.0] * count
        for n in range(count - 3, -1, -1):
            bend[n + 1] = (right[n] - bend[n + 2]) / diagonal[n]
        rows.append(tuple(bend))
    return tuple(rows)


def _spline(points: Sequence[float], first: int, share: float) -> float:
    """On the natural cubic spline through all points, two to six of them."""
    bends = _bends(len(points))
    begin = sum(point * bend[first] for point, bend in zip(points, bends, strict=True))
    end = sum(point * bend[first + 1] for point, bend in zip(points, bends, strict=True))
    rest = 1.0 - share
    return (
        rest * points[first]
        + share * points[first + 1]
        + ((rest**3 - rest) * begin + (share**3 - share) * end) / 6.0
    )


class Interpolation(NamedTuple):
    """A curve, and the rows it takes: so many before the interval, and behind its begin."""

    before: int
    behind: int
    size: int
    """Rows that it takes where there are enough."""
    curve: Callable[[Sequence[float], int, float], float]


INTERPOLATIONS = {
    FifoInterpolation.LINEAR: Interpolation(0, 1, 2, _linear),
    FifoInterpolation.FOUR_POINT: Interpolation(1, 2, 4, _four_point),
    FifoInterpolation.CUBIC_SPLINE: Interpolation(2, 3, 6, _spline),
}
