"""Survey: what a cam demands of its slave, the characteristic values of a table (002 §6.4.9).

Positions and their derivatives by the master position. Extremes are exact: a cubic has them at its
ends and where a derivative of it is 0.

Kernel source: `survey` is compiled as it stands where machine code is at hand.
"""

import itertools
from collections.abc import Callable, Iterable, MutableSequence, Sequence
from math import floor, inf, sqrt
from typing import TypeAlias

from achse.motion.tables.memory import COUNT, HEADER, SPAN
from achse.native.compiled import Kernel

CurveValues: TypeAlias = tuple[float, float, float, float]
"""Slave position and its three derivatives by the master position."""

VALUES = 31
"""Characteristic values, by their number in the list below."""

VELOCITY = 0
START = 1
"""Master position, slave position and its three derivatives."""
END = 6
LEAST = 11
"""Master position and least slave position, the same of velocity and acceleration, velocity there,
jerk, velocity times acceleration."""
GREATEST = 20
MEAN_VELOCITY = 29
EFFECTIVE_ACCELERATION = 30

_ACCELERATION = 4
_VELOCITY_THERE = 6
_JERK = 7
_MOMENTUM = 8

_POWERS = {
    1: (3, 8, 14, 17, 23, 26, 29),
    2: (4, 9, 16, 25, 30),
    3: (5, 10, 18, 19, 27, 28),
}
"""Values that grow with the master velocity, with its square and its cube."""

_GAUSS = ((0.0, 128 / 225), (0.5384693101056831, 0.47862867049936647),
          (-0.5384693101056831, 0.47862867049936647), (0.9061798459386640, 0.23692688505618908),
          (-0.9061798459386640, 0.23692688505618908))  # fmt: skip
"""Places and weights of an integral by five points."""

_SAMPLES = 32
"""Parts of a segment in which another curve than a cubic is looked at."""


def begin_survey(results: MutableSequence[float]) -> None:
    """Clear the results: no value was met yet."""
    for n in range(VALUES):
        results[n] = 0.0
    results[VELOCITY] = 1.0
    for n in range(_MOMENTUM + 1):
        if n % 2 == 1 or n == _MOMENTUM:
            results[LEAST + n] = inf
            results[GREATEST + n] = -inf


def meet(
    results: MutableSequence[float], place: float, s: float, v: float, a: float, j: float
) -> None:
    """Compare with what was met before."""
    if s < results[LEAST + 1]:
        results[LEAST] = place
        results[LEAST + 1] = s
    if v < results[LEAST + 3]:
        results[LEAST + 2] = place
        results[LEAST + 3] = v
    if a < results[LEAST + 5]:
        results[LEAST + _ACCELERATION] = place
        results[LEAST + 5] = a
        results[LEAST + _VELOCITY_THERE] = v
    if j < results[LEAST + _JERK]:
        results[LEAST + _JERK] = j
    if v * a < results[LEAST + _MOMENTUM]:
        results[LEAST + _MOMENTUM] = v * a
    if s > results[GREATEST + 1]:
        results[GREATEST] = place
        results[GREATEST + 1] = s
    if v > results[GREATEST + 3]:
        results[GREATEST + 2] = place
        results[GREATEST + 3] = v
    if a > results[GREATEST + 5]:
        results[GREATEST + _ACCELERATION] = place
        results[GREATEST + 5] = a
        results[GREATEST + _VELOCITY_THERE] = v
    if j > results[GREATEST + _JERK]:
        results[GREATEST + _JERK] = j
    if v * a > results[GREATEST + _MOMENTUM]:
        results[GREATEST + _MOMENTUM] = v * a


def end_survey(results: MutableSequence[float], period: float) -> None:
    """Turn sums over the whole curve into means."""
    results[MEAN_VELOCITY] = results[MEAN_VELOCITY] / period
    results[EFFECTIVE_ACCELERATION] = sqrt(results[EFFECTIVE_ACCELERATION] / period)


def _show_end(
    results: MutableSequence[float],
    first: int,
    place: float,
    s: float,
    v: float,
    a: float,
    j: float,
) -> None:
    results[first] = place
    results[first + 1] = s
    results[first + 2] = v
    results[first + 3] = a
    results[first + 4] = j


def _meet_cubic(
    results: MutableSequence[float], cams: Sequence[float], at: int, way: float
) -> float:
    """Meet the curve at a way from the begin of its span; its slave position there."""
    slope, square, cube = cams[at + 2], cams[at + 3], cams[at + 4]
    s = cams[at + 1] + way * (slope + way * (square + way * cube))
    v = slope + way * (2.0 * square + 3.0 * way * cube)
    a = 2.0 * square + 6.0 * way * cube
    meet(results, cams[at] + way, s, v, a, 6.0 * cube)
    return s


