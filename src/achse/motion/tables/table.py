"""One table: its numbers in rows and columns, or the points of its motion function.

A characteristic has the velocity in its first column and the output in its second, each as a share
of the full one. A cam table has master positions and slave positions; with one column the master
position is the number of the row. A motion function has points instead of numbers. Source: 002
§6.4.8.
"""

import struct
from array import array
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import floor
from typing import NamedTuple

from achse.codes import NcError
from achse.codes.nc.choices import CharacteristicInterpolation, TableSubType, TableType
from achse.motion.control.curves import CurveSpan, linear, spline
from achse.motion.laws.element import BEGIN, COEFFICIENT, ELEMENT
from achse.motion.tables.checking import extremes_of
from achse.motion.tables.errors import TableError
from achse.motion.tables.function import MotionPoint, function_elements, values_at
from achse.motion.tables.joining import Boundary

HIGHEST_TABLE_ID = 4095

MOST_NUMBERS = 1 << 25
"""Most numbers in all tables of an NC, 256 MB; more is refused as out of memory. The largest cam
table of 002, with 2 columns, is as large. Of clients: `achse.motion.tables.limits`."""

_FEW = 8
"""A change of a larger part than one of so many is looked at with the whole table."""

MOTION_POINT = struct.Struct("<IHHiI5d")
"""A point of a motion function: index, function type, point type, relative index of the next
point, a reserved word; master position, slave position, its velocity, acceleration and jerk."""

_POINT_NUMBERS = MOTION_POINT.size // 8
"""Numbers that take as much memory as a point."""

EQUIDISTANT = (TableSubType.EQUIDISTANT_LINEAR, TableSubType.EQUIDISTANT_CYCLIC)
CYCLIC = (TableSubType.EQUIDISTANT_CYCLIC, TableSubType.MONOTONIC_CYCLIC)
MONOTONIC = (TableSubType.MONOTONIC_LINEAR, TableSubType.MONOTONIC_CYCLIC)

_SUB_TYPES: dict[TableType, tuple[TableSubType, ...]] = {
    TableType.CAMMING: tuple(TableSubType),
    TableType.CHARACTERISTIC: (TableSubType.EQUIDISTANT_LINEAR, TableSubType.MONOTONIC_LINEAR),
    TableType.MOTION_FUNCTION: MONOTONIC,
}
"""Sub-types that a kind of table may have (002 §6.4.8.3)."""

_SHORTEST_STEP = 1e-9
_LARGEST_SHARE = 1e3
_FARTHEST = 1e9
"""Between these bounds every curve is finite: shares of characteristics, positions of cams."""

_EQUAL = 1e-9
"""Steps that differ by this part of themselves are equal."""


@dataclass(frozen=True, slots=True)
class TableParameters:
    """A table that is there from the start: place and value of each point, or the points of a
    motion function."""

    table_id: int
    points: Sequence[tuple[float, float]] | Sequence[MotionPoint]
    name: str = ""
    sub_type: TableSubType = TableSubType.MONOTONIC_LINEAR
    main_type: TableType = TableType.CHARACTERISTIC
    boundary: Boundary = Boundary.BY_TYPE
    begin_slope: float = 0.0
    end_slope: float = 0.0
    """Slopes of a cam's spline at its ends, where `boundary` requires them."""


class TableScaling(NamedTuple):
    """Scaling of a monotonic table: place = offset + scaling · number, in both columns.

    `range_low` and `range_high` bound the rows for which it holds, by their number in the first
    column; both 0: for all. `weight` multiplies the values of these rows.
    """

    weight: float = 1.0
    master_offset: float = 0.0
    master_scaling: float = 1.0
    slave_offset: float = 0.0
    slave_scaling: float = 1.0
    range_low: float = 0.0
    range_high: float = 0.0


class PointActivation(NamedTuple):
    """Activation of the changed points of a motion function, and its scaling then (0x1A)."""

    activation: int = 0
    """`CamActivation`"""
    position: float = 0.0
    master_scaling_type: int = 0
    slave_scaling_type: int = 0
    """`CamScaling`"""


