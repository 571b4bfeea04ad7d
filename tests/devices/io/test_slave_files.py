"""Files of a slave by ADS: opened, read in parts, written, closed, refused."""

import struct
from typing import Any

from achse.codes import AlState
from achse.devices.io.slave_device import BusSlaveDevice
from achse.ethercat.mailbox import MailboxProtocol

BOX = 1002
READ, WRITE, CLOSE, NEXT, PUT, ERROR = 0xF401, 0xF402, 0xF403, 0xF404, 0xF405, 0xF407


class Disk:
    """A slave with one file, in one packet."""

    def __init__(self, io: Any) -> None:
        self.content = b"hello"
        io.segment.slaves[1]._mailbox._services[MailboxProtocol.FOE] = self.answer

    def answer(self, data: bytes) -> list[bytes]:
        if data[6:] == b"none":
            return [struct.pack("<BxI", 5, 0x8001)]
        match data[0]:
            case 1:
                return [struct.pack("<BxI", 3, 1) + self.content]
            case 2:
                return [struct.pack("<BxI", 4, 0)]
            case 3:
                self.content = data[6:]
                return [struct.pack("<BxI", 4, 1)]
        return []


def opened(io: Any, group: int, name: bytes) -> int:
    return int.from_bytes(io.read_write(BOX, group, 0, 4, name), "little")


def test_a_file_is_read_in_parts_and_written(io: Any) -> None:
    io.up(AlState.PREOP)
    disk = Disk(io)
    handle = opened(io, READ, b"file\0")
    assert [io.read_write(BOX, NEXT, handle, 3, b"") for _ in range(3)] == [b"hel", b"lo", b""]
    io.read_write(BOX, CLOSE, handle, 0, b"")
    handle = opened(io, WRITE, b"file")
    io.read_write(BOX, PUT, handle, 0, b"good ")
    io.read_write(BOX, PUT, handle, 0, b"bye")
    assert disk.content == b"hello"
    io.read_write(BOX, CLOSE, handle, 0, b"")
    assert disk.content == b"good bye"


def test_refusals(io: Any) -> None:
    io.up(AlState.PREOP)
    Disk(io)
    handle = opened(io, READ, b"none")
    assert io.code(lambda: io.read_write(BOX, NEXT, handle, 9, b"")) == 0x70C
    assert io.read(BOX, ERROR, 0)[8:12] == b"\x01\x80\0\0"
    assert io.code(lambda: io.read_write(BOX, PUT, handle, 0, b"x")) == 0x704
    assert io.code(lambda: io.read_write(BOX, NEXT, 99, 9, b"")) == 0x703
    assert io.code(lambda: io.read_write(BOX, READ, 0, 4, b"")) == 0x706
    for _ in range(7):
        opened(io, READ, b"file")
    assert io.code(lambda: opened(io, READ, b"file")) == 0x70A
    device = next(
        each
        for each in io.attached.devices
        if isinstance(each, BusSlaveDevice) and each.slave.station == BOX
    )
    device.end_client(io.client)
    assert opened(io, READ, b"file")
    io.read_write(1001, READ, 0, 4, b"file")
    assert io.code(lambda: io.read_write(1001, NEXT, 1, 9, b"")) == 0x701  # speaks no FoE
