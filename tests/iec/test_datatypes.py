"""Data type entries, byte for byte."""

import contextlib
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.datatypes import (
    DataTypeEntry,
    EnumNote,
    MethodEntry,
    MethodFlag,
    ParameterEntry,
    ParameterFlag,
    TypeFlag,
    decode_types,
    encode_types,
)
from achse.iec.errors import IecDecodeError

GUID = bytes(range(16))


def head(
    length: int, size: int, offset: int, adst: int, flags: int, lengths: tuple[int, ...]
) -> bytes:
    """The 42 bytes every entry starts with; version 1, hashes 0."""
    return struct.pack("<8I5H", length, 1, 0, 0, size, offset, adst, flags, *lengths)


def test_a_structure_worked_out_by_hand() -> None:
    # ST_A: n : INT at 0, b : BIT at byte 2 bit 1 = 17 bits
    first = head(42 + 2 + 4 + 1 + 16, 2, 0, 2, 0x82, (1, 3, 0, 0, 0)) + b"n\0INT\0\0" + GUID
    second = head(42 + 2 + 4 + 3 + 16, 1, 17, 33, 0xA2, (1, 3, 2, 0, 0)) + b"b\0BIT\0 x\0" + GUID
    # 42 + 5 + 1 + 1 + 65 + 67 + 16 = 197, padded to 200; the members are not padded
    data = head(200, 4, 0, 65, 0x81, (4, 0, 0, 0, 2)) + b"ST_A\0\0\0" + first + second + GUID
    data += bytes(3)
    entry = DataTypeEntry(
        "ST_A",
        "",
        4,
        65,
        TypeFlag.TYPE | TypeFlag.TYPE_GUID,
        members=(
            DataTypeEntry("n", "INT", 2, 2, 0x82, guid=GUID),
            DataTypeEntry("b", "BIT", 1, 33, 0xA2, 17, " x", guid=GUID),
        ),
        guid=GUID,
    )
    assert entry.encode() == data
    assert DataTypeEntry.decode(data) == entry


def test_an_enumeration_worked_out_by_hand() -> None:
    # E: UINT with Idle = 0, Run = 5
    values = b"\2\0" + b"\4Idle\0\0\0" + b"\3Run\0\5\0"
    # 42 + 2 + 5 + 1 + 16 + 17 = 83, padded to 88
    data = head(88, 2, 0, 18, 0x2081, (1, 4, 0, 0, 0)) + b"E\0UINT\0\0" + GUID + values + bytes(5)
    entry = DataTypeEntry(
        "E", "UINT", 2, 18, 0x2081, guid=GUID, enum_values=(("Idle", b"\0\0"), ("Run", b"\5\0"))
    )
    assert entry.encode() == data
    assert DataTypeEntry.decode(data) == entry


def test_an_array_worked_out_by_hand() -> None:
    name = b"ARRAY [-1..1,0..4] OF INT"
    dimensions = struct.pack("<iIiI", -1, 3, 0, 5)
    # 42 + 26 + 4 + 1 + 16 + 16 = 105, padded to 112
    data = head(112, 30, 0, 2, 0x81, (25, 3, 0, 2, 0))
    data += name + b"\0INT\0\0" + dimensions + GUID + bytes(7)
    entry = DataTypeEntry(
        name.decode(), "INT", 30, 2, 0x81, dimensions=((-1, 3), (0, 5)), guid=GUID
    )
    assert entry.encode() == data
    assert DataTypeEntry.decode(data) == entry


def test_a_method_worked_out_by_hand() -> None:
    # fX : LREAL as input, by reference
    parameter = struct.pack("<6I", 48 + 3 + 6 + 1, 8, 8, 5, 5, 0) + GUID
    parameter += struct.pack("<4H", 0, 2, 5, 0) + b"fX\0LREAL\0\0"
    # Add : DINT, third in the table
    method = struct.pack("<6I", 56 + 4 + 5 + 1 + 58, 1, 2, 4, 4, 0) + GUID
    method += struct.pack("<2I4H", 3, 1, 3, 4, 0, 1) + b"Add\0DINT\0\0" + parameter
    # 42 + 3 + 1 + 1 + 16 + 2 + 124 = 189, padded to 192
    data = head(192, 8, 0, 65, 0x881, (2, 0, 0, 0, 0)) + b"FB\0\0\0" + GUID + b"\1\0" + method
    data += bytes(3)
    flags = ParameterFlag.IN | ParameterFlag.BY_REFERENCE
    entry = DataTypeEntry(
        "FB",
        "",
        8,
        65,
        0x881,
        guid=GUID,
        methods=(
            MethodEntry(
                "Add",
                "DINT",
                4,
                4,
                3,
                (ParameterEntry("fX", "LREAL", 8, 8, 5, flags, GUID),),
                MethodFlag.PLC_CALL,
                GUID,
                table_index=2,
            ),
        ),
    )
    assert entry.encode() == data
    assert DataTypeEntry.decode(data) == entry


