"""Names of services from the rows, of symbols from the traffic; values as people read them."""

import struct

import pytest

from achse.iec import INT, LREAL, Struct, var
from achse.iec.declare import iec_type
from achse.iec.symbols import SymbolEntry
from achse.monitor.names import Names, layout_text, rows_of
from achse.station import Station

DEVICE = bytes(8)


class ST_Pair(Struct):  # noqa: N801
    fX = var(LREAL)  # noqa: N815
    nY = var(INT)  # noqa: N815


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


def test_symbols_are_learned_from_entries(names: Names) -> None:
    entry = SymbolEntry.of("MAIN.nCount", INT, 0x4040, 8)
    names.learn_entries(DEVICE, entry.encode())
    names.learn_entries(DEVICE, b"\xff" * 20)  # no entry
    names.learn_handle(DEVICE, 7, "MAIN.nCount")
    assert names.at(DEVICE, 0x4040, 8) == "MAIN.nCount"
    assert names.at(DEVICE, 0x4040, 9) == ""
    assert names.type_of(DEVICE, "main.ncount") == "INT"
    assert (names.held(DEVICE, 7), names.held(DEVICE, 8)) == ("MAIN.nCount", "")


def test_values_by_type(names: Names) -> None:
    names.learn_type("ST_Pair", iec_type(ST_Pair))
    assert names.text_of(struct.pack("<h", -5), "INT", "") == "-5"
    assert names.text_of(struct.pack("<dh6x", 1.5, 2), "ST_Pair", "") == "(fX := 1.5, nY := 2)"
    assert names.text_of(b"\1\2\3", "INT", "") == "01 02 03"
    assert names.text_of(b"\1", "Nowhere", "") == "01"


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