class Table:
    """`row_count` × `column_count` numbers or points, all 0 at first.

    `values` has numbers row by row, `motion` the bytes of points (`MOTION_POINT`). Places, in the
    first column, rise strictly, in equal steps if the sub-type says so.
    """

    def __init__(
        self,
        table_id: int,
        main_type: TableType,
        sub_type: int,
        row_count: int,
        column_count: int,
        name: str = "",
    ) -> None:
        """Make an empty table. Raises TableError: 0x4A00 id, 0x4A07 sub-type, 0x4A02 rows,
        0x4A03 columns, 0x4A11."""
        if not 1 <= table_id <= HIGHEST_TABLE_ID:
            raise TableError(
                NcError.TABLE_ID_RANGE, f"table {table_id}, expected 1..{HIGHEST_TABLE_ID}"
            )
        if sub_type not in _SUB_TYPES[main_type]:
            expected = ", ".join(f"{kind.value}" for kind in _SUB_TYPES[main_type])
            raise TableError(NcError.TABLE_SUB_TYPE, f"type {sub_type}, expected {expected}")
        if row_count < 2:
            raise TableError(NcError.TABLE_ROW_COUNT, f"{row_count} rows, expected 2 or more")
        if column_count < 1:
            raise TableError(NcError.TABLE_COLUMN_COUNT, "no columns, expected 1 or more")
        of_points = main_type == TableType.MOTION_FUNCTION
        self.size = row_count * column_count * (_POINT_NUMBERS if of_points else 1)
        """Memory it takes, in numbers."""
        if self.size > MOST_NUMBERS:
            raise TableError(
                NcError.TABLE_NO_MEMORY,
                f"{row_count} × {column_count} take {self.size} numbers, at most {MOST_NUMBERS}",
            )
        self.table_id = table_id
        self.table_name = name or f"Table {table_id}"
        self.table_main_type = main_type
        self.table_sub_type = TableSubType(sub_type)
        self.row_count = row_count
        self.column_count = column_count
        self.values = array("d") if of_points else array("d", [0.0]) * self.size
        self.motion = bytearray(8 * self.size if of_points else 0)
        self.scaling = TableScaling()
        self.boundary = Boundary.BY_TYPE, 0.0, 0.0
        """Boundary condition of a spline, and its slopes at its ends."""
        self.nominal_velocity = 1.0
        """Master velocity for which characteristic values are shown."""
        self.filled = False
        """True if anything was written to it."""
        self._function: tuple[array[float], array[float]] | None = None
        self._steps = 0.0, 0.0
        """Bounds of the distances of the places in there."""
        self._elements: array[float] | None = None
        self.online = PointActivation()
        """Activation of changed points where a slave uses them."""
        self.last_written = 0
        """Index of the number that was written last."""

    @property
    def of_points(self) -> bool:
        """True if it is a motion function: it has points instead of numbers."""
        return self.table_main_type == TableType.MOTION_FUNCTION

    def demand_points(self) -> None:
        """Raise TableError 0x4262 unless it is a motion function."""
        if not self.of_points:
            raise TableError(NcError.TABLE_WRONG_KIND, f"{self!r} has no points")

    @property
    def element_count(self) -> int:
        return self.row_count * self.column_count

    @property
    def cyclic(self) -> bool:
        """True if it goes on from its first row when the last is passed."""
        return self.table_sub_type in CYCLIC

    @property
    def equidistant(self) -> bool:
        return self.table_sub_type in EQUIDISTANT

    def places(self, low: int = 0, high: int | None = None) -> "array[float]":
        """Return the first column as it is read, or the numbers of the rows where there is but one;
        of the rows from `low` to `high`, which is not among them.

        Of a motion function its first and last place. Raises TableError if its points are none.
        """
        if self.of_points:
            elements = self.function()
            return array("d", (elements[BEGIN], elements[BEGIN - ELEMENT]))
        high = self.row_count if high is None else high
        if self.column_count == 1:
            return array("d", range(low, high))
        raw = self._column(0, low, high)
        scaling = self.scaling
        if scaling == TableScaling():
            return raw
        begin, end = scaling.range_low, scaling.range_high
        everywhere = begin == end == 0.0
        offset, factor = scaling.master_offset, scaling.master_scaling
        for row, place in enumerate(raw):
            if everywhere or begin <= place <= end:
                raw[row] = offset + factor * place
        return raw

    def slaves(self, low: int = 0, high: int | None = None) -> "array[float]":
        """Return the second column as it is read, or the only one; of a motion function as
        `places`."""
        if self.of_points:
            elements = self.function()
            first, *_ = values_at(elements, elements[BEGIN])
            return array("d", (first, elements[COEFFICIENT - ELEMENT]))
        high = self.row_count if high is None else high
        raw = self._column(min(1, self.column_count - 1), low, high)
        scaling = self.scaling
        if scaling == TableScaling():
            return raw
        begin, end = scaling.range_low, scaling.range_high
        everywhere = begin == end == 0.0
        offset, factor = scaling.slave_offset, scaling.weight * scaling.slave_scaling
        for row, place in enumerate(self._column(0, low, high)):
            if everywhere or begin <= place <= end:
                raw[row] = offset + factor * raw[row]
        return raw

    def _column(self, column: int, low: int, high: int) -> "array[float]":
        """Return numbers of a column, as they were written."""
        columns = self.column_count
        return self.values[low * columns + column : high * columns : columns]

    def function(self) -> "array[float]":
        """Return the elements of a motion function, of the points in its first column.

        Raises TableError if they are none, see `achse.motion.tables.function`.
        """
        if self._elements is None:
            step = MOTION_POINT.size * self.column_count
            each = range(0, len(self.motion), step)
            points = [MotionPoint(*MOTION_POINT.unpack_from(self.motion, at)) for at in each]
            try:
                self._elements = function_elements(points)
            except TableError as fault:
                raise TableError(fault.error, f"{self!r}, {fault}") from None
        return self._elements

    @property
    def step_width(self) -> float:
        """Distance of places, 0 unless they are equidistant."""
        if not self.equidistant:
            return 0.0
        return 1.0 if self.column_count == 1 else self.values[self.column_count] - self.values[0]

    @property
    def master_period(self) -> float:
        """From the first place to the last."""
        places = self._ends(self.places)
        return places[-1] - places[0]

    @property
    def slave_stroke(self) -> float:
        """From the first value to the last: the lift of each period."""
        slaves = self._ends(self.slaves)
        return slaves[-1] - slaves[0]

    def _ends(self, column: "Callable[[int, int], array[float]]") -> "array[float]":
        """Return a column in its first and its last row."""
        if self.of_points:
            return column(0, 0)
        return column(0, 1) + column(self.row_count - 1, self.row_count)

    def changed(self, low: int = 0, high: int = 0) -> None:
        """Note that its rows from `low` to `high` are others now, or all. Of a function few rows
        are looked at with their neighbours at once; what is none any more is seen by `checked`."""
        self._elements = None
        if self._function is None or not 0 < high - low <= self.row_count // _FEW:
            self._function = None
            return
        places, slaves = self._function
        fresh = self.places(low, high), self.slaves(low, high)
        places[low:high], slaves[low:high] = fresh
        near = places[max(low - 1, 0) : high + 1]
        shortest, longest, _ = extremes_of(near, near)
        self._steps = min(self._steps[0], shortest), max(self._steps[1], longest)
        far = max(max(map(abs, each)) for each in fresh)
        if self._unlike_a_function(places, far):
            self._function = None

    def checked(self) -> "tuple[array[float], array[float]]":
        """Places and values. Raises TableError if they are not a function (0x4A03, 0x4A06 …)."""
        if self._function is not None:
            return self._function
        if self.of_points:
            self._function = self.places(), self.slaves()
            return self._function
        cam = self.table_main_type == TableType.CAMMING
        if self.column_count < 2 and not (cam and self.equidistant):
            raise TableError(NcError.TABLE_COLUMN_COUNT, f"{self!r}: 1 column, expected 2 or more")
        places, slaves = self.places(), self.slaves()
        shortest, longest, far = extremes_of(places, slaves)
        self._steps = shortest, longest
        fault = self._unlike_a_function(places, far)
        if fault:
            raise fault
        self._function = places, slaves
        return self._function

    def _unlike_a_function(self, places: "array[float]", far: float) -> TableError | None:
        """Return the error in steps of these bounds and numbers that reach so far, or None."""
        shortest, longest = self._steps
        if not shortest >= _SHORTEST_STEP:
            return TableError(
                NcError.TABLE_NOT_MONOTONIC,
                f"{self!r}: its places do not rise, by {_SHORTEST_STEP:g} at least",
            )
        if self.equidistant:
            reach = _EQUAL * max(abs(places[0]), abs(places[-1]))
            if longest - shortest > reach:
                return TableError(NcError.TABLE_STEP_WIDTH, f"{self!r}: its steps are not equal")
        if self.table_main_type == TableType.CAMMING and far > _FARTHEST:
            return TableError(
                NcError.TABLE_PARAMETER, f"{self!r}: its positions are up to {_FARTHEST:g}"
            )
        return None

    def points(self) -> list[tuple[float, float]]:
        """Place and value of each row. Raises TableError if they are not a function (0x4A03 …)."""
        return list(zip(*self.checked(), strict=True))

    def curve(self, interpolation: int = CharacteristicInterpolation.LINEAR) -> list[CurveSpan]:
        """Return the characteristic that the points are.

        Raises TableError, 0x4262 if the table is none, 0x4A21 for a spline through 2 points.
        """
        if self.table_main_type != TableType.CHARACTERISTIC:
            raise TableError(
                NcError.TABLE_WRONG_KIND, f"{self!r} is for {self.table_main_type.name}"
            )
        points = self.points()
        if max(abs(number) for point in points for number in point) > _LARGEST_SHARE:
            raise TableError(
                NcError.TABLE_PARAMETER,
                f"{self!r}: its numbers are shares up to {_LARGEST_SHARE:g}",
            )
        if interpolation == CharacteristicInterpolation.LINEAR:
            return linear(points)
        if len(points) < 3:
            raise TableError(
                NcError.TABLE_TOO_FEW_SPLINE_POINTS, f"{self!r}: 2 points, a spline takes 3"
            )
        return spline(points)

    def read(self, place: float) -> tuple[float, float, float]:
        """Value at a place and its first two derivatives, rows joined by straight lines.

        Cyclic tables go on to both sides, with their lift. Raises TableError: 0x4A19 below a linear
        table, 0x4A1A above it.
        """
        places, slaves = self.checked()
        lift = 0.0
        if self.cyclic:
            cycle = floor((place - places[0]) / (places[-1] - places[0]))
            place -= cycle * (places[-1] - places[0])
            lift = cycle * (slaves[-1] - slaves[0])
        elif place < places[0]:
            raise TableError(NcError.TABLE_MASTER_BELOW, f"{place:g} below {places[0]:g}")
        elif place > places[-1]:
            raise TableError(NcError.TABLE_MASTER_ABOVE, f"{place:g} above {places[-1]:g}")
        if self.of_points:
            s, v, a, _ = values_at(self.function(), place)
            return s + lift, v, a
        row = min(max(bisect_right(places, place) - 1, 0), len(places) - 2)
        slope = (slaves[row + 1] - slaves[row]) / (places[row + 1] - places[row])
        return slaves[row] + lift + (place - places[row]) * slope, slope, 0.0

    def __repr__(self) -> str:
        return f"table {self.table_id}"
