"""Motion functions: points, and the laws by which the slave goes from one to the next.

A point says where master and slave are, and the slave's velocity, acceleration and jerk there, for
a master velocity of 1; its function type is the law of the segment that begins at it
(`achse.motion.laws.table.MotionLaw`). The segment ends at the point that is `following` rows on,
1 as a rule; points of the type `IGNORED` are passed over, whatever else is in them.

Source: 002 §6.4.8.1. What it leaves open is our choice: 0 as relative index means the next row (the
manual's default), the last row ends the function whatever it says, and point types but 1 are stored
and have no effect.
"""

from array import array
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import isfinite
from typing import NamedTuple

from achse.codes import NcError
from achse.motion.laws.element import (
    BEGIN,
    ELEMENT,
    element_at,
    element_values,
    elements_of,
)
from achse.motion.laws.extremes import Extreme, extremes_of
from achse.motion.laws.table import LAWS, Ends, segment, standing
from achse.motion.tables.errors import TableError

IGNORED = 1
"""Point type of a point that is not there (002 §6.4.8.1)."""

_SHORTEST_STEP = 1e-9
_FARTHEST = 1e9
"""Between these bounds every function is finite."""


class MotionPoint(NamedTuple):
    """A point of a motion function, as it is stored."""

    number: int = 0
    """Its index; nothing depends on it."""
    function_type: int = 0
    """The law of the segment that begins here; that of the last point has no effect."""
    point_type: int = 0
    """1: the point is passed over."""
    following: int = 1
    """Rows from here to the end of the segment."""
    reserved: int = 0
    master_position: float = 0.0
    slave_position: float = 0.0
    slave_velocity: float = 0.0
    slave_acceleration: float = 0.0
    slave_jerk: float = 0.0
    """Per unit of the master: velocity, acceleration and jerk at a master velocity of 1."""


def _path(points: Sequence[MotionPoint]) -> Iterator[tuple[int, MotionPoint]]:
    """Yield the points of the function in their order, with their rows."""
    last = len(points) - 1
    row = 0
    while row <= last and points[row].point_type == IGNORED:
        row += 1
    while row <= last:
        yield row, points[row]
        ahead = points[row].following or 1
        if row == last:
            return
        if ahead < 0 or row + ahead > last:
            raise TableError(
                NcError.TABLE_POINT_INDEX,
                f"row {row} leads to row {row + ahead}, expected {row + 1}..{last}",
            )
        row += ahead
        while row <= last and points[row].point_type == IGNORED:
            row += 1


def function_elements(points: Sequence[MotionPoint]) -> "array[float]":
    """Return the elements of a motion function (`achse.motion.laws.element`).

    Raises TableError: 0x4A23 fewer than two points, 0x4A06 master positions that do not rise,
    0x4A1F a segment that leads nowhere, 0x4A08 a function type that is not known, 0x4A1C numbers
    that are not finite or too large.
    """
    path = list(_path(points))
    if len(path) < 2:
        raise TableError(
            NcError.TABLE_TOO_FEW_POINTS,
            f"{len(path)} points that are not ignored, expected 2 or more",
        )
    numbers = array("d")
    for (row, begin), (end_row, end) in pairwise(path):
        way = end.master_position - begin.master_position
        for each, point in ((row, begin), (end_row, end)):
            if not all(isfinite(number) and abs(number) <= _FARTHEST for number in point[5:]):
                raise TableError(
                    NcError.TABLE_PARAMETER, f"row {each}: numbers up to ±{_FARTHEST:g} expected"
                )
        if not way >= _SHORTEST_STEP:
            raise TableError(
                NcError.TABLE_NOT_MONOTONIC,
                f"master position {end.master_position:g} of row {end_row} is not above"
                f" {begin.master_position:g} of row {row}",
            )
        if begin.function_type not in LAWS:
            raise TableError(
                NcError.TABLE_INTERPOLATION_TYPE,
                f"row {row}: function type {begin.function_type},"
                f" expected {', '.join(str(int(law)) for law in LAWS)}",
            )
        numbers += segment(
            begin.function_type,
            begin.master_position,
            end.master_position,
            begin.slave_position,
            Ends(
                end.slave_position - begin.slave_position,
                begin.slave_velocity * way,
                begin.slave_acceleration * way**2,
                begin.slave_jerk * way**3,
                end.slave_velocity * way,
                end.slave_acceleration * way**2,
                end.slave_jerk * way**3,
            ),
        )
    last = path[-1][1]
    return numbers + standing(last.master_position, last.slave_position)


def values_at(numbers: "array[float]", place: float) -> tuple[float, float, float, float]:
    """Slave position, velocity, acceleration and jerk at a master position of the function."""
    number = element_at(numbers, 0, len(numbers) // ELEMENT, -1, place)
    return element_values(numbers, ELEMENT * number, place)


def survey_function(numbers: "array[float]") -> list[float]:
    """Return the characteristic values of a motion function in the order of
    `achse.motion.tables.survey`.

    Master velocity 1; what the slave demands is exact, see `achse.motion.laws.extremes`.
    """
    extremes = extremes_of(numbers)
    each = list(elements_of(numbers))
    first, last = each[0], each[-2]
    begin, end = first[BEGIN], numbers[len(numbers) - ELEMENT + BEGIN]

    def side(which: int) -> list[float]:
        position, velocity = extremes.position[which], extremes.velocity[which]
        acceleration: Extreme = extremes.acceleration[which]
        return [
            *(position.master, position.value, velocity.master, velocity.value),
            *(acceleration.master, acceleration.value, acceleration.velocity),
            *(extremes.jerk[which].value, extremes.momentum[which].value),
        ]

    return [
        1.0,
        *(begin, *element_values(first, 0, begin)),
        *(end, *element_values(last, 0, end)),
        *side(0),
        *side(1),
        extremes.mean_velocity,
        extremes.effective_acceleration,
    ]
