"""Object rows: types, ranges and where values live."""

from typing import Any

import pytest

from achse.codes import AbortCode, DataType
from achse.drive import VirtualDrive
from achse.drive.objects import EntryAccess, ObjectRow, find


def test_names_have_an_object_and_an_entry() -> None:
    row = ObjectRow(1, 2, "Homing speeds: Speed", DataType.U8, EntryAccess.RW, "One.")
    assert (row.object_name, row.entry_name) == ("Homing speeds", "Speed")
    plain = ObjectRow(1, 0, "Controlword", DataType.U8, EntryAccess.RW, "One.")
    assert (plain.object_name, plain.entry_name) == ("Controlword", "Controlword")


def test_values_limit_more_than_the_range(aborts: Any) -> None:
    row = ObjectRow(
        1, 0, "Option", DataType.I16, EntryAccess.RW, "One.", "halt_option", values=(0, 2)
    )
    drive = VirtualDrive()
    row.put(drive, 2)
    assert row.get(drive) == drive.record.halt_option == 2
    with aborts(AbortCode.VALUE_RANGE):
        row.put(drive, 1)


def test_nothing_but_finite_numbers(aborts: Any) -> None:
    row = ObjectRow(1, 0, "Real", DataType.F32, EntryAccess.RW, "One.", "general_f0")
    with aborts(AbortCode.VALUE_RANGE):
        row.check(float("nan"))
    with aborts(AbortCode.VALUE_RANGE):
        row.check(float("inf"))


@pytest.mark.parametrize("count", [256, 300, -1, float("inf")])
def test_what_judges_itself_still_has_its_type(aborts: Any, count: float) -> None:
    """The number of entries of 1600h, whose range the procedure judges."""
    with aborts(AbortCode.VALUE_RANGE):
        find(0x1600, 0).check(count)
    find(0x1600, 0).check(255)


def test_access_word() -> None:
    row = ObjectRow(1, 0, "A", DataType.U8, EntryAccess.RO, "One.", pdo=True)
    assert (row.access_word, row.receivable) == (0x87, False)
    row = ObjectRow(1, 0, "A", DataType.U8, EntryAccess.RW, "One.", pdo=True, stored=True)
    assert (row.access_word, row.receivable) == (0x1FF, True)
