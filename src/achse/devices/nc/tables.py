"""Table services, 0xA000, 0xA100 and 0xA200 + ID, of characteristics. Source: 002 §6.4.8.

Ids above 255 are at the group 0x000nA000 + low byte, n being id // 256.
"""

import sys
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.devices.nc.layouts import INT32, NO_DATA, REAL64, UINT32, Text, request
from achse.motion import Nc
from achse.motion.states import TableSubType, TableType
from achse.motion.tables import HIGHEST_TABLE_ID, Table, TableError, Tables
from achse.server import READ, READ_WRITE, WRITE, IndexGroup, Layout, ObjectGroup, Service

__all__ = [
    "TABLE_FUNCTIONS",
    "TABLE_PARAMETERS",
    "TABLE_STATES",
    "TablePlace",
    "answered",
    "table_groups",
]


@contextmanager
def answered() -> Iterator[None]:
    """Answer what a table cannot be by the NC's error."""
    try:
        yield
    except TableError as fault:
        raise DeviceError(fault.error.number, str(fault)) from None


class TablePlace(NamedTuple):
    """A table that is there, or a place for one."""

    tables: Tables
    table_id: int

    @property
    def table(self) -> Table:
        """The table; DeviceError 0x4016 if there is none."""
        try:
            return self.tables.find(self.table_id)
        except TableError as fault:
            raise DeviceError(NcError.TABLE_ID.number, str(fault)) from None

    @property
    def user_count(self) -> int:
        return self.tables.user_count(self.table.table_id)


class _Numbers:
    """Any number of REAL64."""

    name = "REAL64[n]"
    size = None

    def encode(self, values: "array[float]") -> bytes:
        return _little_endian(values).tobytes()

    def decode(self, data: bytes) -> "array[float]":
        if len(data) % 8:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"numbers of 8 bytes, got {len(data)} bytes")
        return _little_endian(array("d", data))


def _little_endian(values: "array[float]") -> "array[float]":
    if sys.byteorder == "big":
        values = values[:]
        values.byteswap()
    return values


def _step_width(place: TablePlace) -> float:
    table = place.table
    if table.table_sub_type != TableSubType.EQUIDISTANT_LINEAR:
        raise DeviceError(
            NcError.TABLE_FUNCTION_NOT_AVAILABLE.number, f"{table!r} has no equal steps"
        )
    return table.step_width


def _check(index: int, count: int, error: NcError, what: str) -> None:
    if index >= count:
        raise DeviceError(error.number, f"{what} {index}, there are {count} from 0 on")


def _check_row(table: Table, row: int) -> None:
    _check(row, table.row_count, NcError.TABLE_ROW_INDEX, "row")


def _check_column(table: Table, column: int) -> None:
    _check(column, table.column_count, NcError.TABLE_COLUMN_INDEX, "column")


def _check_whole(error: NcError, count: int, size: int, most: int, what: str) -> None:
    """Refuse what is not at least one whole row or column, or goes beyond the last."""
    whole, rest = divmod(count, size)
    if rest or not 1 <= whole <= most:
        raise DeviceError(
            error.number, f"{count} numbers, expected 1..{most} whole {what} of {size} each"
        )


def _read_value(place: TablePlace) -> tuple[int, int, float]:
    """The number that was written last, as it is now: a read names none."""
    table = place.table
    row, column = divmod(table.last_written, table.column_count)
    return row, column, table.values[table.last_written]


def _write_value(place: TablePlace, access: tuple[int, int, float]) -> None:
    row, column, value = access
    table = place.table
    _check_row(table, row)
    _check_column(table, column)
    with answered():
        place.tables.write(table, row * table.column_count + column, [value])


def _read_rows(place: TablePlace, row: int) -> "array[float]":
    table = place.table
    _check_row(table, row)
    return table.values[row * table.column_count :]


def _write_rows(place: TablePlace, row: int, numbers: "array[float]") -> None:
    table = place.table
    _check_row(table, row)
    columns, most = table.column_count, table.row_count - row
    _check_whole(NcError.TABLE_ACCESS_ROWS, len(numbers), columns, most, "rows")
    with answered():
        place.tables.write(table, row * columns, numbers)


def _read_columns(place: TablePlace, column: int) -> "array[float]":
    table = place.table
    _check_column(table, column)
    numbers = array("d")
    for number in range(column, table.column_count):
        numbers += table.values[number :: table.column_count]
    return numbers


