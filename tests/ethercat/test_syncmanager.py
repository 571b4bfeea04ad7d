"""SyncManagers: who may access what when, and when a buffer changes owner."""

from typing import Any

import pytest

from achse.ethercat.syncmanager import SyncManager

SIZE = 4
MAILBOX_OUT, MAILBOX_IN, OUTPUTS, INPUTS = 0x26, 0x22, 0x64, 0x20


class Fixture:
    def __init__(self, control: int) -> None:
        self.written: list[bytes] = []
        self.taken = 0
        self.sm = SyncManager(0, self.written.append, self.count)
        self.sm.configure(bytes((0, 0x10, SIZE, 0, control, 0, 1, 0)))
        self.sm.locked = False

    def count(self) -> None:
        self.taken += 1


@pytest.mark.parametrize(
    ("control", "buffered", "to_application", "watchdog"),
    [
        (MAILBOX_OUT, False, True, False),
        (MAILBOX_IN, False, False, False),
        (OUTPUTS, True, True, True),
        (0x24, True, True, False),
        (INPUTS, True, False, False),
    ],
)
def test_control(control: int, buffered: bool, to_application: bool, watchdog: bool) -> None:
    sm = Fixture(control).sm
    assert (sm.buffered, sm.to_application, sm.triggers_watchdog) == (
        buffered,
        to_application,
        watchdog,
    )
    assert (sm.start, sm.length, sm.end, sm.works) == (0x1000, SIZE, 0x1004, True)


def test_registers_are_start_length_control_and_activation() -> None:
    sm = SyncManager(3, lambda _: None, lambda: None)
    assert (sm.start, sm.length, sm.enabled, sm.locked, sm.number) == (0, 0, False, True, 3)
    for activation in range(4):
        sm.configure(bytes((0x34, 0x12, 0x02, 0x01, 0x26, 0xFF, activation, 0xFF)))
        assert (sm.start, sm.length, sm.end, sm.control) == (0x1234, 0x0102, 0x1336, 0x26)
        assert (sm.enabled, sm.repeat_request) == (activation & 1 == 1, activation & 2 == 2)


@pytest.mark.parametrize("other_bits", [0, 0x30, 0xB0])
def test_control_has_mode_direction_and_watchdog(other_bits: int) -> None:
    for mode in range(4):
        for direction in range(4):
            for watchdog in (0, 0x40):
                sm = Fixture(mode | direction << 2 | watchdog | other_bits).sm
                assert sm.buffered is (mode == 0)
                assert sm.to_application is (direction == 1)
                assert sm.triggers_watchdog is bool(watchdog)


@pytest.mark.parametrize(
    ("control", "event", "concerns"),
    [(MAILBOX_OUT, 0, False), (MAILBOX_OUT, 1, True), (MAILBOX_OUT, 2, False),
     (MAILBOX_IN, 0, False), (MAILBOX_IN, 1, False), (MAILBOX_IN, 2, True),
     (OUTPUTS, 0, False), (OUTPUTS, 1, True), (INPUTS, 1, False), (INPUTS, 2, True)],
)  # fmt: skip
def test_what_concerns_the_application(control: int, event: int, concerns: bool) -> None:
    sm = Fixture(control).sm
    sm.events = event
    assert sm.concerns_application is concerns
    sm.locked = True
    assert not sm.concerns_application
    sm.locked, sm.sink = False, lambda _: None
    assert not sm.concerns_application
    sm.sink, sm.source = None, lambda: b""
    assert not sm.concerns_application


def test_message_of_any_part_is_read_to_its_end() -> None:
    fixture = Fixture(MAILBOX_IN)
    sm = fixture.sm
    sm.put(b"abcde"[:SIZE])
    assert [sm.read(at, 1) for at in range(SIZE)] == [b"a", b"b", b"c", b"d"]
    assert (sm.full, sm.events, fixture.taken) == (False, 2, 1)
    sm.put(b"x")
    assert (sm.full, sm.events, sm.newest) == (True, 1, b"x\0\0\0")
    sm.release()
    assert (sm.full, sm.events) == (False, 2)
    sm.reset()
    assert (sm.full, sm.events, sm.newest, bytes(sm.peek())) == (False, 0, bytes(4), bytes(4))


def test_buffer_that_is_read_to_its_end_has_no_event() -> None:
    fixture = Fixture(INPUTS)
    fixture.sm.source = lambda: b"1234"
    assert fixture.sm.read(0, 4) == b"1234"
    assert fixture.sm.read(1, 2) == b"23"
    assert (fixture.sm.events, fixture.taken, fixture.sm.status) == (0, 0, 0x30)


@pytest.mark.parametrize("events", [0, 1, 2])
def test_status_of_a_mailbox_has_events_and_whether_it_is_full(events: int) -> None:
    sm = Fixture(MAILBOX_IN).sm
    sm.events = events
    assert sm.status == events
    sm.full = True
    assert sm.status == events | 8


