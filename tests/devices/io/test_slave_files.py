"""Files of a slave by ADS: opened, read in parts, written, closed, refused."""

import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Flags, Frame
from achse.codes import AlState
from achse.devices.io.slave_device import BusSlaveDevice
from achse.drive.firmware import Firmware
from achse.drive.identity import VENDOR
from achse.ethercat.mailbox import MailboxProtocol
from tests.devices.io.conftest import BUS, IoBus

BOX = 1002
READ, WRITE, CLOSE, NEXT, PUT, ERROR = 0xF401, 0xF402, 0xF403, 0xF404, 0xF405, 0xF407
PROGRESS, STATES = 0xF406, 0x09
DRIVE, MASTER = 1001, 0xFFFF


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
    io.read_write(1003, READ, 0, 4, b"file")
    assert io.code(lambda: io.read_write(1003, NEXT, 1, 9, b"")) == 0x701  # speaks no FoE


class Upgrade:
    """A client that writes the firmware of the drive, and asks how far it is meanwhile."""

    def __init__(self, io: IoBus, name: str, password: int, data: bytes) -> None:
        self.io = io
        opened = io.read_write(DRIVE, WRITE, password, 4, name.encode())
        self.handle = int.from_bytes(opened, "little")
        for at in range(0, len(data), 50_000):
            io.read_write(DRIVE, PUT, self.handle, 0, data[at : at + 50_000])
        self.seen: list[tuple[int, int, int, int]] = []

    def close(self) -> int:
        """The result; `seen` are the steps of progress on the way."""
        head = struct.pack("<IIII", CLOSE, self.handle, 0, 0)
        io, address = self.io, AmsAddress.of(BUS, DRIVE)
        frame = Frame(
            address, io.client, Command.READ_WRITE, Flags.ADS_COMMAND, invoke_id=99, data=head
        )
        io.answers.clear()
        io.router.deliver(frame)
        done: list[Frame] = []
        for _ in range(500_000):
            done += [each for each in io.answers if each.invoke_id == 99]
            if done:
                return int.from_bytes(done[0].data[:4], "little")
            data = io.read(DRIVE, PROGRESS, self.handle)
            step = struct.unpack_from("<4I", data)
            if not self.seen or self.seen[-1] != step:
                self.seen.append(step)
            io.run(20)
        raise AssertionError("never done")


@settings(max_examples=8, deadline=None)
@given(st.data())
def test_firmware_is_written_and_reports_how_far_it_is(data: st.DataObject) -> None:
    """All parameters drawn: name, password, size, state."""
    draw = data.draw
    io = IoBus(0)
    name = draw(st.text("abcdef._-", min_size=1, max_size=20), "name")
    password = draw(st.integers(0, 2**32 - 1), "password")
    io.drive.firmware = Firmware(name, password=password)
    io.up(AlState(draw(st.sampled_from([2, 4]), "state")))
    values = draw(st.sampled_from([password, password ^ 1]), "password given")
    size = draw(st.integers(0, 20_000) | st.sampled_from([244, 488]), "bytes")
    content = bytes(range(256)) * (size // 256 + 1)
    content = content[:size]
    upgrade = Upgrade(io, name, values, content)
    result = upgrade.close()
    if values != password:
        assert result == 0x704
        assert io.read(DRIVE, ERROR, 0)[8:12] == b"\x0a\x80\0\0"
    elif io.master.state != AlState.PREOP:
        assert io.read(DRIVE, ERROR, 0)[8:12] == b"\x04\x80\0\0"
    elif not content:
        assert io.read(DRIVE, ERROR, 0)[8:12] == b"\x0b\x80\0\0"
    else:
        assert result == 0
        assert io.drive.firmware.content == content
        done = [each[0] for each in upgrade.seen]
        assert done == sorted(done)
        assert {each[1] for each in upgrade.seen} <= {0, size}
        if size > 5000:
            assert any(0 < step[2] < step[3] == size for step in upgrade.seen)
        handle = int.from_bytes(io.read_write(DRIVE, READ, password, 4, name.encode()), "little")
        assert io.read_write(DRIVE, NEXT, handle, size + 1, b"") == content
        assert struct.unpack_from("<2I", io.read(DRIVE, PROGRESS, handle)) == (size, 0)
    assert io.code(lambda: io.read(DRIVE, PROGRESS, upgrade.handle)) == 0x703


def test_bootstrap_takes_the_firmware_and_nothing_else(io: Any) -> None:
    io = IoBus(0, drive_firmware=Firmware(bootstrap=True)).up(AlState.PREOP)
    assert Upgrade(io, "firmware.bin", 0, b"new").close() == 0x712
    assert io.read(DRIVE, ERROR, 0)[8:12] == b"\x08\x80\0\0"  # bootstrap only
    io.write(MASTER, STATES, DRIVE, b"\x03\0")
    for _ in range(200):
        if io.read(MASTER, STATES, DRIVE)[0] == AlState.BOOT:
            break
        io.run(5)
    assert io.read(MASTER, STATES, DRIVE) == b"\x03\0"
    assert io.segment.slaves[0].state is AlState.BOOT
    assert io.master.slaves[0].mailbox.capacity == 512 - 6  # of the EEPROM's words 14h to 17h
    assert io.code(lambda: io.read(DRIVE, 0xF302, 0x1018_0001)) == 0x712
    assert io.code(lambda: io.read(DRIVE, 0xF420, 32)) == 0x701
    new = bytes(range(200)) * 20
    assert Upgrade(io, "firmware.bin", 0, new).close() == 0
    assert io.drive.firmware.content == new
    io.up(AlState.OP)
    assert io.master.slaves[0].mailbox.capacity == 256 - 6
    assert io.read(DRIVE, 0xF302, 0x1018_0001) == VENDOR.to_bytes(4, "little")


@pytest.mark.parametrize("before", [AlState.PREOP, AlState.OP])
def test_bootstrap_is_not_requested_of_a_slave_without_it(io: Any, before: AlState) -> None:
    io.up(before)
    assert io.code(lambda: io.write(MASTER, STATES, DRIVE, b"\x03\0")) == 0x701
    io.run(50)
    assert io.master.state == before


def test_a_file_under_way_is_not_touched(io: Any) -> None:
    io.up(AlState.PREOP)
    handle = opened(io, READ, b"file")
    io.segment.slaves[1]._mailbox._services[MailboxProtocol.FOE] = lambda data: ()  # silent
    frame = Frame(
        AmsAddress.of(BUS, BOX), io.client, Command.READ_WRITE, Flags.ADS_COMMAND, invoke_id=99,
        data=struct.pack("<IIII", NEXT, handle, 9, 0),
    )  # fmt: skip
    io.router.deliver(frame)
    assert io.code(lambda: io.read_write(BOX, CLOSE, handle, 0, b"")) == 0x708
    io.run(2500)
    io.read_write(BOX, CLOSE, handle, 0, b"")
