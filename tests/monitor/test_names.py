"""Names of services from the rows, of symbols from the traffic; values as people read them."""

import struct

import pytest

from achse.iec import INT, STRING, WSTRING
from achse.iec.symbols import SymbolEntry
from achse.monitor.names import Names, layout_text, rows_of
from achse.station import Station

DEVICE, OTHER = bytes(8), bytes(7) + b"\1"


@pytest.fixture(scope="module")
def names() -> Names:
    return Names(rows_of(Station.demo().devices))


def test_a_service_is_found_by_port_group_and_offset(names: Names) -> None:
    row = names.row(501, 0x4103, 0x0A)
    assert row is not None
    assert row.index_group <= 0x4103 <= row.last_index_group
    assert names.row(851, 0x4103, 0x0A) is None
    assert names.row(999, 0x4103, 0x0A) is None
    version = names.row(851, 0xF008, 0)
    assert version is not None
    assert version.name == "symbol version"


def test_a_device_has_symbols_of_its_own_and_may_have_two_addresses(names: Names) -> None:
    names.alias(DEVICE, OTHER)
    names.learn(DEVICE).learn_symbol(SymbolEntry.of("MAIN.nCount", INT, 0x4040, 8))
    assert names.symbols(DEVICE).at(0x4040, 8, 2) == "MAIN.nCount"
    assert names.symbols(OTHER).at(0x4040, 8, 2) == "MAIN.nCount"
    assert names.symbols(bytes(7) + b"\2").at(0x4040, 8, 2) == ""


def test_values_by_type(names: Names) -> None:
    assert names.text_of(struct.pack("<h", -5), INT, "") == "-5"
    assert names.text_of(b"\1\2\3", INT, "") == "01 02 03"
    assert names.text_of(b"\1", None, "") == "01"


def test_a_text_is_one_however_much_of_it_a_client_writes_or_reads(names: Names) -> None:
    whole = b"axis".ljust(81, b"\0")
    assert names.text_of(b"axis\0", STRING(80), "") == "'axis'"
    assert names.text_of(b"axis", STRING(80), "") == "'axis'"
    assert names.text_of(whole, STRING(80), "") == "'axis'"
    assert names.text_of(whole + b"what is behind", STRING(80), "") == "'axis' … 95 bytes"
    assert names.text_of("µm\0".encode("utf-16-le"), WSTRING(80), "") == '"µm"'


@pytest.mark.parametrize(
    ("data", "layout", "text"),
    [
        (struct.pack("<d", 1.5), "REAL64", "1.5"),
        (struct.pack("<I", 7), "UINT32 or REAL64", "7"),
        (struct.pack("<d", 7), "UINT32 or REAL64", "7"),
        (struct.pack("<I4xd", 1, 2.5), "{type:UINT32; 4 unused; position:REAL64}", None),
        (b"Feed".ljust(31, b"\0"), "BYTE[n]", "'Feed'"),
        (b"\1\2", "BYTE[n]", "01 02"),
        (bytes(40), "", f"{bytes(32).hex(' ')} … 40 bytes"),
    ],
)
def test_values_by_layout(data: bytes, layout: str, text: str | None) -> None:
    assert layout_text(data, layout) == (text or "(type 1, position 2.5)")
