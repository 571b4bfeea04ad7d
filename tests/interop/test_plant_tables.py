"""The plant's symbol and type entries, byte for byte, worked out by hand from the wire format."""

import struct
from pathlib import Path
from typing import Any

import pytest

from achse.ams import AmsAddress, DeviceError
from achse.server import Device
from achse.station import Station

PLANT = Path(__file__).parent / "plant" / "station.toml"

LREAL_GUID = bytes.fromhex("95190718 00000000 00000000 0000000e")
INT_GUID = bytes.fromhex("95190718 00000000 00000000 00000006")


@pytest.fixture(scope="module")
def station() -> Station:
    return Station.load(PLANT)


@pytest.fixture
def device(station: Station) -> Device:
    """The PLC."""
    address = AmsAddress.of(station.router.net_id, 851)
    return next(device for device in station.devices if address in device.addresses)


@pytest.fixture
def ask(device: Device) -> Any:
    """`ask(group, name)` asks the PLC device by name."""
    return lambda group, name: device.read_write(group, 0, 0xFFFF, name.encode())


def _guid(station: Station, name: str) -> bytes:
    """Types of one's own have any stable GUID; where it stands is what matters."""
    placed = {variable.name: variable for variable in station.plcs[851].variables}
    stations: Any = placed["GVL.aStations"].variable.type
    offsets: bytes = {
        "ARRAY": stations.guid,
        "ST_Point": stations.element.member("aPoints").type.element.guid,
        "E_Mode": stations.element.member("eMode").type.guid,
        "FB_Feeder": placed["MAIN.fbFeeder"].variable.type.guid,
    }[name]
    return offsets


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
            struct.pack("<HH", 0x0008, 0),  # no task, type GUID; no dimensions
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
            struct.pack("<HH", 0x0008, 0),  # bounds only in the text
            struct.pack("<HHH", 13, len(type_name), len(comment)),
            b"GVL.aStations\0" + type_name + b"\0" + comment + b"\0",
            _guid(station, "ARRAY"),
            bytes(6),
        ]
    )


