"""Records in memory."""

import struct
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from hypothesis import given
from hypothesis import strategies as st

from achse.native.declare import Slot, lay_out, reference, within
from achse.native.memory import (
    AttributeCell,
    MemoryCell,
    Rows,
    RowView,
    field_property,
    gather,
    reader,
    structure_of,
)


class Wheel:
    angle: float = 0.0
    turns: int = 0
    marks: list[float] = [0.0] * 3


LAYOUT = lay_out("wheel", [Wheel], Slot)


class View(RowView):
    angle: Any = field_property(LAYOUT.fields["angle"])
    turns: Any = field_property(LAYOUT.fields["turns"])
    marks: Any = field_property(LAYOUT.fields["marks"])


def test_rows_begin_empty_and_apart() -> None:
    rows = Rows(LAYOUT, 3)
    rows.row(1)[:] = b"\xff" * 40
    assert bytes(rows.row(0)) == bytes(rows.row(2)) == bytes(40)
    assert rows.address % 8 == 0
    assert rows.count == 3


def test_a_view_has_the_fields_as_attributes() -> None:
    view = View(Rows(LAYOUT, 1), 0)
    view.angle = 2.5
    view.turns = -3
    view.marks[2] = 0.25
    assert (view.angle, view.turns, list(view.marks)) == (2.5, -3, [0.0, 0.0, 0.25])
    assert view.ints[1] == -3
    assert view.floats[4] == 0.25
    assert reader(LAYOUT.fields["turns"])(view) == -3


def test_a_view_knows_the_places_of_its_fields() -> None:
    rows = Rows(LAYOUT, 2)
    view = View(rows, 1)
    place = view.place(LAYOUT.fields["turns"], 4)
    view.turns = 0x0102_0304_0506
    assert place is not None
    assert place() == (0x0304_0506).to_bytes(4, "little")
    assert (place.offset, place.size) == (48, 4)
    with patch("sys.byteorder", "big"):
        assert view.place(LAYOUT.fields["turns"], 4) is None


def test_records_within_are_rows_in_the_same_memory() -> None:
    class Cart:
        load: int = 0
        wheels: Any = within(LAYOUT, length=2)

    cart = lay_out("cart", [Cart], Slot)
    rows = Rows(cart, 3)
    inner = rows.within(1, cart.fields["wheels"])
    assert (inner.count, inner.size) == (2, 40)
    assert inner.address == rows.address + rows.size + 8
    View(inner, 1).turns = 9
    assert RowView(rows, 1).ints[7] == 9
    assert bytes(rows.row(0)) == bytes(rows.row(2)) == bytes(rows.size)


def test_structure_over_a_record_has_its_fields_and_those_within() -> None:
    class Cart:
        other: Any = reference(LAYOUT)
        load: int = 0
        wheels: Any = within(LAYOUT, length=2)

    cart = lay_out("cart", [Cart], Slot)
    rows = Rows(cart, 2)
    record: Any = structure_of(cart).from_buffer(rows.row(1))
    record.load = -5
    record.wheels[1].angle, record.wheels[1].marks[2] = 0.5, 2.5
    view = RowView(rows, 1)
    assert (view.ints[1], view.floats[7], view.floats[11]) == (-5, 0.5, 2.5)
    assert record.wheels[1].turns == 0
    view.refer(cart.fields["other"], RowView(Rows(LAYOUT, 1), 0))
    assert not hasattr(record, "other")
    record.other = record.wheels[0]
    assert view.ints[0] not in (0, record.other)
    assert bytes(rows.row(0)) == bytes(rows.size)


MEMORIES = [memoryview(bytearray(range(20))), memoryview(bytearray(range(100, 110)))]

PLACES = st.builds(
    lambda n, offset, size: MemoryCell(MEMORIES[n], offset, min(size, len(MEMORIES[n]) - offset)),
    st.integers(0, 1), st.integers(0, 9), st.integers(0, 12),
)  # fmt: skip
CALLS = st.integers().map(lambda value: lambda: value)

PLAIN = [SimpleNamespace(angle=0.5, turns=-7, wheel=SimpleNamespace(turns=1 << 40))] * 2 + [
    SimpleNamespace(angle=-2.5, turns=9, wheel=SimpleNamespace(turns=-1))
]

ATTRIBUTES = st.builds(
    lambda record, name, size: AttributeCell(record, name, size, is_real=name == "angle"),
    st.sampled_from(PLAIN), st.sampled_from(["angle", "turns", "wheel.turns"]), st.integers(0, 8),
)  # fmt: skip


def test_attributes_of_plain_records_are_packed_as_words() -> None:
    record = SimpleNamespace(angle=2.5, wheel=SimpleNamespace(turns=-2))
    assert AttributeCell(record, "angle", 8, is_real=True)() == struct.pack("<d", 2.5)
    turns = AttributeCell(record, "wheel.turns", 2, is_real=False)
    assert turns() == b"\xfe\xff"
    record.wheel.turns = 0x10203
    assert turns() == b"\x03\x02"


@given(st.lists(PLACES | CALLS | ATTRIBUTES))
def test_a_gather_gives_what_each_reader_gives(readers: list[Any]) -> None:
    take = gather(readers)
    assert take() == tuple(read() for read in readers)
    PLAIN[0].turns += 1
    for memory in MEMORIES:
        memory[::3] = bytes(255 - byte for byte in memory[::3])
    assert take() == tuple(read() for read in readers)


def test_a_gather_reads_equal_places_once_and_overlapping_ones_too() -> None:
    memory = MEMORIES[0]
    whole, same, part = MemoryCell(memory, 4, 8), MemoryCell(memory, 4, 8), MemoryCell(memory, 6, 2)
    values = gather([part, whole, same])()
    assert values == (bytes(memory[6:8]), bytes(memory[4:12]), bytes(memory[4:12]))
    assert values[1] is values[2]
