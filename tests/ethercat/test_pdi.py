"""The device's side: AL events and their mask, and a device that looks by itself."""

import struct
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat import AlEvent, Esc
from achse.ethercat.description import describe
from achse.ethercat.loopback import Loopback
from achse.ethercat.sii import build_sii

ALL = b"\xff\xff\xff\xff"


class Silent:
    """A `Pdi` that does nothing when it is called: its firmware looks by itself."""

    def al_control(self, request: int) -> None: ...
    def sync_manager_changed(self, number: int) -> None: ...
    def written(self, number: int, data: bytes) -> None: ...
    def taken(self, number: int) -> None: ...
    def looked_at(self, number: int) -> None: ...
    def timing_changed(self) -> None: ...
    def reset(self) -> None: ...


@pytest.fixture
def esc() -> Esc:
    result = Esc(Silent(), build_sii(describe(Loopback())))
    result.power_up()
    assert result.pdi_access.write(0x0204, ALL)
    return result


def request(esc: Esc) -> int:
    data = esc.read(0x0220, 4)
    assert data is not None
    return int.from_bytes(data, "little")


def mailbox(start: int, control: int) -> bytes:
    return struct.pack("<HHBBBB", start, 32, control, 0, 1, 0)


def test_a_request_is_an_event_until_the_device_reads_it_and_it_answers(esc: Esc) -> None:
    esc.write(0x0120, b"\x02\x00")
    assert request(esc) == esc.pdi_access.request == AlEvent.AL_CONTROL
    assert esc.pdi_access.read(0x0120, 2) == b"\x02\x00"
    assert request(esc) == 0
    assert esc.pdi_access.write(0x0130, b"\x02\x00\x00\x00\x00\x00")
    assert esc.read(0x0130, 6) == b"\x02\x00\x00\x00\x00\x00"
    assert esc.pdi_access.write(0x0130, b"\x12\x00\x00\x00\x1d\x00")
    assert esc.read(0x0130, 6) == b"\x12\x00\x00\x00\x1d\x00"


def test_the_mask_hides_events_from_the_interrupt_line_only(esc: Esc) -> None:
    esc.pdi_access.write(0x0204, b"\x02\0\0\0")
    esc.write(0x0120, b"\x02\x00")
    assert (request(esc), esc.pdi_access.request) == (AlEvent.AL_CONTROL, 0)


def test_a_device_that_looks_serves_a_mailbox(esc: Esc) -> None:
    esc.write(0x0800, mailbox(0x1000, 0x26) + mailbox(0x1100, 0x22))
    assert request(esc) == AlEvent.SYNC_MANAGERS
    esc.pdi_access.read(0x0800, 16)
    assert request(esc) == 0
    for number in (0, 1):
        esc.lock(number, False)
    assert esc.write(0x1000, bytes(range(32)))
    assert request(esc) == AlEvent.SYNC_MANAGER_0
    assert not esc.write(0x1000, bytes(32)), "full"
    assert esc.pdi_access.read(0x1000, 4) == bytes(range(4))
    assert request(esc) == AlEvent.SYNC_MANAGER_0, "the last byte releases it"
    assert esc.pdi_access.read(0x1004, 28) == bytes(range(4, 32))
    assert request(esc) == 0
    assert not esc.pdi_access.write(0x1000, b"\0"), "the master's direction"
    assert esc.read(0x1100, 32) is None
    esc.pdi_access.write(0x1100, b"answer")
    assert esc.read(0x1100, 32) is None, "not complete yet"
    esc.pdi_access.write(0x111F, b"\xaa")
    assert not esc.pdi_access.write(0x1100, b"x"), "full"
    assert esc.read(0x1100, 32) == b"answer".ljust(31, b"\0") + b"\xaa"
    assert request(esc) == AlEvent.SYNC_MANAGER_0 << 1, "the master took it"
    esc.pdi_access.write(0x1100, b"x")
    assert request(esc) == 0, "the device begins the next"


def test_a_device_that_looks_switches_sync_managers_and_exchanges_buffers(esc: Esc) -> None:
    esc.write(0x0800, mailbox(0x1000, 0x24) + mailbox(0x1100, 0x20))
    for number in (0, 1):
        assert esc.read(0x0807 + 8 * number, 1) == b"\1"
        assert esc.pdi_access.write(0x0807 + 8 * number, b"\0")
        assert esc.pdi_access.read(0x0807 + 8 * number, 1) == b"\0"
        assert not esc.pdi_access.write(0x0806 + 8 * number, b"\0"), "the master's"
    for value in (b"one", b"two"):
        assert esc.write(0x1000, value.ljust(32))
        assert esc.pdi_access.read(0x1000, 32) == value.ljust(32)
        assert esc.pdi_access.write(0x1100, value.ljust(32))
        assert esc.read(0x1100, 32) == value.ljust(32)
        assert esc.read(0x1100, 32) == value.ljust(32), "a buffer is never empty"
    assert esc.pdi_access.write(0x0807, b"\1")
    assert not esc.write(0x1000, bytes(32))
    assert esc.pdi_access.write(0x080F, b"\2")
    assert esc.read(0x080F, 1) == b"\2", "a repeat is acknowledged"
    assert not esc.pdi_access.write(0x0827, b"\0"), "there are four"


