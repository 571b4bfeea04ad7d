"""Tables of an NC by id: what they may be, how they come and go."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.states import TableType
from achse.motion.tables import Table, TableError, TableParameters
from achse.motion.tables.table import MOTION_POINT

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


def test_table_that_is_there_is_not_created_again() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)], tables=[TableParameters(3, VALVE, "valve")]).tables
    refuses(NcError.TABLE_EXISTS, tables.create, 3, TableType.CAMMING, 3, 1 << 24, 2)


def test_only_motion_functions_have_points() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)]).tables
    table = tables.create(7, TableType.CAMMING, 3, 2, 2)
    with pytest.raises(TableError, match="has no points"):
        tables.write_points(table, 0, bytes(MOTION_POINT.size))


def test_scaling_of_a_table_is_positive_and_its_range_ordered() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)]).tables
    table = tables.create(7, TableType.CAMMING, 3, 3, 2)
    tables.write(table, 0, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0])
    before = table.scaling
    for wrong in (
        {"master_scaling": 0.0},
        {"master_scaling": -1.0},
        {"range_low": 2.0, "range_high": 1.0},
    ):
        refuses(NcError.TABLE_SCALING, tables.scale, table, before._replace(**wrong))
        assert table.scaling == before
    for right in ({"master_scaling": 0.5}, {"range_low": 1.0, "range_high": 1.0}):
        tables.scale(table, before._replace(**right))


def test_table_at_work_stays_monotonic() -> None:
    axes = [AxisParameters(n, values={"control_dword": 7}) for n in (1, 2)]
    nc = Nc(2_000_000, axes, compiled=False)
    nc.cycle(3)
    table = nc.tables.create(7, TableType.CAMMING, 3, 3, 2)
    nc.tables.write(table, 0, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0])
    assert commands.couple_by_cam(nc.axis(2), 10, 1, CamDemand(7)) == 0
    nc.cycle()
    refuses(NcError.TABLE_NOT_MONOTONIC, nc.tables.write, table, 2, [400.0])
    assert list(table.values[:4]) == [0.0, 0.0, 90.0, 30.0]
