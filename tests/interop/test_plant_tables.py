"""The plant's symbol and type entries, byte for byte, worked out by hand from the wire format."""

import struct
from pathlib import Path
from typing import Any

import pytest

from achse.ams import AmsAddress
from achse.server import Device
from achse.station import Station

PLANT = Path(__file__).parent / "plant" / "station.toml"

LREAL_GUID = bytes.fromhex("95190718 00000000 00000000 0000000e")
INT_GUID = bytes.fromhex("95190718 00000000 00000000 00000006")


@pytest.fixture(scope="module")
def station() -> Station:
    return Station.load(PLANT)


@pytest.fixture
def ask(station: Station) -> Any:
    """`ask(group, name)` asks the PLC device by name."""
    device = next(
        device
        for device in station.devices
        if AmsAddress.of(station.router.net_id, 851) in device.addresses
    )
    assert isinstance(device, Device)
    return lambda group, name: device.read_write(group, 0, 0xFFFF, name.encode())


def _guid(station: Station, name: str) -> bytes:
    """Types of one's own have any stable GUID; where it stands is what matters."""
    placed = {variable.name: variable for variable in station.plcs[851].variables}
    stations: Any = placed["GVL.aStations"].variable.type
    found: bytes = {
        "ARRAY": stations.guid,
        "ST_Point": stations.element.member("aPoints").type.element.guid,
        "E_Mode": stations.element.member("eMode").type.guid,
    }[name]
    return found


def test_a_symbol_entry(station: Station, ask: Any) -> None:
    group, offset, size = struct.unpack("<III", ask(0xF007, "GVL.nShift"))
    _, array_offset, array_size = struct.unpack("<III", ask(0xF007, "GVL.aStations"))
    # One station: nId 2, sName 21 from 2, wsTitle 26 from 24, eMode 50, tWait 52, dtLast 56,
    # aPoints 32 from 64 (aligned to 8), bReady 96, and up to the next multiple of 8: 104.
    assert (group, size, array_size) == (0x4040, 2, 3 * 104)
    assert offset == array_offset + 312
    assert ask(0xF009, "gvl.nshift") == b"".join(
        [
            struct.pack("<I", 64),  # 30 head + 11 name + 4 type + 1 comment + 16 GUID = 62, to 8
            struct.pack("<III", 0x4040, offset, 2),
            struct.pack("<I", 2),  # ADST INT16
            struct.pack("<HH", 0x0108, 0),  # task 1, type GUID; no dimensions
            struct.pack("<HHH", 10, 3, 0),
            b"GVL.nShift\0INT\0\0",
            INT_GUID,
            bytes(2),
        ]
    )
    type_name = b"ARRAY [0..2] OF ST_Station"
    comment = b" all stations of the plant"
    assert ask(0xF009, "GVL.aStations") == b"".join(
        [
            struct.pack("<I", 120),  # 30 + 14 + 27 + 27 + 16 = 114, to 8
            struct.pack("<III", 0x4040, array_offset, 312),
            struct.pack("<I", 65),  # BIGTYPE, of the element
            struct.pack("<HH", 0x0108, 0),  # bounds only in the text
            struct.pack("<HHH", 13, len(type_name), len(comment)),
            b"GVL.aStations\0" + type_name + b"\0" + comment + b"\0",
            _guid(station, "ARRAY"),
            bytes(6),
        ]
    )


