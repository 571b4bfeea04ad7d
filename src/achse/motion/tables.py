"""Tables of the NC: numbers in rows and columns by id, and the curves that drives read from them.

So far tables are characteristics of drives: the first column is the velocity, the second the
output, each as a share of the full one. Source: 002 §6.4.8.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import TYPE_CHECKING

from achse.codes import NcError
from achse.motion.curves import Piece, linear, piece_at, spline
from achse.motion.states import CharacteristicInterpolation, TableSubType, TableType

if TYPE_CHECKING:
    from achse.motion.axis import Axis
    from achse.motion.machine.hardware import AmplifierView
    from achse.motion.parts import AxisDrive

__all__ = ["HIGHEST_TABLE_ID", "Table", "TableError", "TableParameters", "Tables"]

HIGHEST_TABLE_ID = 4095

MOST_ELEMENTS = 1 << 17
"""Numbers of one table; a larger one finds no memory."""

_NOT_CYCLIC = (TableSubType.EQUIDISTANT_LINEAR, TableSubType.MONOTONIC_LINEAR)
_SUB_TYPES = {TableType.CHARACTERISTIC: _NOT_CYCLIC}
"""Sub-types that a kind of table may have."""

_SHORTEST_STEP = 1e-9
_LARGEST_SHARE = 1e3
"""Between these bounds every curve is finite."""

_EQUAL = 1e-9
"""Steps that differ by this part of themselves are equal."""


class TableError(Exception):
    """A table cannot be what was asked for: `error` is the NC's."""

    def __init__(self, error: NcError, message: str) -> None:
        super().__init__(message)
        self.error = error


@dataclass(frozen=True, slots=True)
class TableParameters:
    """A characteristic table that is there from the start: place and value of each point."""

    table_id: int
    points: Sequence[tuple[float, float]]
    name: str = ""
    sub_type: TableSubType = TableSubType.MONOTONIC_LINEAR


class Table:
    """`row_count` × `column_count` numbers; `values` has them row by row, all 0 at first.

    The first column has the places, which rise strictly, in equal steps if the sub-type says so.
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
        """Raises TableError: 0x4A00 id, 0x4A07 sub-type, 0x4A02 rows, 0x4A03 columns, 0x4A11."""
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
        if row_count * column_count > MOST_ELEMENTS:
            raise TableError(
                NcError.TABLE_NO_MEMORY,
                f"{row_count} × {column_count} numbers, at most {MOST_ELEMENTS} in all",
            )
        self.table_id = table_id
        self.table_name = name or f"Table {table_id}"
        self.table_main_type = main_type
        self.table_sub_type = TableSubType(sub_type)
        self.row_count = row_count
        self.column_count = column_count
        self.values = array("d", bytes(8 * row_count * column_count))
        self.last_written = 0
        """Index of the number that was written last."""

    @property
    def element_count(self) -> int:
        return len(self.values)

    @property
    def step_width(self) -> float:
        """Distance of places, 0 unless they are equidistant."""
        if self.table_sub_type != TableSubType.EQUIDISTANT_LINEAR:
            return 0.0
        return self.values[self.column_count] - self.values[0]

    def points(self) -> list[tuple[float, float]]:
        """Place and value of each row. Raises TableError if they are not a function (0x4A03 …)."""
        if self.column_count < 2:
            raise TableError(NcError.TABLE_COLUMN_COUNT, f"{self!r}: 1 column, expected 2 or more")
        columns = self.column_count
        places = self.values[::columns]
        steps = [after - before for before, after in pairwise(places)]
        if min(steps) < _SHORTEST_STEP:
            raise TableError(
                NcError.TABLE_NOT_MONOTONIC,
                f"{self!r}: its places do not rise, by {_SHORTEST_STEP:g} at least",
            )
        if self.table_sub_type == TableSubType.EQUIDISTANT_LINEAR:
            reach = _EQUAL * max(abs(places[0]), abs(places[-1]))
            if max(steps) - min(steps) > reach:
                raise TableError(NcError.TABLE_STEP_WIDTH, f"{self!r}: its steps are not equal")
        return list(zip(places, self.values[1::columns], strict=True))

    def curve(self, interpolation: int = CharacteristicInterpolation.LINEAR) -> list[Piece]:
        """The characteristic that the points are.

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
        """Value at a place and its first two derivatives, points joined by straight lines.

        Raises TableError: 0x4A19 below the table, 0x4A1A above it.
        """
        curve = self.curve()
        if place < curve[0].begin:
            raise TableError(NcError.TABLE_MASTER_BELOW, f"{place:g} below {curve[0].begin:g}")
        if place > curve[-1].begin:
            raise TableError(NcError.TABLE_MASTER_ABOVE, f"{place:g} above {curve[-1].begin:g}")
        line = curve[min(piece_at(curve, 0, len(curve), place), len(curve) - 2)]
        return line.value + (place - line.begin) * line.slope, line.slope, 0.0

    def __repr__(self) -> str:
        return f"table {self.table_id}"


