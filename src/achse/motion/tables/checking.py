"""Checks of a table before it is joined: the steps of its places, and its range.

Kernel source: `extremes` is compiled as it stands where machine code is at hand; `extremes_of`
takes what is faster, with the same result.
"""

from array import array
from collections.abc import MutableSequence, Sequence
from operator import sub

from achse.native.compiled import Kernel

_WORTH_MACHINE_CODE = 1000
"""Rows that Python takes part of a ms for."""


def extremes(
    places: Sequence[float], values: Sequence[float], results: MutableSequence[float]
) -> None:
    """Write the shortest and longest step from a place to the next, and the largest amount of a
    place or value.

    A step from infinity to infinity, NaN, is the shortest.
    """
    shortest = places[1] - places[0]
    longest = shortest
    far = 0.0
    for i in range(len(places)):
        if abs(places[i]) > far:
            far = abs(places[i])
        if abs(values[i]) > far:
            far = abs(values[i])
        if i > 1:
            step = places[i] - places[i - 1]
            if step < shortest or step != step:
                shortest = step
            if step > longest:
                longest = step
    results[0] = shortest
    results[1] = longest
    results[2] = far


def extremes_of(places: "array[float]", values: "array[float]") -> tuple[float, float, float]:
    """Shortest and longest step, largest amount; of two rows or more."""
    if len(places) >= _WORTH_MACHINE_CODE and CHECKING.available:
        results = array("d", [0.0, 0.0, 0.0])
        rows = (each.buffer_info() for each in (places, values, results))
        CHECKING.function(*(part for row in rows for part in row))
        return results[0], results[1], results[2]
    steps = array("d", map(sub, places[1:], places[:-1]))
    far = max(max(places), max(values), -min(places), -min(values))
    return min(steps), max(steps), far


CHECKING = Kernel("checking", extremes, {})
"""`extremes` as machine code, for tables of many rows."""
