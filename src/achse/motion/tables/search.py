"""Search: at which master positions a slave is at a position (0xA000 + ID:0x24).

Kernel source: `scan` is compiled as it stands where machine code is at hand.
"""

from array import array
from collections.abc import Callable, Iterable, MutableSequence, Sequence
from dataclasses import dataclass
from math import ceil, floor, inf, sqrt
from typing import Protocol

from achse.motion.laws.element import COEFFICIENT, ELEMENT, element_at, element_values
from achse.motion.laws.extremes import turning_places
from achse.motion.tables.memory import BEGIN, COUNT, CYCLIC, HEADER, PERIOD, SPAN, STROKE
from achse.native.compiled import Kernel

_WORTH_MACHINE_CODE = 1000
"""Rows that the plain way takes some ms for."""

_HALVINGS = 60
_TOLERANCE = 1e-9
"""Relative difference of two values that counts as none."""


class MonotoneCurve(Protocol):
    """A curve that is cut where it turns round."""

    begin: float
    period: float
    stroke: float
    cyclic: bool

    def turns(
        self, backwards: bool, place: float, low: float = -inf, high: float = inf
    ) -> Iterable[float]:
        """Places from the one given on, in which direction, between which it rises or falls only,
        up to the end; where it does not come to values from `low` to `high` they may be left out.
        """

    def extent(self) -> tuple[float, float]:
        """Least and greatest value of one period."""

    def value(self, place: float) -> float:
        """Slave position."""


@dataclass(frozen=True)
class Crossing:
    """A solution: where the master is, in the cam and in all, and the lift there."""

    cam_position: float
    position: float
    lift: float


class CamCurve:
    """A cam in memory."""

    def __init__(self, cams: "array[float]", first: int) -> None:
        self._cams, self._rows = cams, first + HEADER
        self._count = int(cams[first + COUNT])
        self.begin, self.period = cams[first + BEGIN], cams[first + PERIOD]
        self.stroke, self.cyclic = cams[first + STROKE], bool(cams[first + CYCLIC])

    def _row(self, place: float) -> int:
        low, high = 0, self._count - 1
        while high - low > 1:
            middle = (low + high) // 2
            if self._cams[self._rows + SPAN * middle] <= place:
                low = middle
            else:
                high = middle
        return low

    def value(self, place: float) -> float:
        at = self._rows + SPAN * self._row(place)
        begin, value, slope, square, cube = self._cams[at : at + SPAN]
        way = place - begin
        return value + way * (slope + way * (square + way * cube))

    def turns(
        self, backwards: bool, place: float, low: float = -inf, high: float = inf
    ) -> Iterable[float]:
        yield place
        row = self._row(place)
        step = -1 if backwards else 1
        while (row := self._scan(row, step, low, high)[0]) >= 0:
            at = self._rows + SPAN * row
            begin, _, slope, square, cube, end = self._cams[at : at + SPAN + 1]
            stops = sorted((begin, *_stands(begin, end, slope, square, cube), end))
            for stop in reversed(stops) if backwards else stops:
                if stop < place if backwards else stop > place:
                    yield stop
            row += step

    def extent(self) -> tuple[float, float]:
        _, low, high = self._scan(0, 1, inf, -inf)
        return low, high

    def _scan(self, row: int, step: int, low: float, high: float) -> tuple[int, float, float]:
        """Return the first row from one on that comes to values from `low` to `high`, -1: none;
        least and greatest value on the way there."""
        results = array("d", [0.0, 0.0, 0.0])
        rest = self._rows, self._count, row, step, low, high
        if self._count >= _WORTH_MACHINE_CODE and SCANNING.available:
            rows = (each.buffer_info() for each in (self._cams, results))
            SCANNING.function(*(part for each in rows for part in each), *rest)
        else:
            scan(self._cams, results, *rest)
        return int(results[0]), results[1], results[2]


