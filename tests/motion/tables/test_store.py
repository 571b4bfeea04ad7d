"""Tables of an NC by id: what they may be, how they come and go."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import AxisParameters, Nc
from achse.motion.states import TableType
from achse.motion.tables import Table, TableError, TableParameters

VALVE = [(-1.0, -1.0), (0.0, 0.0), (1.0, 1.0)]


def refuses(error: NcError, call: Callable[..., object], *arguments: Any) -> None:
    with pytest.raises(TableError) as caught:
        call(*arguments)
    assert caught.value.error is error


def fresh(sub_type: int = 3, rows: int = 3, columns: int = 2, table_id: int = 7) -> Table:
    return Table(table_id, TableType.CHARACTERISTIC, sub_type, rows, columns)


def test_what_a_table_cannot_be() -> None:
    refuses(NcError.TABLE_ID_RANGE, fresh, 3, 3, 2, 0)
    refuses(NcError.TABLE_ID_RANGE, fresh, 3, 3, 2, 4096)
    for sub_type in (0, 2, 4, 5):
        refuses(NcError.TABLE_SUB_TYPE, fresh, sub_type)
    refuses(NcError.TABLE_ROW_COUNT, fresh, 3, 1)
    refuses(NcError.TABLE_COLUMN_COUNT, fresh, 3, 2, 0)
    refuses(NcError.TABLE_NO_MEMORY, fresh, 3, 1 << 24, 1 << 24)


def test_tables_come_and_go_by_id() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)], tables=[TableParameters(3, VALVE, "valve")]).tables
    tables.add(fresh())
    assert (tables.ids(), len(tables)) == ([3, 7], 2)
    refuses(NcError.TABLE_EXISTS, tables.add, fresh())
    tables.delete(7)
    refuses(NcError.TABLE_NOT_FOUND, tables.find, 7)
    refuses(NcError.TABLE_NOT_FOUND, tables.delete, 7)
