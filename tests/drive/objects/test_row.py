"""Object rows: types, ranges and where values live."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode
from achse.drive import VirtualDrive
from achse.drive.objects import Access, DataType, ObjectRow, find


@pytest.mark.parametrize(
    ("kind", "least", "most", "number"),
    [
        (DataType.I8, -128, 127, 2),
        (DataType.I16, -32768, 32767, 3),
        (DataType.I32, -(2**31), 2**31 - 1, 4),
        (DataType.U8, 0, 255, 5),
        (DataType.U16, 0, 65535, 6),
        (DataType.U32, 0, 2**32 - 1, 7),
    ],
)
def test_types(kind: DataType, least: int, most: int, number: int) -> None:
    assert (kind.least, kind.most, kind.number) == (least, most, number)
    assert kind.unpack(kind.pack(least)) == least
    assert kind.unpack(kind.pack(most)) == most


@given(st.sampled_from(list(DataType)), st.data())
def test_values_travel_unchanged(kind: DataType, data: st.DataObject) -> None:
    if kind is DataType.F32:
        value: float = data.draw(st.floats(width=32, allow_nan=False, allow_infinity=False))
    else:
        value = data.draw(st.integers(int(kind.least), int(kind.most)))
    assert kind.unpack(kind.pack(value)) == value
    assert len(kind.pack(value)) * 8 == kind.bits


def test_names_have_an_object_and_an_entry() -> None:
    row = ObjectRow(1, 2, "Homing speeds: Speed", DataType.U8, Access.RW, "One.")
    assert (row.object_name, row.entry_name) == ("Homing speeds", "Speed")
    plain = ObjectRow(1, 0, "Controlword", DataType.U8, Access.RW, "One.")
    assert (plain.object_name, plain.entry_name) == ("Controlword", "Controlword")


def test_values_limit_more_than_the_range(aborts: Any) -> None:
    row = ObjectRow(1, 0, "Option", DataType.I16, Access.RW, "One.", "halt_option", values=(0, 2))
    drive = VirtualDrive()
    row.put(drive, 2)
    assert row.get(drive) == drive.record.halt_option == 2
    with aborts(AbortCode.VALUE_RANGE):
        row.put(drive, 1)


def test_nothing_but_finite_numbers(aborts: Any) -> None:
    row = ObjectRow(1, 0, "Real", DataType.F32, Access.RW, "One.", "general_f0")
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
    row = ObjectRow(1, 0, "A", DataType.U8, Access.RO, "One.", pdo=True)
    assert (row.access_word, row.receivable) == (0x87, False)
    row = ObjectRow(1, 0, "A", DataType.U8, Access.RW, "One.", pdo=True, stored=True)
    assert (row.access_word, row.receivable) == (0x1FF, True)
