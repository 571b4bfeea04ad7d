"""The slave controller's memory: registers that act, and the working counter's point of view."""

import struct
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat import DatagramCommand, Loopback, Slave
from achse.ethercat.esc import Esc

STATION = 0x1001


@pytest.fixture
def esc() -> Esc:
    return Slave(Loopback()).esc


def number(esc: Esc, address: int, length: int) -> int:
    data = esc.read(address, length)
    assert data is not None
    return int.from_bytes(data, "little")


def test_information(esc: Esc) -> None:
    data = esc.read(0x0000, 10)
    assert data is not None
    kind, revision, build, fmmus, sync_managers, ram, ports, features = struct.unpack(
        "<BBHBBBBH", data
    )
    assert (kind, revision, build) == (0x11, 0, 2)
    assert (fmmus, sync_managers, ram) == (3, 4, 8)  # 001 table 2.2.1
    assert ports == 0x0F
    assert features & 0x0004  # distributed clocks
    assert not features & 0x0200  # LRW works


def test_power_up_values(esc: Esc) -> None:
    assert number(esc, 0x0130, 2) == 1
    assert number(esc, 0x0134, 2) == 0
    assert number(esc, 0x0400, 2) == 0x09C2
    assert number(esc, 0x0410, 2) == number(esc, 0x0420, 2) == 1000
    assert esc.watchdog_ns == 100_000_000
    assert number(esc, 0x0440, 2) & 1


@pytest.mark.parametrize("address", [0x0000, 0x0012, 0x0110, 0x0130, 0x0134, 0x0805, 0x092C])
def test_read_only_registers_do_not_count_as_written(esc: Esc, address: int) -> None:
    before = esc.read(address, 1)
    assert not esc.write(address, b"\xa5")
    assert esc.read(address, 1) == before


def test_an_access_counts_if_any_byte_is_writable(esc: Esc) -> None:
    assert esc.write(0x000E, b"\x11\x11\x05\x10\x22\x22")
    assert number(esc, 0x000E, 6) == 0x1005 << 16


def test_masters_clear_more_channels_than_there_are(esc: Esc) -> None:
    """256 bytes of FMMUs, 128 of SyncManagers, error counters with what follows them."""
    assert esc.write(0x0600, bytes(256))
    assert esc.write(0x0800, bytes(128))
    assert esc.write(0x0300, bytes(20))
    assert not esc.write(0x0630, bytes(16))  # a fourth FMMU
    assert not esc.write(0x0820, bytes(8))  # a fifth SyncManager


def test_error_counters_are_cleared_by_any_write(esc: Esc) -> None:
    for address in (0x0300, 0x0302, 0x030C, 0x0311, 0x0442):
        esc.count(address)
        assert number(esc, address, 1) == 1
    assert esc.write(0x0301, b"\xff")
    assert number(esc, 0x0300, 12) == 0
    assert number(esc, 0x030C, 1) == 1
    esc.write(0x030C, b"\0")
    esc.write(0x0310, b"\0")
    esc.write(0x0443, b"\0")
    assert number(esc, 0x030C, 8) == number(esc, 0x0442, 2) == 0


def test_error_counters_stop_at_255(esc: Esc) -> None:
    for _ in range(300):
        esc.count(0x0310)
    assert number(esc, 0x0310, 1) == 255


def test_memory_without_sync_manager_is_plain(esc: Esc) -> None:
    assert esc.write(0x2000, b"data")
    assert esc.read(0x2000, 4) == b"data"
    assert esc.write(0x0F80, bytes(range(128)))
    assert esc.read(0x0F80, 128) == bytes(range(128))


@pytest.mark.parametrize(
    ("address", "length"), [(0x3000, 1), (0x2FFF, 2), (0xFFFF, 1), (0xFFFF, 9)]
)
def test_there_is_no_memory_behind_the_ram(esc: Esc, address: int, length: int) -> None:
    assert esc.read(address, length) is None
    assert not esc.write(address, bytes(length))


def test_an_access_may_go_from_registers_into_memory(esc: Esc) -> None:
    assert esc.write(0x0FFE, b"abcd")
    assert esc.read(0x0FFE, 4) == b"abcd"
    assert esc.read(0x1000, 2) == b"cd"


