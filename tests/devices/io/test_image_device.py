"""Port 27904 + id: the image by symbol, handle and place."""

import struct
from typing import Any

import pytest

from achse.ams import Command, DeviceError, NetId
from achse.devices.io.image import INPUT_BASE
from achse.devices.io.image_device import IMAGE_PORT, BusImageDevice, ImageSymbols
from achse.devices.value_symbols import ValueSymbol
from achse.iec.symbols import decode_symbols

STATION = NetId("10.1.2.3.1.1")
PORT = IMAGE_PORT + 1


class At:
    """A client at the image's port, which is one of the station."""

    def __init__(self, io: Any) -> None:
        self.io = io

    def read(self, group: int, offset: int, length: int) -> bytes:
        request = struct.pack("<III", group, offset, length)
        return bytes(self.io.ask(PORT, Command.READ, request, STATION)[4:])

    def read_write(self, group: int, length: int, data: bytes) -> bytes:
        head = struct.pack("<IIII", group, 0, length, len(data))
        return bytes(self.io.ask(PORT, Command.READ_WRITE, head + data, STATION)[4:])


def symbols(io: Any) -> ImageSymbols:
    device = io.attached.devices[-1]
    assert isinstance(device, BusImageDevice)
    assert device.symbols is not None
    source = device.symbols.source
    assert isinstance(source, ImageSymbols)
    return source


def test_the_table_is_uploaded_and_read_by_its_places(io: Any) -> None:
    at = At(io.up())
    count, size = struct.unpack_from("<II", at.read(0xF00F, 0, 24))
    table = list(decode_symbols(at.read(0xF00B, 0, size)))
    assert len(table) == count
    by_name = {each.name: each for each in table}
    entry = by_name["Inputs.SlaveCount"]
    assert at.read(entry.index_group, entry.index_offset, entry.size) == b"\3\0"
    wc = by_name["Box 1.WcState.WcState"]
    assert at.read(wc.index_group, wc.index_offset, 1) == b"\0"
    state = by_name["Box 3.InfoData.State"]
    assert at.read(state.index_group, state.index_offset, state.size) == b"\x08\0"
    for each in table:
        assert len(at.read(each.index_group, each.index_offset, each.size)) == each.size


def test_values_by_name(io: Any) -> None:
    at = At(io.up())
    handle = at.read_write(0xF003, 4, b"Box 2.InfoData.AdsAddr\0")
    value = at.read(0xF005, int.from_bytes(handle, "little"), 8)
    assert value == bytes(io.served.net_id) + (1002).to_bytes(2, "little")


def test_nothing_is_written_and_places_outside_are_refused(io: Any) -> None:
    at = At(io.up())
    result = symbols(io).resolve("inputs.devstate")
    assert isinstance(result, ValueSymbol)
    with pytest.raises(DeviceError, match="read only"):
        result.write(b"\0\0")
    assert io.code(lambda: at.read(0xF020, INPUT_BASE - 1, 1)) == 0x703
    assert io.code(lambda: at.read(0xF021, 8 * INPUT_BASE + 80_000, 1)) == 0x703
    assert symbols(io).type_entry("UINT")
    assert symbols(io).type_entry("nothing") is None