def test_a_structure(station: Station, ask: Any) -> None:
    def member(name: bytes, index: int, offset: int) -> bytes:
        return b"".join(
            [
                struct.pack("<I", 68),  # 42 head + 3 name + 6 type + 1 comment + 16 GUID
                struct.pack("<III", 1, index, 0),  # version, index of the item, type hash
                struct.pack("<II", 8, offset),
                struct.pack("<II", 5, 0x82),  # REAL64; member with GUID
                struct.pack("<HHHHH", 2, 5, 0, 0, 0),
                name + b"\0LREAL\0\0",
                LREAL_GUID,
            ]
        )

    assert ask(0xF011, "st_point") == b"".join(
        [
            struct.pack("<I", 208),  # 42 + 9 + 1 + 1 + 2 · 68 + 16 = 205, to 8
            struct.pack("<III", 1, 0, 0),
            struct.pack("<II", 16, 0),
            struct.pack("<II", 65, 0x81),  # BIGTYPE; type with GUID
            struct.pack("<HHHHH", 8, 0, 0, 0, 2),
            b"ST_Point\0\0\0",
            member(b"fX", 0, 0),
            member(b"fY", 1, 8),
            _guid(station, "ST_Point"),
            bytes(3),
        ]
    )


def test_an_enumeration(station: Station, ask: Any) -> None:
    note = b" nothing to do"
    body = b"".join(
        [
            struct.pack("<III", 1, 0, 0),
            struct.pack("<II", 2, 0),
            # UINT16; type, GUID, attributes, values, notes on values
            struct.pack("<II", 18, 0x1 | 0x80 | 0x1000 | 0x2000 | 0x2000_0000),
            struct.pack("<HHHHH", 6, 4, 0, 0, 0),
            b"E_Mode\0UINT\0\0",
            _guid(station, "E_Mode"),
            struct.pack("<H", 2) + b"\x0e\0qualified_only\0\0" + b"\x06\0strict\0\0",
            struct.pack("<H", 3),
            b"\x04Idle\0\0\0" + b"\x04Auto\0\x0a\0" + b"\x05Fault\0\x63\0",
            struct.pack("<HBB", 5 + len(note), len(note), 0) + note + b"\0",
            2 * struct.pack("<HBBB", 5, 0, 0, 0),
        ]
    )
    length = -(-(4 + len(body)) // 8) * 8
    assert ask(0xF011, "E_Mode") == struct.pack("<I", length) + body.ljust(length - 4, b"\0")


def test_a_method_with_its_parameters(ask: Any) -> None:
    entry = ask(0xF011, "FB_Feeder")

    def parameter(name: bytes, type_name: bytes, size: int, align: int, adst: int) -> bytes:
        texts = name + b"\0" + type_name + b"\0\0"
        return struct.pack("<IIIIII", 48 + len(texts), size, align, adst, 1, 0)

    feed = struct.pack("<IIIII", 1, 0, 8, 8, 0) + LREAL_GUID + struct.pack("<II", 5, 1 | 8)
    feed += struct.pack("<HHHH", 4, 5, 0, 3) + b"Feed\0LREAL\0\0"
    assert (
        feed in entry
    )  # version, slot, return size and alignment, GUID, REAL64, PLC call with attributes
    assert parameter(b"nParts", b"INT", 2, 2, 2) + INT_GUID in entry
    assert parameter(b"fWeight", b"LREAL", 8, 8, 5) + LREAL_GUID in entry
    assert parameter(b"sWhat", b"STRING(20)", 21, 1, 30) in entry
    assert struct.pack("<HHHH", 0, 6, 3, 0) + b"nParts\0INT\0\0" in entry


def test_the_upload_is_all_entries_sorted_without_case(station: Station, ask: Any) -> None:
    names = sorted((placed.name for placed in station.plcs[851].variables), key=str.lower)
    table = b"".join(ask(0xF009, name) for name in names)
    device = next(d for d in station.devices if d.addresses and d.address.port == 851)
    assert device.read(0xF00B, 0, 0xFFFF_FFFF) == table
    count, size = struct.unpack("<II", device.read(0xF00C, 0, 8))
    assert (count, size) == (len(names), len(table))
    info = struct.unpack("<9I28x", device.read(0xF00F, 0, 64))
    assert info[:2] == (count, size)
    assert info[7:] == (1252, 3)
    assert info[3] == len(device.read(0xF00E, 0, 0xFFFF_FFFF))