def test_an_access_over_a_closed_mailbox_changes_nothing(esc: Esc) -> None:
    esc.write(0x0800, struct.pack("<HHBBBB", 0x1000, 4, 0x26, 0, 1, 0))
    assert esc.read(0x0FFE, 4) is None
    assert not esc.write(0x0FFE, b"abcd")
    assert esc.read(0x0FFE, 2) == b"\0\0"
    assert esc.write(0x1004, b"x")


def test_one_access_covers_memory_and_buffers(master: Any) -> None:
    """Plain memory, inputs, plain memory."""
    master.bring(AlState.SAFEOP)
    assert master.write(0x12FE, b"ab") == 1
    assert master.write(0x1304, b"cd") == 1
    assert master.read(0x12FE, 8) == b"ab\0\0\0\0cd"


def test_bits(esc: Esc) -> None:
    esc.write(0x2000, b"\xff\x00\xff")
    assert esc.read_bits(0x2000 * 8 + 6, 4) == 0b0011
    assert esc.write_bits(0x2000 * 8 + 6, 4, 0b1010)
    assert esc.read(0x2000, 3) == bytes((0b10111111, 0b00000010, 0xFF))
    assert esc.read_bits(0x3000 * 8, 1) is None
    assert not esc.write_bits(0x3000 * 8, 1, 1)


def test_the_watchdog_time(esc: Esc) -> None:
    esc.write(0x0420, (50).to_bytes(2, "little"))
    assert esc.watchdog_ns == 5_000_000
    esc.write(0x0400, (998).to_bytes(2, "little"))  # (998 + 2) · 40 ns
    assert esc.watchdog_ns == 50 * 40_000
    esc.write(0x0420, bytes(2))
    assert esc.watchdog_ns == 0


def test_reset_needs_three_letters_in_order(master: Any) -> None:
    master.bring(AlState.OP)
    for letter in b"RERS":
        master.write(0x0040, bytes((letter,)))
    assert master.segment.slaves[0].state is AlState.OP
    for letter in b"RES":
        master.one(DatagramCommand.APWR, 0, 0x0040, bytes((letter,)))
    slave = master.segment.slaves[0]
    assert slave.state is AlState.INIT
    assert master.line[0].state is AlState.INIT
    assert slave.esc.station == 0
    assert number(slave.esc, 0x0110, 2) & 0x0200  # the link is up again


def test_the_alias_comes_from_the_switches_else_from_the_eeprom(esc: Esc) -> None:
    assert number(esc, 0x0012, 2) == 0
    assert number(Slave(Loopback(), alias=0x25).esc, 0x0012, 2) == 0x25


def test_the_alias_is_an_address_once_the_master_says_so(master: Any) -> None:
    slave = Slave(Loopback(), alias=0x25)
    master.segment.attach(slave)
    assert master.one(DatagramCommand.FPRD, 0x25, 0x0000, bytes(1)).counter == 0
    master.one(DatagramCommand.BWR, 0, 0x0103, b"\x01")
    assert master.one(DatagramCommand.FPRD, 0x25, 0x0000, bytes(1)).counter == 1


def test_al_status_is_an_event_until_it_is_read(master: Any) -> None:
    master.read(0x0130, 2)
    assert master.number(0x0210, 2) & 0x08 == 0
    master.request(0x15)
    master.mailboxes()
    master.write(0x0120, b"\x12\x00")
    assert master.number(0x0210, 2) & 0x08
    master.read(0x0130, 2)
    assert master.number(0x0210, 2) & 0x08 == 0


def test_an_unmasked_event_is_in_every_datagram(master: Any) -> None:
    master.read(0x0110, 2)
    master.write(0x0200, b"\x04\x00")
    assert master.one(DatagramCommand.FPRD, STATION, 0x0000, bytes(1)).irq == 0
    slave = Slave(Loopback())
    master.segment.attach(slave)
    assert master.one(DatagramCommand.FPRD, STATION, 0x0000, bytes(1)).irq == 0x04
    master.read(0x0110, 2)
    assert master.one(DatagramCommand.FPRD, STATION, 0x0000, bytes(1)).irq == 0