def _write_columns(place: TablePlace, column: int, numbers: "array[float]") -> None:
    table = place.table
    _check_column(table, column)
    rows, columns = table.row_count, table.column_count
    _check_whole(NcError.TABLE_ACCESS_COLUMNS, len(numbers), rows, columns - column, "columns")
    with answered():
        place.tables.write(table, column, numbers, columns)


def _value(place: TablePlace, position: float) -> float:
    with answered():
        return place.table.read(position)[0]


def _values(place: TablePlace, position: float) -> tuple[float, float, float]:
    with answered():
        return place.table.read(position)


def _creates(main_type: TableType) -> Callable[[TablePlace, tuple[int, int, int]], None]:
    def create(place: TablePlace, dimensions: tuple[int, int, int]) -> None:
        with answered():
            place.tables.add(Table(place.table_id, main_type, *dimensions))

    return create


def _delete(place: TablePlace, _: None) -> None:
    with answered():
        place.tables.delete(place.table.table_id)


def _initialise(place: TablePlace, _: None) -> None:
    with answered():
        place.table.curve()


_ANY_START = 0x0100_0000
"""Offsets of rows and columns: the first is added."""

TABLE_PARAMETERS = (
    Service(0x01, "table_id", READ, UINT32, "id of the table", "1", field="table.table_id"),
    Service(0x02, "table_name", READ, Text(31), "name", field="table.table_name"),
    Service(
        0x03, "table_sub_type", READ, UINT32, "distances of the places", "1",
        field="table.table_sub_type", choices=TableSubType,
    ),
    Service(
        0x04, "table_main_type", READ, UINT32, "what the table is for", "1",
        field="table.table_main_type", choices=TableType,
    ),
    Service(0x10, "row_count", READ, UINT32, "rows", "1", field="table.row_count"),
    Service(0x11, "column_count", READ, UINT32, "columns", "1", field="table.column_count"),
    Service(0x12, "element_count", READ, UINT32, "numbers", "1", field="table.element_count"),
    Service(
        0x13, "step_width", READ, REAL64, "distance of places in an equidistant table",
        read=_step_width,
    ),
    Service(
        0x20, "single_value", READ | WRITE, request(row="I", column="I", value="d"),
        "one number, row and column counted from 0; a read gives that written last",
        read=_read_value, write=_write_value,
        code=NcError.TABLE_PARAMETER.number,
    ),
    Service(
        0x21, "slave_position_at_master", READ_WRITE, REAL64,
        "value at a place, points joined by straight lines", exchange=_value, response=REAL64,
    ),
    Service(
        0x23, "slave_values_at_master", READ_WRITE, REAL64,
        "value at a place, and its first two derivatives", exchange=_values,
        response=Layout("<ddd"),
    ),
    Service(
        _ANY_START, "rows", READ | WRITE, _Numbers(), "whole rows from one on, counted from 0",
        read=_read_rows, write=_write_rows, count=_ANY_START,
    ),
    Service(
        2 * _ANY_START, "columns", READ | WRITE, _Numbers(),
        "whole columns from one on, counted from 0",
        read=_read_columns, write=_write_columns, count=_ANY_START,
    ),
)  # fmt: skip

TABLE_STATES = (
    Service(0x0A, "user_count", READ, INT32, "drives that use the table", "1", field="user_count"),
)

TABLE_FUNCTIONS = (
    Service(
        0x1_0001, "create_characteristic_table", WRITE,
        request(table_type="I", row_count="I", column_count="I"),
        "make a table of a characteristic, types 1 and 3: velocity, output, each of the full one",
        write=_creates(TableType.CHARACTERISTIC),
    ),
    Service(0x2_0000, "delete_table", WRITE, NO_DATA, "forget the table", write=_delete),
    Service(
        0x3_0000, "initialize_table", WRITE, NO_DATA,
        "see whether the points are a function, which is done where they are used too",
        write=_initialise,
    ),
)  # fmt: skip


def table_groups(nc: Nc) -> Iterator[IndexGroup]:
    """The groups of an NC's tables; an id without table is answered 0x4016."""

    def place(table_id: int) -> TablePlace:
        return TablePlace(nc.tables, table_id)

    for base, rows in (
        (0xA000, TABLE_PARAMETERS),
        (0xA100, TABLE_STATES),
        (0xA200, TABLE_FUNCTIONS),
    ):
        yield ObjectGroup(base, HIGHEST_TABLE_ID, place, rows, kind=TablePlace)
