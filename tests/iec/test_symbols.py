"""Symbol entries and upload info, byte for byte."""

import contextlib
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.declare import ARRAY, reference_to
from achse.iec.elementary import BIT, BOOL, BYTE, INT
from achse.iec.errors import IecDecodeError, IecValueError
from achse.iec.strings import STRING
from achse.iec.symbols import (
    SymbolEncoder,
    SymbolEntry,
    SymbolFlag,
    UploadFlag,
    UploadInfo,
    decode_symbols,
    encode_symbols,
    fold,
)
from achse.iec.types import IecType

# Recorded from a target and worked out field by field: 30 bytes of head, the three texts with
# their NUL (28 + 5 + 1), 16 bytes of GUID: 80, a multiple of 8.
WORKED = (
    bytes.fromhex(
        "50000000"  # entry length 0x50
        "40400000"  # index group 0x4040
        "c7f60500"  # index offset 0x5F6C7
        "01000000"  # size
        "21000000"  # ADST 33: BOOL
        "0801"  # flags: type GUID, context 1
        "0000"  # array dimensions
        "1b00"  # 27 characters of name
        "0400"  # 4 of type
        "0000"  # 0 of comment
    )
    + b"Constants.bMulticoreSupport\0"
    + b"BOOL\0"
    + b"\0"
    + bytes.fromhex("95190718000000000000000000000030")
)


def test_the_worked_entry() -> None:
    entry = SymbolEntry.of("Constants.bMulticoreSupport", BOOL, 0x4040, 0x5F6C7)
    assert entry.encode() == WORKED
    assert SymbolEntry.decode(WORKED) == entry
    assert entry.context == 1


def test_an_entry_with_all_parts() -> None:
    entry = SymbolEntry(
        "GVL.ä",
        "INT",
        0xF020,
        8,
        4,
        2,
        SymbolFlag.TYPE_GUID | SymbolFlag.ATTRIBUTES | SymbolFlag.FLAGS2,
        " c",
        dimensions=((-1, 2),),
        guid=INT.guid,
        attributes=(("TcAddressType", "Input"),),
        flags2=8,
    )
    body = (
        struct.pack("<5I5H", 0x70, 0xF020, 8, 4, 2, 0x9008, 1, 5, 3, 2)
        + b"GVL.\xe4\0INT\0 c\0"
        + struct.pack("<iI", -1, 2)
        + INT.guid
        + b"\1\0\x0d\5TcAddressType\0Input\0"
        + b"\x08\0\0\0"
    )
    # 30 + 13 + 8 + 16 + 24 + 4 = 95, one zero to 96
    data = b"\x60" + body[1:] + b"\0"
    assert len(data) == 96
    assert entry.encode() == data
    assert SymbolEntry.decode(data) == entry


def test_what_a_type_says_of_its_symbols() -> None:
    array = SymbolEntry.of("a", ARRAY(BYTE, (0, 1023)), 0x4040, 0)
    # as recorded: no dimensions, but the type's text and the element's ADST
    assert (array.dimensions, array.type_name, array.adst) == ((), "ARRAY [0..1023] OF BYTE", 17)
    assert array.size == 1024
    assert SymbolEntry.of("b", BIT, 0, 0, context=0).flags == 0x000A
    assert SymbolEntry.of("r", reference_to(INT), 0, 0).flags == 0x010C
    message = SymbolEntry.of("s", STRING(8), 0, 0, attributes={"TcEncoding": "UTF-8"}, flags=1)
    assert message.flags == 0x1109


