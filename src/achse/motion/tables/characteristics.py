"""Characteristics of drives: tables that bend their output, and valves that bend it back."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol

from achse.codes import NcError
from achse.codes.nc.choices import CharacteristicInterpolation
from achse.motion.control.curves import CurveSpan
from achse.motion.tables.errors import TableError
from achse.motion.tables.table import Table
from achse.motion.tables.users import TableUser


class _Store(Protocol):
    """The tables by id."""

    def find(self, table_id: int) -> Table: ...

    def user_count(self, table_id: int) -> int: ...

    def delete(self, table_id: int) -> None: ...


class Characteristics:
    """Assignment of drives to tables; `spans` are read by the kernel."""

    def __init__(self, axes: Callable[[], Iterable[TableUser]], tables: _Store) -> None:
        self._axes = axes
        self._tables = tables
        self.spans: list[CurveSpan] = []
        """All curves, one behind the other."""
        self._valves: list[tuple[Any, list[CurveSpan]]] = []
        """Valves whose curve is that of their drive's table at the start, inverted."""
        self.laid_out: Callable[[], None] = lambda: None
        """Called after `spans` have changed."""

    def user_count(self, table_id: int) -> int:
        """Return the number of drives and simulated valves that use a table."""
        return [used for _, used, _ in self._uses()].count(table_id)

    def choose(self, drive: Any, table_id: int) -> None:
        """Let a drive use a table, 0: none. Raises TableError, and changes nothing then."""
        self._change(drive, "table_id", table_id)

    def interpolate(self, drive: Any, interpolation: int) -> None:
        """Let a drive join the points of its table otherwise. Raises TableError like `choose`."""
        self._change(drive, "table_interpolation_type", interpolation)

    def remove(self, drive: Any, table_id: int) -> None:
        """Take a table out of a drive, and delete it. Raises TableError, and does neither then."""
        self._tables.find(table_id)
        if drive.table_id != table_id:
            raise TableError(NcError.TABLE_NOT_FOUND, f"{drive!r} does not use table {table_id}")
        users = self._tables.user_count(table_id)
        if users > 1:
            raise TableError(NcError.SLAVE_TABLE_IN_USE, f"table {table_id} has {users} users")
        self.choose(drive, 0)
        self._tables.delete(table_id)

    def _change(self, drive: Any, field: str, value: int) -> None:
        before = getattr(drive, field)
        setattr(drive, field, value)
        try:
            self.lay_out()
        except TableError:
            setattr(drive, field, before)
            raise

    def _uses(self) -> Iterator[tuple[TableUser, int, int]]:
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
                    table = self._tables.find(drive.table_id)
                    curve = table.curve(drive.table_interpolation_type)
                    self._valves.append((drive.amplifier, curve))
        self.lay_out()

    def lay_out(self) -> None:
        """Give each drive the curve of its table. Raises TableError, and changes nothing then."""
        spans: list[CurveSpan] = []
        places = {(0, kind.value): (0, 0) for kind in CharacteristicInterpolation}
        for axis, table_id, interpolation in self._uses():
            if (table_id, interpolation) in places:
                continue
            try:
                curve = self._tables.find(table_id).curve(interpolation)
            except TableError as fault:
                raise TableError(fault.error, f"{fault}, for axis {axis.axis_id}") from None
            places[table_id, interpolation] = len(spans), len(curve)
            spans += curve
        self.spans = spans
        for amplifier, curve in self._valves:
            amplifier.valve_first, amplifier.valve_count = len(spans), len(curve)
            amplifier.valve_inverse = 1
            spans += curve
        for axis in self._axes():
            for drive in axis.drives:
                valve = drive.amplifier.table_id, CharacteristicInterpolation.LINEAR
                if drive.amplifier.table_id:
                    drive.amplifier.valve_first, drive.amplifier.valve_count = places[valve]
                key = drive.table_id, drive.table_interpolation_type
                drive.curve_first, drive.curve_count = places[key]
            axis.wake(adapts=True)
            axis.resting = 0
        self.laid_out()