def survey(cams: Sequence[float], first: int, results: MutableSequence[float]) -> None:
    """Write all values of the cam at `first`, for a master velocity of 1."""
    begin_survey(results)
    count = floor(cams[first + COUNT])
    rows = first + HEADER
    mean = 0.0
    effective = 0.0
    for row in range(count - 1):
        at = rows + SPAN * row
        width = cams[at + SPAN] - cams[at]
        slope, square, cube = cams[at + 2], cams[at + 3], cams[at + 4]
        start = _meet_cubic(results, cams, at, 0.0)
        end = _meet_cubic(results, cams, at, width)
        low = width
        high = width
        if cube != 0.0:
            # velocity is extreme at -square / 3 cube, 0 on either side of it
            middle = -square / (3.0 * cube)
            spread = middle * middle - slope / (3.0 * cube)
            if 0.0 < middle < width:
                _meet_cubic(results, cams, at, middle)
            if spread > 0.0:
                root = sqrt(spread)
                low = middle - root
                high = middle + root
            # (v a)' = a² + v j is 0 where 3 (w - middle)² = spread
            if spread > 0.0:
                root = sqrt(spread / 3.0)
                if 0.0 < middle - root < width:
                    _meet_cubic(results, cams, at, middle - root)
                if 0.0 < middle + root < width:
                    _meet_cubic(results, cams, at, middle + root)
        elif square != 0.0:
            low = -0.5 * slope / square
        before = start
        if 0.0 < low < width:
            turn = _meet_cubic(results, cams, at, low)
            mean += abs(turn - before)
            before = turn
        if 0.0 < high < width:
            turn = _meet_cubic(results, cams, at, high)
            mean += abs(turn - before)
            before = turn
        mean += abs(end - before)
        bend = 2.0 * square
        other = bend + 6.0 * cube * width
        effective += width * (bend * bend + bend * other + other * other) / 3.0
    at = rows
    _show_end(
        results, START, cams[at], cams[at + 1], cams[at + 2], 2.0 * cams[at + 3], 6.0 * cams[at + 4]
    )
    at = rows + SPAN * (count - 2)
    width = cams[at + SPAN] - cams[at]
    square, cube = cams[at + 3], cams[at + 4]
    _show_end(
        results,
        END,
        cams[at + SPAN],
        cams[at + SPAN + 1],
        cams[at + 2] + width * (2.0 * square + 3.0 * width * cube),
        2.0 * square + 6.0 * width * cube,
        6.0 * cube,
    )
    results[MEAN_VELOCITY] = mean
    results[EFFECTIVE_ACCELERATION] = effective
    end_survey(results, cams[rows + SPAN * (count - 1)] - cams[rows])


def survey_curve(
    parts: Iterable[tuple[float, float, Callable[[float], CurveValues]]],
) -> list[float]:
    """Return the same of any curve: begin, end and values of each part, which are smooth within
    it."""
    results = [0.0] * VALUES
    begin_survey(results)
    begins: list[tuple[float, CurveValues]] = []
    last = 0.0, (0.0, 0.0, 0.0, 0.0)
    for begin, end, values in parts:
        width = (end - begin) / _SAMPLES
        places = [*(begin + n * width for n in range(_SAMPLES)), end]
        marks = [values(place) for place in places]
        for place, mark in zip(places, marks, strict=True):
            meet(results, place, *mark)
        places += _extremes(places, marks, values)
        places.sort()
        for place, after in itertools.pairwise(places):
            meet(results, place, *values(place))
            results[MEAN_VELOCITY] += abs(values(after)[0] - values(place)[0])
            half, middle = 0.5 * (after - place), 0.5 * (after + place)
            results[EFFECTIVE_ACCELERATION] += half * sum(
                weight * values(middle + half * where)[2] ** 2 for where, weight in _GAUSS
            )
        begins.append((begin, marks[0]))
        last = end, marks[-1]
    _show_end(results, START, begins[0][0], *begins[0][1])
    _show_end(results, END, last[0], *last[1])
    end_survey(results, last[0] - begins[0][0])
    return results


_HALVINGS = 60


def _extremes(
    places: Sequence[float],
    marks: Sequence[CurveValues],
    values: Callable[[float], CurveValues],
) -> list[float]:
    """Places where a derivative passes 0: what it is the derivative of is extreme there."""
    zeros = []
    for low, high, before, after in zip(places, places[1:], marks, marks[1:], strict=False):
        for n in (1, 2, 3):
            if before[n] * after[n] < 0.0:
                near, far = low, high
                for _ in range(_HALVINGS):
                    middle = 0.5 * (near + far)
                    if values(middle)[n] * before[n] > 0.0:
                        near = middle
                    else:
                        far = middle
                zeros.append(near)
    return zeros


def at_velocity(results: Sequence[float], velocity: float) -> list[float]:
    """Return the values of a survey at another master velocity."""
    if velocity < 0.0:
        raise ValueError(f"master velocity {velocity:g}, expected 0 or more")
    values = list(results)
    values[VELOCITY] = velocity
    for power, numbers in _POWERS.items():
        for n in numbers:
            values[n] *= velocity**power
    return values


SURVEY = Kernel("survey", survey, {})
"""`survey` as machine code, for tables of many rows."""
