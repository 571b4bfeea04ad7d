"""Port 300: every row of group 0x5000."""

import struct
from typing import Any

import pytest

from achse.ams import AmsAddress
from achse.codes import AlState, ReturnCode

NOT_FOUND = ReturnCode.NOT_FOUND.number


def test_devices_by_number(io: Any) -> None:
    assert io.read(300, 0x5000, 2) == b"\x01\0\0\0"
    assert io.read(300, 0x5000, 1) == b"\x01\0\x01\0"
    assert io.read(300, 0x5001, 1, 256) == b"Device 1 (EtherCAT)\0"
    assert io.read(300, 0x5001, 5) == bytes((10, 1, 2, 3, 2, 1))
    assert io.read(300, 0x5001, 7) == b"\x6f\0"
    assert io.code(lambda: io.read(300, 0x5002, 1)) == NOT_FOUND
    assert io.code(lambda: io.read(300, 0x5001, 99)) == ReturnCode.INVALID_OFFSET.number


def test_names_of_devices_and_boxes(io: Any) -> None:
    assert io.read_write(300, 0x5000, 3, 4, b"Device 1 (EtherCAT)\0") == b"\x01\0\0\0"
    assert io.code(lambda: io.read_write(300, 0x5000, 3, 4, b"device 1 (ethercat)")) == NOT_FOUND
    assert io.read_write(300, 0x5001, 4, 2, b"Box 2\0") == (1002).to_bytes(2, "little")
    assert io.read_write(300, 0x5001, 6, 50, (1003).to_bytes(2, "little")) == b"Box 3\0"
    assert io.code(lambda: io.read_write(300, 0x5001, 6, 50, b"\1\0")) == NOT_FOUND
    assert io.read_write(300, 0x5001, 8, 6, (1003).to_bytes(2, "little")) == io.served.net_id


def test_boxes_on_line(io: Any) -> None:
    assert io.read(300, 0x5001, 3) == bytes(4)
    io.up(AlState.PREOP)
    assert io.read(300, 0x5001, 3) == b"\x03\0\0\0"


@pytest.mark.parametrize(("group", "offset"), [(0x5000, 10), (0x5001, 10)])
def test_the_combined_list(io: Any, group: int, offset: int) -> None:
    data = io.read(300, group, offset, 4096)
    length, version, kind, number, boxes = struct.unpack_from("<IHHHH", data)
    assert (length, version, kind, number, boxes) == (len(data), 1, 111, 1, 3)
    assert data[12:20] == AmsAddress.of(io.served.net_id, 0xFFFF)
    sizes = struct.unpack_from("<HH", data, 20)
    at = 24 + sum(sizes)
    assert data[24:at] == b"Device 1 (EtherCAT)\0a comment\0"
    for number in range(1, 4):
        size, result, _, station = struct.unpack_from("<4H", data, at)
        assert (result, station) == (number, 1000 + number)
        assert data[at + 20 : at + size] == f"Box {number}\0\0".encode()
        at += size
    assert at == len(data)


def test_a_reset_leads_all_through_init(io: Any) -> None:
    io.up()
    io.line[0].state = AlState.BOOT
    io.master.take_events()
    io.write(300, 0x5001, 9)
    io.run(5)
    io.up()
    reached = [
        (each.station, each.number) for each in io.master.take_events() if each.kind.name == "STATE"
    ]
    assert all((1001 + number, AlState.INIT) in reached for number in range(3))
