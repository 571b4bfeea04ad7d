"""Tables as their services find them: by id, whole rows and columns, refusals as codes."""

import sys
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from achse.ams import DeviceError
from achse.codes import NcError, ReturnCode
from achse.motion.tables import Table, TableError, Tables


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


class Numbers:
    """REAL64, one or more."""

    name = "REAL64[n]"
    size = None

    def encode(self, values: "array[float]") -> bytes:
        return _little_endian(values).tobytes()

    def decode(self, data: bytes) -> "array[float]":
        if not data or len(data) % 8:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"numbers of 8 bytes, got {len(data)} bytes")
        return _little_endian(array("d", data))


def _little_endian(values: "array[float]") -> "array[float]":
    if sys.byteorder == "big":
        values = values[:]
        values.byteswap()
    return values


def _check(index: int, count: int, error: NcError, what: str) -> None:
    if index >= count:
        raise DeviceError(error.number, f"{what} {index}, there are {count} from 0 on")


def check_row(table: Table, row: int) -> None:
    _check(row, table.row_count, NcError.TABLE_ROW_INDEX, "row")


def check_column(table: Table, column: int) -> None:
    _check(column, table.column_count, NcError.TABLE_COLUMN_INDEX, "column")


def check_whole(error: NcError, count: int, size: int, most: int, what: str) -> None:
    """Refuse what is not at least one whole row or column, or goes beyond the last."""
    whole, rest = divmod(count, size)
    if rest or not 1 <= whole <= most:
        raise DeviceError(
            error.number, f"{count} numbers, expected 1..{most} whole {what} of {size} each"
        )