TEXT = st.text("abcXYZ_€ ", max_size=12)
U32 = st.integers(0, 2**32 - 1)
GUIDS = st.binary(min_size=16, max_size=16)
ATTRIBUTES = st.lists(st.tuples(TEXT, TEXT), max_size=2).map(tuple)
TAILS = st.sampled_from([b"", b"\1\2", b"something new"])

PARAMETERS = st.builds(
    ParameterEntry, TEXT, TEXT, U32, U32, U32, U32.map(lambda n: n | 0x40), GUIDS, TEXT,
    ATTRIBUTES, U32, st.integers(0, 0xFFFF), TAILS,
)  # fmt: skip
METHODS = st.builds(
    MethodEntry, TEXT, TEXT, U32, U32, U32, st.lists(PARAMETERS, max_size=2).map(tuple),
    U32.map(lambda n: n | 8), GUIDS, TEXT, ATTRIBUTES, U32, U32, U32, TAILS,
)  # fmt: skip


@st.composite
def entries(draw: st.DrawFn, depth: int = 2) -> DataTypeEntry:
    size = draw(st.integers(0, 9))
    everything = 0xB000_3A80 & ~TypeFlag.REFACTOR_INFO
    values = draw(st.lists(st.tuples(TEXT, st.binary(min_size=size, max_size=size)), max_size=3))
    notes = st.builds(EnumNote, TEXT, ATTRIBUTES, TAILS)
    bounds = st.tuples(st.integers(-(2**31), 2**31 - 1), U32)
    return DataTypeEntry(
        draw(TEXT),
        draw(TEXT),
        size,
        draw(U32),
        everything | draw(st.integers(0, 0x7F)),
        draw(U32),
        draw(TEXT),
        tuple(draw(st.lists(bounds, max_size=2))),
        tuple(draw(st.lists(entries(depth - 1), max_size=2))) if depth else (),
        draw(GUIDS),
        draw(st.binary(min_size=size, max_size=size)),
        tuple(draw(st.lists(METHODS, max_size=2))),
        draw(ATTRIBUTES),
        tuple(values),
        draw(U32),
        tuple(draw(st.lists(GUIDS, max_size=2))),
        tuple(draw(notes) for _ in values),
        draw(U32),
        draw(U32),
        draw(U32),
        draw(TAILS),
    )


@given(entries())
def test_entries_come_back(entry: DataTypeEntry) -> None:
    data = entry.encode()
    assert DataTypeEntry.decode(data) == entry
    assert DataTypeEntry.decode(entry.encode("utf-8"), "utf-8") == entry
    if not entry.tail:
        assert len(data) % 8 == 0


def test_what_follows_refactor_info_stays_as_it_came() -> None:
    flags = TypeFlag.TYPE | TypeFlag.REFACTOR_INFO | TypeFlag.EXTENDED_FLAGS
    entry = DataTypeEntry("T", "", 4, 65, flags, tail=b"who knows what this is")
    data = entry.encode()
    assert DataTypeEntry.decode(data) == entry
    assert DataTypeEntry.decode(data).encode() == data


def test_tables_are_sorted_without_case() -> None:
    table = encode_types([DataTypeEntry(name, "", 0, 65, 0x1) for name in ("b", "A", "C", "_")])
    assert [entry.name for entry in decode_types(table)] == ["_", "A", "b", "C"]
    assert encode_types(decode_types(table)) == table


@given(st.binary(max_size=150))
def test_any_bytes_are_a_table_or_refused(data: bytes) -> None:
    with contextlib.suppress(IecDecodeError):
        decode_types(data)


@given(entries(depth=1), st.data())
def test_damaged_entries_are_read_or_refused(entry: DataTypeEntry, data: st.DataObject) -> None:
    damaged = bytearray(entry.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(IecDecodeError):
        decode_types(bytes(damaged))


def test_members_nested_beyond_reason_are_refused() -> None:
    entry = DataTypeEntry("x", "", 0, 65, 0x2)
    for _ in range(100):
        entry = DataTypeEntry("x", "", 0, 65, 0x2, members=(entry,))
    with pytest.raises(IecDecodeError, match="nests members deeper than 16"):
        DataTypeEntry.decode(entry.encode())


def test_announced_sizes_are_not_believed() -> None:
    # 4 GiB of copy mask, 4 GiB per enumeration value
    for flags in (TypeFlag.COPY_MASK, TypeFlag.ENUM_VALUES):
        data = head(56, 0xFFFF_FFFF, 0, 65, flags, (0, 0, 0, 0, 0))
        data += b"\0\0\0" + b"\1\0\0" + bytes(8)
        with pytest.raises(IecDecodeError, match="too early"):
            DataTypeEntry.decode(data)