def test_status_and_code_are_written_apart(esc: Esc) -> None:
    esc.pdi_access.write(0x0134, b"\x1d\0")
    esc.pdi_access.write(0x0130, b"\x12\0")
    assert esc.read(0x0130, 6) == b"\x12\0\0\0\x1d\0"
    esc.pdi_access.write(0x0130, b"\2\0")
    assert esc.read(0x0130, 6) == b"\2\0\0\0\x1d\0"


def test_the_watchdog_is_an_event_until_its_status_is_read(esc: Esc) -> None:
    esc.set_watchdog(expired=True)
    assert request(esc) == AlEvent.WATCHDOG
    esc.pdi_access.read(0x0440, 1)
    assert request(esc) == 0


def test_sync_and_latch_are_events_until_they_are_read(esc: Esc) -> None:
    esc.write(0x0990, (1_000_000).to_bytes(8, "little"))
    esc.write(0x09A0, (1_000_000).to_bytes(4, "little"))
    esc.write(0x09A4, (250_000).to_bytes(4, "little"))
    esc.write(0x0980, b"\0\x07")
    seen = []
    for microseconds in (999, 1000, 1249, 1250):
        esc.time.now_ns = 1000 * microseconds
        seen.append(request(esc))
    both = AlEvent.SYNC0 | AlEvent.SYNC1
    assert seen == [0, AlEvent.SYNC0, AlEvent.SYNC0, both]
    esc.pdi_access.read(0x098E, 1)
    assert request(esc) == AlEvent.SYNC1
    esc.pdi_access.read(0x098F, 1)
    assert request(esc) == 0
    esc.time.now_ns = 2_000_000
    assert request(esc) == AlEvent.SYNC0
    esc.pdi_access.read(0x098E, 2)
    esc.latch(0, True)
    assert request(esc) == AlEvent.LATCH
    esc.read(0x09B0, 8)
    assert request(esc) == 0


def test_what_the_device_may_write(esc: Esc) -> None:
    assert esc.pdi_access.write(0x0012, b"\x34\x12")
    assert esc.alias == 0x1234
    assert esc.pdi_access.write(0x1800, b"plain")
    assert esc.read(0x1800, 5) == b"plain"
    assert esc.pdi_access.read(0x1800, 5) == b"plain"
    for address in (0x0000, 0x0010, 0x0120, 0x0800):
        assert not esc.pdi_access.write(address, b"\0")
    assert not esc.pdi_access.write(0x0130, b"\x05\0")


def test_a_slave_of_this_package_leaves_no_event(line: Any) -> None:
    master = line(1)
    master.bring(AlState.OP)
    master.advance(200)  # its watchdog expires
    master.coe(2, b"\x40\x00\x10\0\0\0\0\0")
    assert master.number(0x0220, 4) & ~(AlEvent.SYNC_MANAGER_0 << 1) == 0


def test_a_hanging_device_lets_frames_pass_and_answers_when_it_goes_on(line: Any) -> None:
    master = line(1)
    master.bring(AlState.OP)
    slave = master.segment.slaves[0]
    master.exchange(b"good")
    master.advance(1)
    slave.hang()
    for _ in range(9):
        master.advance(10)
        assert master.exchange(b"lost") == (b"good", 2)
    assert master.number(0x0110, 2) & 0x02
    for _ in range(2):
        master.advance(10)
        master.exchange(b"last")
    assert not master.number(0x0110, 2) & 0x02, "the PDI watchdog has expired"
    assert master.number(0x0443, 1) == 1
    assert master.post(b"\0\x20\x40\x00\x10\0\0\0\0\0") == 1
    assert master.fetch() is None
    assert master.request(AlState.SAFEOP) == (AlState.OP, 0)
    slave.hang(False)
    assert master.status() == (AlState.SAFEOP, 0)
    assert master.fetch() is not None
    assert master.number(0x0110, 2) & 0x02


@pytest.mark.parametrize(("ticks", "expired"), [(0, False), (10, True)])
def test_the_pdi_watchdog_time_is_the_masters(line: Any, ticks: int, expired: bool) -> None:
    master = line(1)
    master.address()
    master.write(0x0410, ticks.to_bytes(2, "little"))
    master.segment.slaves[0].hang()
    master.advance(2)
    assert master.number(0x0443, 1) == expired