SYMBOLS = st.builds(
    SymbolEntry,
    name=st.text("abcABC._€", max_size=20),
    type_name=st.text("INTabc []", max_size=20),
    index_group=st.integers(0, 2**32 - 1),
    index_offset=st.integers(0, 2**32 - 1),
    size=st.integers(0, 2**32 - 1),
    adst=st.integers(0, 2**32 - 1),
    flags=st.integers(0, 0xFFFF).map(lambda n: n | 0x9008),
    comment=st.text("abc ", max_size=20),
    dimensions=st.lists(
        st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1)), max_size=3
    ).map(tuple),
    guid=st.binary(min_size=16, max_size=16),
    attributes=st.lists(st.tuples(st.text("ab"), st.text("cd")), max_size=3).map(tuple),
    flags2=st.integers(0, 2**32 - 1),
    tail=st.sampled_from([b"", b"\1", b"new parts"]),
)


@given(SYMBOLS)
def test_entries_come_back(entry: SymbolEntry) -> None:
    assert SymbolEntry.decode(entry.encode()) == entry
    assert SymbolEntry.decode(entry.encode("utf-8"), "utf-8") == entry


@given(st.lists(SYMBOLS, max_size=6))
def test_tables_come_back_sorted_without_case(entries: list[SymbolEntry]) -> None:
    data = encode_symbols(entries)
    result = decode_symbols(data)
    assert sorted(map(repr, result)) == sorted(map(repr, entries))
    assert [fold(entry.name) for entry in result] == sorted(fold(entry.name) for entry in entries)
    assert encode_symbols(result) == data


@given(st.binary(max_size=120))
def test_any_bytes_are_a_table_or_refused(data: bytes) -> None:
    with contextlib.suppress(IecDecodeError):
        decode_symbols(data)


@given(st.data())
def test_damaged_tables_are_read_or_refused(data: st.DataObject) -> None:
    damaged = bytearray(WORKED * 2)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    try:
        result = decode_symbols(bytes(damaged))
    except IecDecodeError:
        return
    assert all(isinstance(entry, SymbolEntry) for entry in result)


def test_every_truncation_is_refused() -> None:
    for length in range(1, len(WORKED)):
        with pytest.raises(IecDecodeError):
            SymbolEntry.decode(WORKED[:length])


def test_a_name_that_is_too_long_is_refused() -> None:
    with pytest.raises(IecValueError, match="a symbol name takes a text of at most 65535"):
        SymbolEntry.of("x" * 70_000, INT, 0, 0).encode()


def test_upload_info_as_recorded() -> None:
    info = UploadInfo(28, 3064, 65, 13304)
    data = struct.pack("<9I", 28, 3064, 65, 13304, 2000, 0, 0, 1252, 3) + bytes(28)
    assert info.encode() == data
    assert len(data) == 64
    assert UploadInfo.decode(data) == info
    assert info.coding == "cp1252"
    assert UploadInfo(0, 0, flags=UploadFlag.UTF8).coding == "utf-8"


def test_older_targets_give_less_upload_info() -> None:
    data = UploadInfo(28, 3064, 65, 13304).encode()
    assert UploadInfo.decode(data[:8]) == UploadInfo(28, 3064, 0, 0, 0, 0, 0, 0, 0)
    assert UploadInfo.decode(data[:24]).type_bytes == 13304
    with pytest.raises(IecDecodeError, match="at least 8 bytes, got 7"):
        UploadInfo.decode(data[:7])


@given(
    st.text("abcXYZ._0µ", min_size=1, max_size=40),
    st.sampled_from([INT, BIT, STRING(5), ARRAY(INT, (0, 2)), reference_to(INT)]),
    st.integers(0, 0xFFFF_FFFF),
    st.text("ab é", max_size=20),
    st.dictionaries(st.text("abc", min_size=1), st.text("xyz"), max_size=3),
)
def test_the_quick_encoder_gives_the_same_bytes(
    name: str, type: IecType[Any], offset: int, comment: str, attributes: dict[str, str]
) -> None:
    flags = SymbolFlag.READ_ONLY
    entry = SymbolEntry.of(
        name, type, 0x4040, offset, flags=flags, context=3, comment=comment, attributes=attributes
    )
    quick = SymbolEncoder()
    for _ in range(2):
        assert quick(name, type, 0x4040, offset, flags | 0x300, comment, attributes) == (
            entry.encode()
        )
