"""The demo station is what the first command of README promises."""

import struct
from typing import Any

import pytest

from achse.station import Station
from achse.station.demo import GVL, MAIN

ELEMENTARY = {
    "BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "USINT", "INT", "UINT", "DINT", "UDINT",
    "LINT", "ULINT", "REAL", "LREAL", "STRING(80)", "WSTRING(80)", "TIME", "LTIME", "DATE",
    "LDATE", "TOD", "LTOD", "DT", "LDT",
}  # fmt: skip


@pytest.fixture
def station() -> Station:
    return Station.demo()


def test_there_is_a_variable_of_every_elementary_type(station: Station) -> None:
    types = {placed.variable.type.name for placed in station.plcs[851].variables}
    assert types >= ELEMENTARY
    assert any(name.startswith("ARRAY") for name in types)
    assert types >= {"ST_Point", "E_Colour"}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("GVL.bBool", b"\1"),
        ("GVL.nDword", b"\xef\xbe\xad\xde"),
        ("GVL.nSint", b"\xf8"),
        ("GVL.fLreal", struct.pack("<d", 2.5)),
        ("GVL.sString", b"axis\0"),
        ("GVL.tTime", struct.pack("<I", 1500)),
        ("GVL.tLtime", struct.pack("<Q", 1_500_000_001)),
        ("GVL.dDate", struct.pack("<I", 1_767_225_600)),
        ("GVL.tLtod", struct.pack("<Q", (12 * 3600 + 30 * 60) * 10**9 + 1)),
        ("GVL.aInt", struct.pack("<10h", *range(10))),
        ("GVL.aLreal[2,1]", struct.pack("<d", 2.1)),
        ("GVL.stPoint.fY", struct.pack("<d", 2.0)),
        ("GVL.eColour", b"\1\0"),
    ],
)
def test_variables_have_their_initial_values(
    station: Station, client_of: Any, name: str, value: bytes
) -> None:
    plc = client_of(station.router, 851)
    handle = int.from_bytes(plc.exchange(0xF003, 0, 4, name.encode() + b"\0"), "little")
    assert plc.read(0xF005, handle, len(value)) == value


def test_the_counter_counts_task_cycles(station: Station) -> None:
    main = station.plcs[851].unit(MAIN)
    before = main.nCounter
    station.advance(1.0)
    assert main.nCounter == before + 100
    main.nCounter = 0xFFFF_FFFF
    station.advance(0.01)
    assert main.nCounter == 0


def test_the_variable_list_is_a_unit_of_the_plc(station: Station) -> None:
    assert station.plcs[851].unit(GVL).stPoint.sName == "home"


def test_the_axes(station: Station, client_of: Any) -> None:
    nc = client_of(station.router, 500)
    assert nc.get(0x1000, 0x10, "<I") == 20_000
    assert nc.read(0x1100, 0x33, 100) == struct.pack("<III", 1, 2, 3)
    for axis, name, unit in ((1, b"X", b"mm"), (2, b"Y", b"mm"), (3, b"C", b"degree")):
        assert nc.read(0x4000 + axis, 0x02, 31).rstrip(b"\0") == name
        assert nc.read(0x4000 + axis, 0x05, 11).rstrip(b"\0") == unit
        assert nc.get(0x5000 + axis, 0x0B, "<H") == nc.get(0x5000 + axis, 0x0C, "<H") == 0
    for axis in (1, 2):
        values = [nc.get(0x4000 + axis, offset, "<d") for offset in (0x27, 0x101, 0x102, 0x103)]
        assert values == [2000.0, 1500.0, 1500.0, 2250.0]
    assert nc.get(0x5003, 0x09, "<d") == 360.0
    assert str(station.router.net_id) == "127.0.0.1.1.1"