class Tables:
    """All tables of an NC by id; `lay_out` gives the kernel the curves of those that drives use."""

    def __init__(self, axes: Callable[[], Iterable["Axis"]]) -> None:
        self._axes = axes
        self._tables: dict[int, Table] = {}
        self.pieces: list[Piece] = []
        """All curves, one behind the other."""
        self._valves: list[tuple[AmplifierView, list[Piece]]] = []
        """Valves whose curve is that of their drive's table at the start, inverted."""
        self.laid_out: Callable[[], None] = lambda: None
        """Told when `pieces` are others."""

    def __iter__(self) -> Iterator[Table]:
        return iter(self._tables.values())

    def __len__(self) -> int:
        return len(self._tables)

    def ids(self) -> list[int]:
        return sorted(self._tables)

    def find(self, table_id: int) -> Table:
        """The table with this id; TableError 0x4261 if there is none."""
        try:
            return self._tables[table_id]
        except KeyError:
            raise TableError(NcError.TABLE_NOT_FOUND, f"no table {table_id}") from None

    def add(self, table: Table) -> None:
        """Take a new table in; TableError 0x4063 if its id is taken."""
        if table.table_id in self._tables:
            raise TableError(NcError.TABLE_EXISTS, f"{table!r} is there already")
        self._tables[table.table_id] = table

    def add_configured(self, parameters: TableParameters) -> None:
        """Take a table in with its points. Raises TableError."""
        table = Table(
            parameters.table_id,
            TableType.CHARACTERISTIC,
            parameters.sub_type,
            len(parameters.points),
            2,
            parameters.name,
        )
        table.values = array("d", (value for point in parameters.points for value in point))
        table.curve()
        self.add(table)

    def delete(self, table_id: int) -> None:
        """Forget a table; TableError 0x4261 if there is none, 0x4259 if a drive uses it."""
        self.find(table_id)
        users = self.user_count(table_id)
        if users:
            raise TableError(NcError.SLAVE_TABLE_IN_USE, f"table {table_id} has {users} users")
        del self._tables[table_id]

    def user_count(self, table_id: int) -> int:
        """How many drives and simulated valves use a table."""
        return [used for _, used, _ in self._used()].count(table_id)

    def write(self, table: Table, index: int, values: Iterable[float], step: int = 1) -> None:
        """Change numbers of a table from `index` on, each `step` behind the one before.

        Those who use it go on with the new curve. Raises TableError, and changes nothing, if the
        table is in use and would not be a function any more.
        """
        fresh = array("d", values)
        if not all(map(isfinite, fresh)):
            raise TableError(NcError.TABLE_PARAMETER, f"{table!r} takes finite numbers")
        before = table.values[:]
        end = index + step * len(fresh)
        table.values[index:end:step] = fresh
        try:
            self.lay_out()
        except TableError:
            table.values = before
            raise
        table.last_written = index + step * (len(fresh) - 1)

    def choose(self, drive: "AxisDrive", table_id: int) -> None:
        """Let a drive use a table, 0: none. Raises TableError, and changes nothing then."""
        self._change(drive, "table_id", table_id)

    def interpolate(self, drive: "AxisDrive", interpolation: int) -> None:
        """Let a drive join the points of its table otherwise. Raises TableError like `choose`."""
        self._change(drive, "table_interpolation_type", interpolation)

    def remove(self, drive: "AxisDrive", table_id: int) -> None:
        """Take a table out of a drive, and delete it. Raises TableError, and does neither then."""
        self.find(table_id)
        if drive.table_id != table_id:
            raise TableError(NcError.TABLE_NOT_FOUND, f"{drive!r} does not use table {table_id}")
        users = self.user_count(table_id)
        if users > 1:
            raise TableError(NcError.SLAVE_TABLE_IN_USE, f"table {table_id} has {users} users")
        self.choose(drive, 0)
        self.delete(table_id)

    def _change(self, drive: "AxisDrive", field: str, value: int) -> None:
        before = getattr(drive, field)
        setattr(drive, field, value)
        try:
            self.lay_out()
        except TableError:
            setattr(drive, field, before)
            raise

    def _used(self) -> Iterator[tuple["Axis", int, int]]:
        """Table and interpolation of each drive and valve, with its axis."""
        for axis in self._axes():
            for drive in axis.drives:
                yield axis, drive.amplifier.table_id, CharacteristicInterpolation.LINEAR
                yield axis, drive.table_id, drive.table_interpolation_type

    def build_valves(self) -> None:
        """Let the valve of each drive that has a table now be the inverse of it from now on."""
        for axis in self._axes():
            for drive in axis.drives:
                if drive.table_id and not drive.amplifier.table_id:
                    table = self.find(drive.table_id)
                    curve = table.curve(drive.table_interpolation_type)
                    self._valves.append((drive.amplifier, curve))
        self.lay_out()

    def lay_out(self) -> None:
        """Give each drive the curve of its table. Raises TableError, and changes nothing then."""
        pieces: list[Piece] = []
        places = {(0, kind.value): (0, 0) for kind in CharacteristicInterpolation}
        for axis, table_id, interpolation in self._used():
            if (table_id, interpolation) in places:
                continue
            try:
                curve = self.find(table_id).curve(interpolation)
            except TableError as fault:
                raise TableError(fault.error, f"{fault}, for axis {axis.axis_id}") from None
            places[table_id, interpolation] = len(pieces), len(curve)
            pieces += curve
        self.pieces = pieces
        for amplifier, curve in self._valves:
            amplifier.valve_first, amplifier.valve_count = len(pieces), len(curve)
            amplifier.valve_inverse = 1
            pieces += curve
        for axis in self._axes():
            for drive in axis.drives:
                valve = drive.amplifier.table_id, CharacteristicInterpolation.LINEAR
                if drive.amplifier.table_id:
                    drive.amplifier.valve_first, drive.amplifier.valve_count = places[valve]
                key = drive.table_id, drive.table_interpolation_type
                drive.curve_first, drive.curve_count = places[key]
            axis.adapt = 1
            axis.resting = 0
        self.laid_out()
