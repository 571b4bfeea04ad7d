"""Every kind of fault of a bus of drives: what it does, and that it ends."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from achse.codes import AlState, AlStatus
from achse.drive import Alarm, Drive, PowerState
from achse.ethercat import Slave
from achse.ethercat.ring_segment import RingSegment
from achse.faults.drive_list import DriveFaults
from achse.faults.drives import DRIVE_FAULTS, MailboxDelay
from achse.faults.fault import FaultError
from achse.testing import SegmentReach

MS = 1_000_000


def _power(bus: Any) -> list[PowerState]:
    return [drive.power_state for drive in bus.drives]


def test_an_alarm_lasts_and_is_reset_after_it(bus: Any) -> None:
    for code in ("AL.720", "0xFF19", "65305", "continuous_overload"):
        active = bus.faults.add("alarm", code=code, drive=2)
        bus.run(5)
        assert _power(bus) == [PowerState.SWITCH_ON_DISABLED, PowerState.FAULT]
        assert bus.drives[1].get(0x603F) == Alarm.CONTINUOUS_OVERLOAD.code
        bus.faults.clear(active.number)
        for word in (0, 0x80, 0):
            bus.drives[1].set(0x6040, word)
            bus.run(5)
        assert _power(bus)[1] is PowerState.SWITCH_ON_DISABLED


SIGNALS: dict[str, tuple[dict[str, Any], Callable[[Drive], object]]] = {
    "warning": ({"code": "AL.910"}, lambda drive: int(drive.get(0x3110)) & 1 << 2),
    "encoder_loss": ({"code": "AL.840"}, lambda drive: drive.get(0x603F) == 0xFF25),
    "sto": ({}, lambda drive: drive.record.safety_1 == drive.record.safety_2 == 0),
    "safety": ({}, lambda drive: drive.record.safety_1 != drive.record.safety_2),
    "overtravel": ({"side": "negative"}, lambda drive: int(drive.get(0x60FD)) & 1),
    "probe": ({}, lambda drive: drive.record.probe_input == 1),
    "input": ({"code": "I3"}, lambda drive: int(drive.get(0x60FD)) & 1 << 18),
    "main_power": ({}, lambda drive: not drive.record.main_power),
    "load": ({"by": 250.0}, lambda drive: drive.record.external_load == 250.0),
    "jam": ({}, lambda drive: drive.record.jammed),
    "yaw_alarm": ({}, lambda drive: drive.record.yaw_alarm),
    "local_control": ({}, lambda drive: drive.local),
}


@pytest.mark.parametrize("kind", SIGNALS)
def test_a_fault_of_the_drive_hits_one_or_all_and_ends(bus: Any, kind: str) -> None:
    fields, shows = SIGNALS[kind]
    bus.faults.add(kind, **fields, drive=1, lasting=0.02)
    bus.run(5)
    assert [bool(shows(drive)) for drive in bus.drives] == [True, False]
    bus.run(30)
    assert len(bus.faults) == 0
    bus.run(5)
    if kind != "encoder_loss":  # its alarm is reset by the master
        assert not shows(bus.drives[0])
    bus.faults.add(kind, **fields)
    bus.run(5)
    assert all(shows(drive) for drive in bus.drives)


@pytest.mark.parametrize("state", [AlState.PREOP, AlState.SAFEOP])
def test_a_drive_operated_at_its_panel_falls_to_init(bus: Any, state: AlState) -> None:
    """Rule 22: any state goes to Init with code 0x8000."""
    reach = SegmentReach(bus.segment)
    error = AlState.INIT | 0x10
    bus.drives[0].enter(AlState.INIT, 0, AlStatus.NO_ERROR)
    for each in (AlState.PREOP, AlState.SAFEOP)[: 1 + (state is AlState.SAFEOP)]:
        assert reach.request(each) == (each, 0)
    bus.faults.add("local_control", drive=1, lasting=0.1)
    bus.run(5)
    assert reach.request(AlState.PREOP) == (error, 0x8000), "not acknowledged"
    assert reach.request(AlState.PREOP | 0x10) == (error, 0x8000), "refused again"
    assert reach.request(AlState.INIT | 0x10) == (AlState.INIT, 0)
    bus.run(100)
    assert reach.request(AlState.PREOP) == (AlState.PREOP, 0)


def test_frames_are_lost(bus: Any) -> None:
    active = bus.faults.add("lost_frames", count=2)
    assert [bus.counter() for _ in range(4)] == [None, None, 2, 2]
    assert active.facts()["hits"] == 2
    bus.faults.tick()
    assert (active.state, bus.segment.disturbance) == ("over", None)
    bus.faults.add("lost_frames")
    assert [bus.counter() for _ in range(3)] == [None] * 3
    bus.faults.clear()
    assert bus.counter() == 2


def test_working_counters_are_wrong(bus: Any) -> None:
    bus.faults.add("wrong_counter", by=-1, count=1)
    assert [bus.counter() for _ in range(2)] == [1, 2]
    bus.faults.add("wrong_counter", by=5)
    bus.faults.add("lost_frames", count=1)
    assert [bus.counter() for _ in range(2)] == [None, 7]
    bus.faults.clear()
    assert bus.counter() == 2


@pytest.mark.parametrize("cable", range(1, 4))
def test_any_cable_of_a_ring_is_cut_and_mended(cable: int) -> None:
    ring = RingSegment([Slave(Drive()), Slave(Drive())])
    faults = DriveFaults(ring)
    faults.add("link_break", drive=cable, lasting=1.0)
    faults.add("link_break", drive=cable, lasting=2.0)
    expected = (2, 0) if cable == 3 else (cable - 1, 3 - cable)
    for now_ns in (0, 1_500_000_000):
        ring.advance(now_ns)
        faults.tick()
        assert (ring.parts, ring.whole) == (expected, False)
    ring.advance(2_000_000_000)
    faults.tick()
    assert (ring.parts, ring.whole) == ((2, 0), True)
    with pytest.raises(FaultError, match="drive: there are 2, got 4"):
        faults.add("link_break", drive=4)
    with pytest.raises(FaultError, match="drive: there are 2, got 3"):
        faults.add("sto", drive=3)


def test_a_link_breaks_and_is_mended(bus: Any) -> None:
    bus.faults.add("link_break", drive=2, lasting=1.0)
    assert bus.counter() == 1
    bus.run(1001)
    assert bus.counter() == 2


def test_a_damaged_eeprom_shows_after_the_next_reset(bus: Any) -> None:
    slave = bus.segment.slaves[0]
    active = bus.faults.add("eeprom", drive=1)
    slave.reset()
    assert not slave.esc.operational
    bus.faults.clear(active.number)
    slave.reset()
    assert slave.esc.operational


def test_clocks_drift_and_jitter(bus: Any) -> None:
    clocks = [slave.esc.clock for slave in bus.segment.slaves]
    bus.faults.add("clock_drift", by=200, drive=2)
    bus.faults.add("clock_jitter", by=1e-6)
    bus.run(1000)
    now = bus.segment.time.now_ns
    assert [clock.local_time(now) - now for clock in clocks] == [0, 200_000]
    assert [clock.jitter_ns for clock in clocks] == [1000, 1000]
    bus.faults.clear()
    assert [(clock.drift_ppb, clock.jitter_ns) for clock in clocks] == [(0, 0)] * 2


def test_a_clock_jumps_and_jumps_back(bus: Any) -> None:
    clock = bus.segment.slaves[1].esc.clock
    bus.faults.add("clock_jump", by=0.25, drive=2, lasting=0.01)
    now = bus.segment.time.now_ns
    assert clock.local_time(now) - now == 250 * MS
    bus.run(20)
    now = bus.segment.time.now_ns
    assert clock.local_time(now) == now


def test_mailbox_answers_come_late(bus: Any) -> None:
    bus.faults.add("mailbox_delay", by=0.05, drive=1)
    assert [slave.mailbox_delay_ns for slave in bus.segment.slaves] == [50 * MS, 0]
    bus.faults.clear()
    assert bus.segment.slaves[0].mailbox_delay_ns == 0


def test_a_drive_hangs_and_goes_on(bus: Any) -> None:
    bus.faults.add("hang", drive=2, lasting=0.5)
    bus.run(200)
    assert [slave.esc.memory[0x0443] for slave in bus.segment.slaves] == [0, 1]
    bus.drives[1].set(0x6040, 6)
    bus.run(250)
    assert _power(bus)[1] is PowerState.SWITCH_ON_DISABLED
    bus.run(50)
    bus.run(50)
    assert _power(bus)[1] is PowerState.READY_TO_SWITCH_ON


def _wrong() -> Iterator[tuple[dict[str, Any], str]]:
    yield {"kind": "melt"}, "kind: expected one of"
    yield {"kind": "alarm"}, "code: a fault of kind alarm needs it"
    yield {"kind": "alarm", "code": "AL.999"}, "code: expected a name"
    yield (
        {"kind": "alarm", "code": "16"},
        "code: expected a name, AL. and three digits, or a number",
    )
    yield (
        {"kind": "alarm", "code": "0xZZ"},
        "code: expected a name, AL. and three digits, or a number",
    )
    yield {"kind": "alarm", "code": "065305"}, "code: expected a name"
    yield {"kind": "input", "code": "I9"}, "code: expected NEGATIVE_LIMIT, "
    yield {"kind": "overtravel", "side": "up"}, "side: expected positive or negative"
    yield {"kind": "sto", "drive": 0}, "drive: expected 1"
    yield {"kind": "sto", "drive": 3}, "drive: there are 2, got 3"
    yield {"kind": "mailbox_delay", "by": -1.0}, "by: expected 0"
    yield {"kind": "jam", "by": 1.0}, "by: jam takes"
    yield {"kind": "jam", "at": float("inf")}, "at: expected 0"
    yield {"kind": "jam", "lasting": float("nan")}, "lasting: expected 0"


@pytest.mark.parametrize(("fields", "message"), list(_wrong()))
def test_a_fault_that_cannot_be_is_reported(bus: Any, fields: dict[str, Any], message: str) -> None:
    with pytest.raises(FaultError) as refusal:
        bus.faults.add(DRIVE_FAULTS.of(fields))
    assert str(refusal.value).startswith(message)
    assert len(bus.faults) == 0


def test_tables_of_files_may_have_times_as_texts() -> None:
    table = {"kind": "mailbox_delay", "at": "1s", "lasting": "500ms", "by": "20ms"}
    fault = DRIVE_FAULTS.of_table(table)
    assert isinstance(fault, MailboxDelay)
    assert (fault.at, fault.lasting, fault.by) == (1.0, 0.5, pytest.approx(0.02))
    with pytest.raises(FaultError, match="at: expected a number, got 'soon'"):
        DRIVE_FAULTS.of_table(table | {"at": "soon"})


def test_each_kind_is_tried_here() -> None:
    wire = {"lost_frames", "wrong_counter", "link_break", "eeprom", "mailbox_delay", "hang"}
    others = wire | {"alarm", "clock_drift", "clock_jitter", "clock_jump"}
    assert DRIVE_FAULTS.kinds.keys() == SIGNALS.keys() | others
