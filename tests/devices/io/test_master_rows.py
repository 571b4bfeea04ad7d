"""Rows of the bus master: each group once, each readable over a bus."""

from typing import Any

import pytest

from achse.codes import ReturnCode
from achse.devices.io.groups import MasterGroup
from achse.devices.io.master_rows import MASTER_ROWS, MasterRow

MASTER = 0xFFFF
SPECIAL = {MasterGroup.FIRST_LINE, MasterGroup.DATAGRAM}


def test_each_group_of_the_master_has_one_row() -> None:
    groups = [row.group for row in MASTER_ROWS]
    assert len(groups) == len(set(groups))
    assert set(groups) == set(MasterGroup) - SPECIAL


@pytest.mark.parametrize("row", MASTER_ROWS, ids=lambda row: row.group.name)
def test_row_is_readable_and_refuses_a_write_that_it_does_not_have(io: Any, row: MasterRow) -> None:
    offset = {MasterGroup.MASTER_STATE: 0x100}.get(row.group, 0)
    if row.group in (MasterGroup.IDENTITY, MasterGroup.TROUBLE):
        offset = 1001
    if row.group is MasterGroup.CLOCK_DEVIATION:
        io.write(MASTER, row.group, 1)
    assert io.read(MASTER, row.group, offset) is not None
    if row.write is None:
        refused = io.code(lambda: io.write(MASTER, row.group, 0))
        assert refused == ReturnCode.INVALID_ACCESS.number
