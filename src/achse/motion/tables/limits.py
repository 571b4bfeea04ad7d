"""Largest sizes of tables from clients: no request about one keeps others waiting.

A table is looked at and joined whole where a slave begins to follow it, between two cycles.
Machine code does 65,000 rows in some ms, plain Python 10,000 in some tens. Tables of the
configuration are their author's affair.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from achse.codes import NcError
from achse.codes.nc.choices import TableType
from achse.motion.tables.errors import TableError
from achse.motion.tables.table import MOTION_POINT, Table
from achse.native.backend import compiler_installed

_NUMBERS = 1 << 17
_NUMBERS_PLAIN = 1 << 15

_OTHERS = {TableType.CHARACTERISTIC: 1 << 13, TableType.MOTION_FUNCTION: 1 << 13}
"""Numbers of tables that Python works through row by row, at each change of one in use."""

_ALL_CHARACTERISTICS = 1 << 14
"""All curves of drives are made again when one changes."""

_COLUMNS = 2
"""A table of one column takes as long as one of two."""

_POINT = MOTION_POINT.size // 8


@dataclass(frozen=True, slots=True)
class TableLimits:
    """Most numbers of a cam table, 0: 131,072 with machine code, else 32,768; and of all tables."""

    numbers: int = 0
    all_numbers: int = 1 << 21

    def demand(self, kind: TableType, rows: int, columns: int, others: Iterable[Table]) -> None:
        """Raise TableError 0x4A11 unless there is room for one more table beside the others."""
        each = _POINT if kind == TableType.MOTION_FUNCTION else 1
        most = self.numbers or (_NUMBERS if compiler_installed() else _NUMBERS_PLAIN)
        most = min(most, _OTHERS.get(kind, most))
        size = rows * max(columns, _COLUMNS) * each
        if size > most:
            raise TableError(
                NcError.TABLE_NO_MEMORY,
                f"{rows} × {columns} take {size} numbers, a table at most {most}",
            )
        used = {TableType.CHARACTERISTIC: 0, kind: 0}
        for table in others:
            main = table.table_main_type
            used[main] = used.get(main, 0) + table.size
        free = self.all_numbers - sum(used.values())
        if kind == TableType.CHARACTERISTIC:
            free = min(free, _ALL_CHARACTERISTICS - used[kind])
        if size > free:
            raise TableError(
                NcError.TABLE_NO_MEMORY, f"{rows} × {columns}, there is memory for {free} numbers"
            )
