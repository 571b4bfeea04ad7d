"""How large tables of clients may be."""

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableType
from achse.motion.tables import Table, TableError
from achse.motion.tables import limits as limits_module
from achse.motion.tables.limits import TableLimits


def refused(limits: TableLimits, kind: TableType, rows: int, columns: int, *others: Table) -> bool:
    try:
        limits.demand(kind, rows, columns, others)
    except TableError as fault:
        return fault.error is NcError.TABLE_NO_MEMORY
    return False


def test_less_without_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    for installed, rows in ((True, 65_536), (False, 16_384)):
        monkeypatch.setattr(limits_module, "compiler_installed", lambda is_=installed: is_)
        for columns in (1, 2):
            assert not refused(TableLimits(), TableType.CAMMING, rows, columns)
            assert refused(TableLimits(), TableType.CAMMING, rows + 1, columns)


def test_all_together() -> None:
    limits = TableLimits(1000, 1500)
    table = Table(1, TableType.CAMMING, 1, 500, 2)
    assert not refused(limits, TableType.CAMMING, 250, 2, table)
    assert refused(limits, TableType.CAMMING, 251, 2, table)
    assert refused(limits, TableType.CHARACTERISTIC, 251, 2, table)


def test_characteristics_and_motion_functions_are_smaller() -> None:
    assert refused(TableLimits(1 << 20), TableType.CHARACTERISTIC, 4097, 2)
    assert refused(TableLimits(1 << 20), TableType.MOTION_FUNCTION, 600, 1)
    assert not refused(TableLimits(1 << 20), TableType.MOTION_FUNCTION, 585, 1)
    full = [Table(n, TableType.CHARACTERISTIC, 1, 4096, 2) for n in (1, 2)]
    assert refused(TableLimits(1 << 20), TableType.CHARACTERISTIC, 2, 2, *full)
    assert not refused(TableLimits(1 << 20), TableType.CAMMING, 2, 2, *full)


def test_each_table_has_a_bound_and_all_together() -> None:
    """Whatever the others are of: they take the numbers that they take."""
    limits = TableLimits(100, 1000)
    assert not refused(limits, TableType.CAMMING, 50, 2)
    assert refused(limits, TableType.CAMMING, 51, 2)
    for kind in TableType:
        columns = 1 if kind == TableType.MOTION_FUNCTION else 2
        table = Table(1, kind, 3, 40, columns)
        limits = TableLimits(1 << 20, table.size + 100)
        for demanded in (TableType.CAMMING, TableType.CHARACTERISTIC):
            assert not refused(limits, demanded, 50, 2, table)
            assert refused(limits, demanded, 51, 2, table)