class FunctionCurve:
    """A motion function, as its elements."""

    def __init__(self, elements: "array[float]", cyclic: bool) -> None:
        self._elements, self.cyclic = elements, cyclic
        self._stops = turning_places(elements)
        self.begin, end = self._stops[0], self._stops[-1]
        self.period = end - self.begin
        self.stroke = elements[COEFFICIENT - ELEMENT] - self.value(self.begin)

    def value(self, place: float) -> float:
        number = element_at(self._elements, 0, len(self._elements) // ELEMENT, -1, place)
        return element_values(self._elements, ELEMENT * number, place)[0]

    def extent(self) -> tuple[float, float]:
        values = [self.value(place) for place in self._stops]
        return min(values), max(values)

    def turns(
        self, backwards: bool, place: float, low: float = -inf, high: float = inf
    ) -> Iterable[float]:
        yield place
        for stop in reversed(self._stops) if backwards else self._stops:
            if stop < place if backwards else stop > place:
                yield stop


def _stands(begin: float, end: float, slope: float, square: float, cube: float) -> list[float]:
    """Places within a span at which its slope is 0."""
    if cube == 0.0:
        ways = [-0.5 * slope / square] if square else []
    else:
        middle = -square / (3.0 * cube)
        spread = middle * middle - slope / (3.0 * cube)
        ways = [middle - sqrt(spread), middle + sqrt(spread)] if spread > 0.0 else []
    return [begin + way for way in ways if 0.0 < way < end - begin]


def _value_in(cams: Sequence[float], at: int, way: float) -> float:
    """Value of the span at a place of the memory, so far behind its begin."""
    return cams[at + 1] + way * (cams[at + 2] + way * (cams[at + 3] + way * cams[at + 4]))


def scan(
    cams: Sequence[float],
    results: MutableSequence[float],
    rows: int,
    count: int,
    row: int,
    step: int,
    low: float,
    high: float,
) -> None:
    """Find the first span from `row` on, by `step`, that comes to values from `low` to `high`.

    `results`: its number, -1: none; least and greatest value of the spans up to it. `rows` is where
    the first of the `count` spans is, of which the last is the end only.
    """
    least = inf
    most = -inf
    results[0] = -1.0
    while 0 <= row < count - 1:
        at = rows + SPAN * row
        width = cams[at + SPAN] - cams[at]
        slope, square, cube = cams[at + 2], cams[at + 3], cams[at + 4]
        first = cams[at + 1]
        last = _value_in(cams, at, width)
        bottom = min(first, last)
        top = max(first, last)
        once = -1.0
        twice = -1.0
        if cube != 0.0:
            middle = -square / (3.0 * cube)
            spread = middle * middle - slope / (3.0 * cube)
            if spread > 0.0:
                once = middle - sqrt(spread)
                twice = middle + sqrt(spread)
        elif square != 0.0:
            once = -0.5 * slope / square
        if 0.0 < once < width:
            turn = _value_in(cams, at, once)
            bottom = min(bottom, turn)
            top = max(top, turn)
        if 0.0 < twice < width:
            turn = _value_in(cams, at, twice)
            bottom = min(bottom, turn)
            top = max(top, turn)
        least = min(least, bottom)
        most = max(most, top)
        if bottom <= high and top >= low:
            results[0] = row
            break
        row += step
    results[1] = least
    results[2] = most


def nearest(curve: MonotoneCurve, value: float, start: float) -> tuple[Crossing | None, ...]:
    """Return the nearest solutions at or below a master position and at or above it; None: there is
    none.

    A cyclic curve goes on to both sides, with its lift.
    """
    low, high = curve.extent()
    return tuple(_towards(curve, value, start, low, high, side) for side in (True, False))


def _towards(
    curve: MonotoneCurve, value: float, start: float, low: float, high: float, backwards: bool
) -> Crossing | None:
    end = curve.begin + curve.period
    if not curve.cyclic:
        place = max(start, curve.begin) if not backwards else min(start, end)
        if not curve.begin <= place <= end:
            return None
        solution = _within(curve, value, place, backwards)
        return None if solution is None else Crossing(solution, solution, 0.0)
    cycle = floor((start - curve.begin) / curve.period)
    for n in _cycles(curve, value, cycle, low, high, backwards):
        lift = n * curve.stroke
        place = start - n * curve.period if n == cycle else end if backwards else curve.begin
        solution = _within(curve, value - lift, min(max(place, curve.begin), end), backwards)
        if solution is not None:
            return Crossing(solution, solution + n * curve.period, lift)
    return None


def _cycles(
    curve: MonotoneCurve, value: float, cycle: int, low: float, high: float, backwards: bool
) -> list[int]:
    """Return the cycle of the start, and the next one in which the value occurs."""
    step = -1 if backwards else 1
    if abs(curve.stroke) < _TOLERANCE:
        return [cycle, cycle + step]
    ends = sorted(((value - low) / curve.stroke, (value - high) / curve.stroke))
    first, last = ceil(ends[0] - _TOLERANCE), floor(ends[1] + _TOLERANCE)
    following = min(cycle + step, last) if backwards else max(cycle + step, first)
    cycles = [cycle] if first <= cycle <= last else []
    return [*cycles, following, following + step] if first <= following <= last else cycles


def _within(curve: MonotoneCurve, value: float, place: float, backwards: bool) -> float | None:
    """Return the nearest solution of one cycle from a place on."""
    before: float | None = None
    reach = _TOLERANCE * max(1.0, abs(value))
    for stop in curve.turns(backwards, place, value - 2.0 * reach, value + 2.0 * reach):
        miss = curve.value(stop) - value
        if abs(miss) <= reach:
            return stop
        if before is not None and (curve.value(before) - value) * miss < 0.0:
            return _cross(curve.value, value, before, stop)
        before = stop
    return None


def _cross(read: Callable[[float], float], value: float, near: float, far: float) -> float:
    """Return the place between two others where a rising or falling curve has a value."""
    side = read(near) - value
    for _ in range(_HALVINGS):
        middle = 0.5 * (near + far)
        if (read(middle) - value) * side > 0.0:
            near = middle
        else:
            far = middle
    return far


SCANNING = Kernel("scanning", scan, {})
"""`scan` as machine code, for tables of many rows."""
