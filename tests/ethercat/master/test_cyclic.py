"""Cyclic exchange: outputs are memory, wrong counters freeze inputs, lost frames are counted."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.ethercat import (
    Datagram,
    DatagramCommand,
    Disturbance,
    EthercatFrame,
    Loopback,
    describe,
)
from achse.ethercat.master import BusConfiguration, ClockConfiguration, from_description
from achse.ethercat.master.configuration import SlaveConfiguration
from achse.ethercat.master.cyclic import CyclicCounters, CyclicExchange, _Template
from achse.ethercat.master.process_image import MAILBOX_BITS, ProcessDatagram, ProcessImage
from tests.ethercat.master.boxes import box


def test_outputs_come_back_as_inputs(bus: Callable[..., Any]) -> None:
    ours = bus(3).up()
    for number, slave in enumerate(ours.master.slaves):
        slave.outputs[:] = bytes((number, 1, 2, 3))
    ours.run(2)
    for number, slave in enumerate(ours.master.slaves):
        assert bytes(slave.inputs) == bytes((number, 1, 2, 3))
        assert slave.working


def test_without_reference_no_time_is_carried(bus: Callable[..., Any]) -> None:
    ours = bus(2, {"clock": ClockConfiguration()}).up()
    cyclic = ours.master.cyclic
    assert cyclic._clock is not None
    cyclic.set_reference(None)
    at = cyclic._clock.at
    assert cyclic.frames()[0][at] == DatagramCommand.NOP
    assert cyclic.frames()[0][at + 2 : at + 4] == bytes(2)


def test_a_wrong_counter_freezes_the_inputs_of_its_unit(bus: Callable[..., Any]) -> None:
    ours = bus(2).up()
    first, _ = ours.master.slaves
    first.outputs[0] = 5
    ours.run(2)
    ours.segment.disturbance = Disturbance(counter=1, counter_frames=1)
    first.outputs[0] = 6
    wrong = ours.master.cyclic.counters.wrong
    ours.run()
    assert (first.inputs[0], first.working) == (5, False)
    assert ours.master.cyclic.frame_states[0] & 1
    toggle = first.input_toggle
    ours.run(2)
    assert (first.inputs[0], first.working, first.input_toggle) == (6, True, toggle)
    assert ours.master.cyclic.counters.wrong == wrong + 1


def test_a_missing_slave_invalidates_its_unit_only(bus: Callable[..., Any]) -> None:
    ours = bus(2)
    from achse.ethercat.master import Master, Ring

    slaves = ours.master.bus.slaves
    own = tuple(replace(each, sync_unit=str(number)) for number, each in enumerate(slaves))
    ours.master = Master(BusConfiguration(own, cycle_ns=1_000_000))
    ours.ring = Ring(ours.master, ours.segment)
    ours.up()
    ours.segment.break_link(ours.segment.slaves[1])
    ours.run()
    assert [each.working for each in ours.master.slaves] == [True, False]


def test_lost_frames_are_counted_and_not_waited_for(bus: Callable[..., Any]) -> None:
    ours = bus().up()
    (slave,) = ours.master.slaves
    ours.segment.disturbance = Disturbance(lose=1)
    ours.run()
    before = ours.master.cyclic.counters.lost
    ours.run()
    assert ours.master.cyclic.counters.lost == before + 1
    ours.run()
    assert slave.operational


def test_late_doubled_and_foreign_frames_are_left(bus: Callable[..., Any]) -> None:
    ours = bus().up()
    master = ours.master
    time = master.now_ns + 1_000_000
    ours.segment.advance(time)
    (old,) = master.transmit(time, 0)
    late = ours.segment.process(old)
    (new,) = master.transmit(time + 1, 0)
    reply = ours.segment.process(new)
    counters = master.cyclic.counters
    before = counters.late
    for packet in (late, reply, reply, reply[:40], reply[:12] + b"\x08\x00" + reply[14:]):
        master.receive(packet, time)
    assert counters.late == before + 4
    assert not master.cyclic._frames[0].away


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(at=st.integers(0, 200), value=st.integers(1, 255))
def test_one_changed_byte_changes_no_more_than_it_may(
    bus: Callable[..., Any], at: int, value: int
) -> None:
    """A frame whose headers are not ours is not taken; data are as they come."""
    ours = bus(2).up()
    master = ours.master
    (frame,) = master.transmit(master.now_ns + 1_000_000, 0)
    reply = bytearray(ours.segment.process(frame))
    reply[at % len(reply)] ^= value
    before = [bytes(each.inputs) for each in master.slaves]
    fresh = [each.fresh for each in master.image.datagrams]
    master.receive(bytes(reply), master.now_ns)
    if [each.fresh for each in master.image.datagrams] == fresh:
        assert [bytes(each.inputs) for each in master.slaves] == before
    ours.run(3)
    assert master.operational


def test_a_large_bus_takes_several_frames(bus: Callable[..., Any]) -> None:
    from achse.ethercat import Segment, Slave
    from achse.ethercat.master import Master, Ring

    line = [Loopback(8) for _ in range(120)]
    slaves = tuple(from_description(describe(each)) for each in line)
    ours = bus()
    ours.master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
    ours.segment = Segment(Slave(each) for each in line)
    ours.ring = Ring(ours.master, ours.segment, rounds=100)
    ours.up()
    ours.master.slaves[119].outputs[:] = b"the last"
    ours.run(2)
    assert bytes(ours.master.slaves[119].inputs) == b"the last"
    frames = ours.master.transmit(ours.master.now_ns + 1, 0)
    assert len(frames) == 2
    assert all(len(EthercatFrame.decode(each).encode()) <= 1514 for each in frames)


def exchange_of(*slaves: SlaveConfiguration, cycle_ns: int = 1_000_000) -> CyclicExchange:
    return CyclicExchange(ProcessImage(BusConfiguration(slaves, cycle_ns=cycle_ns)))


def back(frame: bytes, changes: Mapping[int, tuple[bytes, int]] | None = None) -> bytes:
    """The frame as it comes back: data and counter of each datagram by number."""
    datagrams = list(EthercatFrame.decode(frame).datagrams)
    for number, (data, counter) in (changes or {}).items():
        assert len(data) == len(datagrams[number].data)
        datagrams[number] = replace(datagrams[number], data=data, counter=counter)
    return EthercatFrame(datagrams).encode()


MAILBOX = from_description(describe(Loopback(4)))


# templates ---------------------------------------------------------------------------------------


def template() -> _Template:
    """Time, process data with two bytes of outputs, states, mailbox bits."""
    process = ProcessDatagram("", 0x0100_0000, DatagramCommand.LRW, [0], 5, 2, 0x0203)
    return _Template(
        [
            (Datagram(DatagramCommand.NOP, 0, bytes(8)), None),
            (Datagram(DatagramCommand.LRW, process.logical, b"\x55" * 5), process),
            (Datagram.at(DatagramCommand.BRD, 0, 0x0130, bytes(2)), None),
            (Datagram(DatagramCommand.LRD, MAILBOX_BITS, b"\0"), None),
        ]
    )


def headers(starts: Mapping[int, int], lengths: int = 12) -> set[int]:
    """Bytes that are compared: type, length, and of each header all but index and IRQ.

    Slaves count the position of a BRD up: `starts` has the first byte of the address that counts.
    """
    places = set(range(lengths, 16))
    for at, first in starts.items():
        places |= {at, *range(at + first, at + 8)}
    return places


WHOLE = {16: 2, 36: 2, 53: 4, 67: 2}
SHORT = {16: 2, 36: 2, 53: 4}


@pytest.mark.parametrize("is_short", [False, True])
def test_frame_that_comes_back_has_the_headers_that_were_sent(is_short: bool) -> None:
    frame = template()
    sent = frame.short(7) if is_short else frame.whole(7)
    datagrams = EthercatFrame.decode(sent).datagrams
    assert [each.command for each in datagrams] == [0, 12, 7, 10][: 3 if is_short else 4]
    assert datagrams[0].index == 7
    assert datagrams[1].data == b"\x55" * 5
    compared = headers(SHORT if is_short else WHOLE)
    for at in range(len(sent)):
        changed = bytearray(sent)
        changed[at] ^= 0x80
        same = frame.same(bytes(changed), int.from_bytes(changed, "little"))
        assert same is (at not in compared), at
    for packet, is_same in ((sent, True), (sent + b"\xff" * 40, True), (sent[:-1], False)):
        assert frame.same(packet, int.from_bytes(packet, "little")) is is_same


def test_short_frame_follows_a_changed_header() -> None:
    frame = template()
    frame.buffer[18:22] = b"\1\2\3\4"
    frame.renew()
    for make in (frame.short, frame.whole):
        sent = make(0)
        assert EthercatFrame.decode(sent).datagrams[0].address == 0x0403_0201
        assert frame.same(sent, int.from_bytes(sent, "little"))


def test_short_frame_keeps_the_lengths_of_its_datagrams() -> None:
    bits = Datagram(DatagramCommand.LRD, MAILBOX_BITS, b"\0")
    frame = _Template([(Datagram(DatagramCommand.LRD, 0, bytes(0x1FF)), None), (bits, None)])
    [datagram] = EthercatFrame.decode(frame.short(0)).datagrams
    assert len(datagram.data) == 0x1FF


def test_counters_of_process_data_are_compared_at_once() -> None:
    frame = template()
    sent = bytearray(frame.whole(0))
    for counter, is_right in ((0x0203, True), (0x0204, False), (0x0303, False), (0, False)):
        sent[51:53] = counter.to_bytes(2, "little")
        sent[-2:] = b"\xff\xff"
        assert frame.right(int.from_bytes(sent, "little")) is is_right


def test_inputs_are_behind_the_outputs_of_their_datagram() -> None:
    frame = template()
    assert frame.place(4) == 7
    memory = bytearray(b"." * 10)
    packet = bytearray(frame.whole(0))
    packet[46:51] = b"ABxyz"
    frame.take(bytes(packet), memory)
    assert memory == b"....xyz..."


# exchange ----------------------------------------------------------------------------------------


def test_outputs_go_out_and_inputs_come_in_by_slave() -> None:
    cyclic = exchange_of(box(8, 16, "a"), box(0, 8, "b"), box(16, 0, "a"), box(8, 8, "b"))
    assert (cyclic.present, cyclic.al_states, cyclic.reference_ns) == (0, 0, 0)
    assert (cyclic.mailbox_bits, cyclic.counters) == (b"", CyclicCounters())
    assert cyclic.frame_states == [0]
    assert len(cyclic._inputs) == 4
    for position, content in ((0, b"o"), (2, b"pq"), (3, b"r")):
        cyclic.outputs(position)[:] = content
    (frame,) = cyclic.frames()
    sent = EthercatFrame.decode(frame).datagrams
    assert [each.data for each in sent] == [b"opq\0\0", b"r\0\0", b"\0\0"]
    cyclic.receive(back(frame, {0: (b"opqxy", 5), 1: (b"rst", 4), 2: (b"\x08\0", 4)}))
    assert [bytes(cyclic.inputs(each)) for each in range(4)] == [b"xy", b"s", b"", b"t"]
    assert bytes(cyclic.outputs(1)) == bytes(cyclic.inputs(9)) == b""
    assert (cyclic.al_states, cyclic.present) == (8, 4)
    assert cyclic.inputs(0).readonly
    cyclic.exchanged(3)[:] = b"u"
    assert bytes(cyclic.inputs(3)) == b"u"
    assert bytes(cyclic.exchanged(2)) == b""


def test_inputs_with_a_wrong_counter_stay_and_cycles_are_counted() -> None:
    cyclic = exchange_of(box(0, 8, "a"), box(0, 8, "b"), cycle_ns=2_000_000)
    first, second = cyclic.image.datagrams
    seen: list[tuple[bytes, bool, bool, list[int]]] = []
    for one, other in ((1, 1), (1, 0), (0, 1), (2, 2), (1, 1)):
        (frame,) = cyclic.frames()
        letter = bytes([65 + len(seen)])
        cyclic.receive(back(frame, {0: (letter, one), 1: (letter.lower(), other)}))
        inputs = bytes(cyclic.inputs(0)) + bytes(cyclic.inputs(1))
        seen.append((inputs, first.valid, second.valid, cyclic.frame_states))
    assert seen == [
        (b"Aa", True, True, [0]),
        (b"Ba", True, False, [2]),
        (b"Bc", False, True, [1]),
        (b"Bc", False, False, [3]),
        (b"Ee", True, True, [0]),
    ]
    assert (first.fresh, first.wrong, second.fresh, second.wrong) == (3, 2, 3, 2)
    counters = cyclic.counters
    assert (counters.sent, counters.lost, counters.late, counters.wrong) == (5, 0, 0, 3)


def test_state_of_a_frame_has_15_bits() -> None:
    cyclic = exchange_of(*(box(0, 8, f"{number}") for number in range(17)))
    (frame,) = cyclic.frames()
    cyclic.receive(back(frame, dict.fromkeys(range(14), (b"x", 1))))
    assert cyclic.frame_states == [1 << 14]
    cyclic.frames()
    cyclic.frames()
    assert cyclic.frame_states == [1 << 15]


def test_lost_frame_makes_its_inputs_invalid() -> None:
    cyclic = exchange_of(box(0, 8))
    [process] = cyclic.image.datagrams
    assert not cyclic.away
    (frame,) = cyclic.frames()
    assert cyclic.away
    assert (cyclic.counters.lost, process.wrong) == (0, 0)
    cyclic.receive(back(frame, {0: (b"x", 1)}))
    assert (cyclic.away, process.valid) == (False, True)
    (late,) = cyclic.frames()
    cyclic.frames()
    assert (cyclic.counters.lost, process.wrong, process.valid) == (1, 1, False)
    cyclic.receive(back(late, {0: (b"y", 1)}))
    assert (cyclic.counters.late, bytes(cyclic.inputs(0)), cyclic.away) == (1, b"x", True)
    assert (process.fresh, cyclic.counters.sent) == (1, 3)


@pytest.mark.parametrize(("cycle_ns", "looks"), [(1_000_000, 5), (2_500_000, 2), (10_000_000, 1)])
def test_mailbox_states_travel_every_five_milliseconds(cycle_ns: int, looks: int) -> None:
    cyclic = exchange_of(MAILBOX, box(8, 8), MAILBOX, cycle_ns=cycle_ns)
    for cycle in range(1, 12):
        (frame,) = cyclic.frames()
        datagrams = EthercatFrame.decode(frame).datagrams
        has_bits = datagrams[-1].command == DatagramCommand.LRD
        assert has_bits is (cycle % looks == 0)
        states = len(datagrams) - 2 if has_bits else len(datagrams) - 1
        changes = {states: (b"\x18\0", 3)}
        if has_bits:
            changes[states + 1] = (bytes([cycle]), 2)
        cyclic.receive(back(frame, changes))
        assert not cyclic.away
        assert cyclic.take_mailbox_bits() == (bytes([cycle]) if has_bits else b"")
        assert cyclic.take_mailbox_bits() == b""
        assert (cyclic.al_states, cyclic.present) == (0x18, 3)
    assert cyclic.counters.late == 0


@pytest.mark.parametrize(("count", "size"), [(0, 0), (1, 1), (8, 1), (9, 2), (16, 2), (17, 3)])
def test_mailbox_states_have_a_bit_for_each_mailbox(count: int, size: int) -> None:
    cyclic = exchange_of(
        box(8, 0), *(replace(MAILBOX, outputs=(), inputs=()) for _ in range(count))
    )
    datagrams = [each for frame in cyclic._packed() for each, _ in frame]
    assert [each.command for each in datagrams] == [
        *(DatagramCommand.LWR, DatagramCommand.BRD),
        *([DatagramCommand.LRD] if count else []),
    ]
    assert len(datagrams[-1].data) == (size or 2)
    assert (datagrams[1].adp, datagrams[1].ado, len(datagrams[1].data)) == (0, 0x0130, 2)
    assert datagrams[0].address == 0x0100_0000


@pytest.mark.parametrize(("rest", "frames"), [(59, 1), (60, 1), (61, 2)])
def test_frame_has_1514_bytes_at_most(rest: int, frames: int) -> None:
    cyclic = exchange_of(box(8 * 1400, 0, "a"), box(8 * rest, 0, "b"))
    sent = cyclic.frames()
    assert len(sent) == frames
    assert len(sent[0]) == (1514 - 60 + rest if frames == 1 else 1514 - 14 + 1)
    for number, frame in enumerate(sent):
        datagrams = EthercatFrame.decode(frame).datagrams
        cyclic.receive(back(frame, {len(datagrams) - 1: (datagrams[-1].data, 1)}))
        assert (cyclic.present > 0) is (number == frames - 1)
    assert not cyclic.away


def test_frames_of_a_cycle_are_distinguished_by_their_index() -> None:
    cyclic = exchange_of(*(box(8 * 1400, 0, f"{number}") for number in range(3)))
    seen = []
    for cycle in range(1, 50):
        frames = cyclic.frames()
        indices = [EthercatFrame.decode(each).datagrams[0].index for each in frames]
        seen += indices
        assert indices == [(3 * cycle + number) % 0x80 for number in range(3)]
        for frame in reversed(frames):
            cyclic.receive(frame)
            cyclic.receive(frame)
        assert not cyclic.away
    assert (cyclic.counters.late, cyclic.counters.lost) == (3 * 49, 0)
    assert (min(seen), max(seen)) == (0, 0x7F)


def test_frame_with_other_headers_is_late_and_the_right_one_is_waited_for() -> None:
    cyclic = exchange_of(box(0, 8))
    (frame,) = cyclic.frames()
    for at in (12, 14, 16, 18, 22):
        other = bytearray(back(frame, {0: (b"x", 1)}))
        other[at] ^= 1
        cyclic.receive(bytes(other))
    assert (cyclic.counters.late, cyclic.away, bytes(cyclic.inputs(0))) == (5, True, b"\0")
    cyclic.receive(back(frame, {0: (b"y", 1)}))
    assert (cyclic.counters.late, cyclic.away, bytes(cyclic.inputs(0))) == (5, False, b"y")


@pytest.mark.parametrize("is_large", [False, True])
def test_mailbox_states_that_are_not_taken_stay_until_the_next_look(is_large: bool) -> None:
    others = [box(8 * 1400, 0, "a"), box(8 * 80, 0, "b")] if is_large else [box(8, 0)]
    cyclic = exchange_of(*others, replace(MAILBOX, outputs=(), inputs=()))
    seen = []
    for cycle in range(1, 12):
        frames = cyclic.frames()
        assert len(frames) == 1 + is_large
        for number, frame in reversed(list(enumerate(frames))):
            datagrams = EthercatFrame.decode(frame).datagrams
            changes = {0: (b"\xaa" * len(datagrams[0].data), 1)}
            if number == is_large and cycle % 5 == 0:
                changes[len(datagrams) - 1] = (bytes([cycle]), 1)
            cyclic.receive(back(frame, changes))
        seen.append(cyclic.mailbox_bits)
    assert seen == [b""] * 4 + [b"\5"] * 5 + [b"\x0a"] * 2


def test_states_travel_without_mailbox_states_between_looks() -> None:
    cyclic = exchange_of(replace(MAILBOX, outputs=(), inputs=()))
    counts = [
        [len(EthercatFrame.decode(frame).datagrams) for frame in cyclic.frames()] for _ in range(6)
    ]
    assert counts == [[1], [1], [1], [1], [2], [1]]


def test_mailbox_states_alone_in_a_frame_are_left_out_between_looks() -> None:
    mailbox = replace(MAILBOX, outputs=(), inputs=())
    cyclic = exchange_of(box(8 * 1400, 0, "a"), box(8 * 60, 0, "b"), mailbox)
    counts = []
    for _ in range(5):
        frames = cyclic.frames()
        counts.append(len(frames))
        for frame in frames:
            cyclic.receive(frame)
        assert not cyclic.away
    assert counts == [1, 1, 1, 1, 2]
    assert (cyclic.counters.sent, cyclic.counters.late, cyclic.counters.lost) == (6, 0, 0)


def test_time_of_the_reference_clock_is_taken_if_a_slave_wrote_it() -> None:
    cyclic = exchange_of(box(8, 0, clock=ClockConfiguration()))
    first = EthercatFrame.decode(cyclic.frames()[0]).datagrams[0]
    assert (first.command, first.address, first.data) == (DatagramCommand.NOP, 0, bytes(8))
    time = (1 << 63 | 5).to_bytes(8, "little")
    for station, data, counter, expected in (
        (None, time, 0, 0),
        (0x1002, time, 0, 0),
        (0x1002, time, 1, 1 << 63 | 5),
        (0x1002, bytes(8), 0, 1 << 63 | 5),
        (0x1002, b"\7" + bytes(7), 0x100, 7),
    ):
        cyclic.set_reference(station)
        (frame,) = cyclic.frames()
        first = EthercatFrame.decode(frame).datagrams[0]
        is_known = station is not None
        assert first.command == (DatagramCommand.FRMW if is_known else DatagramCommand.NOP)
        assert (first.adp, first.ado, len(first.data)) == (station or 0, 0x0910, 8)
        cyclic.receive(back(frame, {0: (data, counter)}))
        assert (cyclic.reference_ns, cyclic.away) == (expected, False)
        assert cyclic.reference_lost is (is_known and not counter)
        first = EthercatFrame.decode(cyclic.frames()[0]).datagrams[0]
        carries = is_known and counter
        assert first.command == (DatagramCommand.FRMW if carries else DatagramCommand.NOP)
    without = exchange_of(box(8, 0))
    without.set_reference(0x1002)
    assert len(EthercatFrame.decode(without.frames()[0]).datagrams) == 2


def test_time_is_in_the_first_frame_only() -> None:
    large = [box(8 * 1400, 0, f"{number}") for number in range(2)]
    cyclic = exchange_of(*large, box(8, 0, clock=ClockConfiguration()))
    cyclic.set_reference(0x1001)
    first, second = cyclic.frames()
    cyclic.receive(back(second, {0: (b"\7" * 1400, 1)}))
    assert cyclic.reference_ns == 0
    cyclic.receive(back(first, {0: (b"\7" * 8, 1)}))
    assert cyclic.reference_ns == int.from_bytes(b"\7" * 8, "little")


def test_skipped_cycles_count_as_valid_ones() -> None:
    cyclic = exchange_of(box(8, 8, "a"), box(8, 0, "b", clock=ClockConfiguration()))
    cyclic.skip(3, 500)
    assert (cyclic.reference_ns, cyclic.counters.sent) == (0, 3)
    cyclic.reference_ns = 10
    cyclic.skip(4, 500)
    assert (cyclic.reference_ns, cyclic.counters.sent) == (510, 7)
    assert [each.fresh for each in cyclic.image.datagrams] == [7, 7]
    (frame,) = cyclic.frames()
    assert EthercatFrame.decode(frame).datagrams[0].index == 8


def test_slaves_that_share_a_byte_have_bits_of_their_own() -> None:
    cyclic = exchange_of(*(box(bits, bits, packed=True) for bits in (3, 2, 1)))
    for position, value in enumerate((0xFF, 0x02, 0x01)):
        cyclic.outputs(position)[0] = value
    (frame,) = cyclic.frames()
    assert EthercatFrame.decode(frame).datagrams[0].data == b"\x37\0"
    cyclic.receive(back(frame, {0: (b"\x37\xed", 9)}))
    assert [cyclic.inputs(position)[0] for position in range(3)] == [5, 1, 1]
    cyclic.outputs(0)[0] = 0
    (frame,) = cyclic.frames()
    assert EthercatFrame.decode(frame).datagrams[0].data == b"\x30\0"