def test_buffer_is_accessed_in_its_direction_only() -> None:
    for control, writes in ((OUTPUTS, True), (INPUTS, False)):
        sm = Fixture(control).sm
        assert (sm.accepts(True), sm.accepts(False)) == (writes, not writes)


def test_part_of_a_buffer_waits_for_the_last_byte() -> None:
    fixture = Fixture(OUTPUTS)
    fixture.sm.write(1, b"bc")
    assert bytes(fixture.sm.peek()) == b"\0bc\0"
    fixture.sm.write(2, b"CD")
    assert fixture.written == [b"\0bCD"]
    assert (fixture.sm.full, fixture.sm.status) == (False, 0x01)


def test_area_of_one_byte_is_guarded() -> None:
    sm = Fixture(OUTPUTS).sm
    sm.configure(bytes((0, 0x10, 1, 0, OUTPUTS, 0, 1, 0)))
    assert sm.guards
    assert sm.works


def test_a_message_is_complete_with_its_last_byte() -> None:
    fixture = Fixture(MAILBOX_OUT)
    fixture.sm.write(0, b"ab")
    assert (fixture.written, fixture.sm.full) == ([], False)
    fixture.sm.write(3, b"d")
    assert fixture.written == [b"ab\0d"]
    assert fixture.sm.full
    assert fixture.sm.status == 0x09


def test_a_full_mailbox_takes_no_message() -> None:
    sm = Fixture(MAILBOX_OUT).sm
    assert sm.accepts(write=True)
    assert not sm.accepts(write=False)
    sm.write(0, b"1234")
    assert not sm.accepts(write=True)
    sm.release()
    assert sm.accepts(write=True)
    assert sm.status == 0x02


def test_an_empty_mailbox_gives_no_message() -> None:
    fixture = Fixture(MAILBOX_IN)
    sm = fixture.sm
    assert not sm.accepts(write=False)
    sm.put(b"ab")
    assert sm.accepts(write=False)
    assert not sm.accepts(write=True)
    assert sm.status == 0x09
    assert sm.read(0, 2) == b"ab"
    assert (sm.full, fixture.taken) == (True, 0)
    assert sm.read(3, 1) == b"\0"
    assert (sm.full, fixture.taken) == (False, 1)
    assert sm.status == 0x02


def test_the_reader_of_a_buffer_gets_one_complete_buffer() -> None:
    sm = Fixture(INPUTS).sm
    values = iter([b"1111", b"2222"])
    sm.source = lambda: next(values)
    assert sm.read(0, 2) == b"11"
    assert sm.read(2, 2) == b"11"
    assert sm.read(0, 4) == b"2222"


def test_a_buffer_is_written_when_its_last_byte_is() -> None:
    fixture = Fixture(OUTPUTS)
    assert fixture.sm.status == 0x30  # none written
    fixture.sm.write(0, b"123")
    assert fixture.written == []
    fixture.sm.write(3, b"4")
    fixture.sm.write(0, b"5678")
    assert fixture.written == [b"1234", b"5678"]
    assert fixture.sm.newest == b"5678"


def test_three_buffers_take_turns() -> None:
    sm = Fixture(OUTPUTS).sm
    last = []
    for _ in range(4):
        sm.write(0, b"1234")
        last.append(sm.status >> 4)
    assert last == [0, 1, 2, 0]


@pytest.mark.parametrize("control", [MAILBOX_OUT, MAILBOX_IN, OUTPUTS, INPUTS])
@pytest.mark.parametrize("write", [True, False])
def test_a_locked_sync_manager_refuses_all(control: int, write: bool) -> None:
    sm = Fixture(control).sm
    sm.locked = True
    assert sm.guards
    assert not sm.works
    assert not sm.accepts(write)


def test_a_disabled_or_empty_one_guards_nothing() -> None:
    sm = Fixture(OUTPUTS).sm
    sm.configure(bytes((0, 0x10, SIZE, 0, OUTPUTS, 0, 0, 0)))
    assert not sm.guards
    assert not sm.works
    sm.configure(bytes((0, 0x10, 0, 0, OUTPUTS, 0, 1, 0)))
    assert not sm.guards


def test_mailboxes_at_the_registers(master: Any) -> None:
    master.mailboxes()
    assert master.read(0x0800, 8) == bytes.fromhex("0010 0001 26 00 01 01")  # locked in Init
    assert master.post(b"") == 0
    master.request(2)
    assert master.read(0x0800, 8) == bytes.fromhex("0010 0001 26 00 01 00")
    assert master.post(b"\0\0") == 1


def test_two_pieces_make_a_message(master: Any) -> None:
    """One master writes the header and then the last byte only."""
    master.mailboxes()
    master.request(2)
    message = bytes.fromhex("0a00 0000 00 13 0020 40 1810 01 00000000")
    assert master.write(0x1000, message) == 1
    assert master.fetch() is None
    assert master.write(0x10FF, b"\0") == 1
    assert master.fetch() == (3, bytes.fromhex("0030 43 1810 01 00000000"))