def test_a_structure(station: Station, ask: Any) -> None:
    def member(name: bytes, offset: int) -> bytes:
        return b"".join(
            [
                struct.pack("<I", 68),  # 42 head + 3 name + 6 type + 1 comment + 16 GUID
                struct.pack("<III", 1, 0, 0),  # version, hash of a sub item, type hash
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
            member(b"fX", 0),
            member(b"fY", 8),
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


def test_a_function_block_with_its_methods(station: Station, ask: Any) -> None:
    """Every byte of the entry: FB_Feeder has nFed behind its table pointer, Feed and Last."""

    def parameter(
        name: bytes, type_name: bytes, size: int, align: int, adst: int, flags: int, guid: bytes
    ) -> bytes:
        return b"".join(
            [
                # 6 words of 4, GUID 16, 4 words of 2: 48; then the texts, each with its NUL
                struct.pack("<I", 48 + len(name) + 1 + len(type_name) + 1 + 1),
                struct.pack("<IIIII", size, align, adst, flags, 0),
                guid,
                struct.pack("<HHHH", 0, len(name), len(type_name), 0),
                name + b"\0" + type_name + b"\0\0",
            ]
        )

    def method(
        name: bytes,
        type_name: bytes,
        slot: int,
        returns: tuple[int, int, int, bytes],
        parameters: list[bytes],
    ) -> bytes:
        size, align, adst, guid = returns
        # one attribute: count 2, lengths 1 + 1, "TcRpcEnable" and its NUL 12, NUL of its value 1
        attributes = struct.pack("<HBB", 1, 11, 0) + b"TcRpcEnable\0\0"
        texts = name + b"\0" + type_name + b"\0\0"
        inside = b"".join(parameters)
        return b"".join(
            [
                # 6 words of 4, GUID 16, 2 words of 4, 4 words of 2: 56
                struct.pack("<I", 56 + len(texts) + len(inside) + 17),
                struct.pack("<IIIII", 1, slot, size, align, 0),  # version 1, reserved 0
                guid,
                struct.pack("<II", adst, 0x1 | 0x8),  # PLC call, attributes
                struct.pack("<HHHH", len(name), len(type_name), 0, len(parameters)),
                texts + inside + attributes,
            ]
        )

    text_guid = bytes.fromhex("95190718 00000000 00000001 00000014")  # STRING(20)
    bool_guid = bytes.fromhex("95190718 00000000 00000000 00000030")
    point = (16, 8, 65, 2, _guid(station, "ST_Point"))
    feed = method(
        b"Feed",
        b"LREAL",
        0,
        (8, 8, 5, LREAL_GUID),
        [
            parameter(b"nParts", b"INT", 2, 2, 2, 1, INT_GUID),
            parameter(b"fWeight", b"LREAL", 8, 8, 5, 1, LREAL_GUID),
            parameter(b"sWhat", b"STRING(20)", 21, 1, 30, 1, text_guid),
        ],
    )
    # 56 + 12, parameters 60, 63 and 66, attributes 17
    assert len(feed) == 274
    last = method(
        b"Last",
        b"BOOL",
        1,
        (1, 1, 33, bool_guid),
        [
            parameter(b"stLast", b"ST_Point", *point),
            parameter(b"sWhat", b"STRING(20)", 21, 1, 30, 2, text_guid),
        ],
    )
    member = b"".join(
        [
            struct.pack("<I", 70),  # 42 head + 5 name + 6 type + 1 comment + 16 GUID
            struct.pack("<III", 1, 0, 0),
            struct.pack("<II", 4, 8),  # 4 bytes behind the pointer
            struct.pack("<II", 19, 0x82),  # UINT32; member with GUID
            struct.pack("<HHHHH", 4, 5, 0, 0, 0),
            b"nFed\0UDINT\0\0",
            bytes.fromhex("95190718 00000000 00000000 00000008"),
        ]
    )
    body = b"".join(
        [
            struct.pack("<III", 1, 0, 0),
            struct.pack("<II", 16, 0),  # 8 pointer + 4, to 8
            struct.pack("<II", 65, 0x1 | 0x80 | 0x800),  # BIGTYPE; type, GUID, methods
            struct.pack("<HHHHH", 9, 0, 0, 0, 1),
            b"FB_Feeder\0\0\0",
            member,
            _guid(station, "FB_Feeder"),
            struct.pack("<H", 2) + feed + last,
        ]
    )
    # 42 head + 12 texts + 70 + 16 + 2 + 274 + (56 + 11 + 65 + 66 + 17 = 215) = 631, to 632
    assert ask(0xF011, "FB_Feeder") == struct.pack("<I", 632) + body + bytes(1)


def test_a_property_is_an_entry_of_group_f019(ask: Any) -> None:
    name = b"MAIN.fbFeeder.fMean"
    assert ask(0xF009, name.decode()) == b"".join(
        [
            # 30 head + 20 name + 6 type + 1 comment + 16 GUID = 73,
            # attributes: count 2, lengths 2, "monitoring" NUL 11, "call" NUL 5 = 20: 93, to 96
            struct.pack("<I", 96),
            struct.pack("<III", 0xF019, 0, 8),
            struct.pack("<I", 5),  # REAL64
            # task 1, type GUID, attributes, read only: it has no SET
            struct.pack("<HH", 0x0100 | 0x0008 | 0x1000 | 0x0020, 0),
            struct.pack("<HHH", 19, 5, 0),
            name + b"\0LREAL\0\0",
            LREAL_GUID,
            struct.pack("<HBB", 1, 10, 4) + b"monitoring\0call\0",
            bytes(3),
        ]
    )


def test_handles_values_and_version(device: Device) -> None:
    handle = device.read_write(0xF003, 0, 4, b"GVL.nShift\0")
    (number,) = struct.unpack("<I", handle)
    assert number != 0
    assert device.read_write(0xF004, 0, 0xFFFF, b"gvl.NSHIFT") == b"\2\0"
    assert device.read(0xF005, number, 1024) == b"\2\0"
    device.write(0xF005, number, b"\7")  # the low byte only
    assert device.read(0xF005, number, 2) == b"\7\0"
    device.write(0xF005, number, b"\2\0")
    (group, offset, size) = struct.unpack("<III", device.read_write(0xF007, 0, 12, b"GVL.nShift"))
    assert (group, size, device.read(group, offset, 2)) == (0x4040, 2, b"\2\0")
    device.write(0xF006, 0, handle)
    with pytest.raises(DeviceError, match="0x710"):
        device.read(0xF005, number, 2)
    assert len(device.read(0xF008, 0, 1)) == 1


def test_the_upload_is_all_entries_sorted_without_case(
    station: Station, device: Device, ask: Any
) -> None:
    names = sorted((placed.name for placed in station.plcs[851].variables), key=str.lower)
    table = b"".join(ask(0xF009, name) for name in names)
    assert device.read(0xF00B, 0, 0xFFFF_FFFF) == table
    count, size = struct.unpack("<II", device.read(0xF00C, 0, 8))
    assert (count, size) == (len(names), len(table))
    info = struct.unpack("<9I28x", device.read(0xF00F, 0, 64))
    assert info[:2] == (count, size)
    assert info[7:] == (1252, 3)
    assert info[3] == len(device.read(0xF00E, 0, 0xFFFF_FFFF))
