"""Frames by their plan do what they do datagram by datagram."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Segment, Slave
from achse.ethercat.fmmu import Fmmu
from achse.ethercat.frame_plan import (
    FramePlan,
    PlannedDatagram,
    exchange,
    gather_registers,
)

C = DatagramCommand
STATION, INPUTS, MAILBOXES = 0x1001, 0x100, 0x200
SM1_STATUS, FULL = 0x080D, 3
AL_CONTROL, AL_STATUS, EVENT_MASK, SYSTEM_TIME = 0x0120, 0x0130, 0x0200, 0x0910
MOST = 4


class EachByItself(Segment):
    """Looks at every datagram of every frame."""

    def _plan_frame(self, frame: bytes, start: int, offsets: Sequence[int]) -> None:
        """Plan nothing."""


def datagrams(count: int) -> st.SearchStrategy[Datagram]:
    """Of process data, their parts, registers; some change states or the mapping."""
    size = 4 * count
    station = st.integers(STATION, STATION + count)
    logical = st.builds(
        lambda command, address, data, index: Datagram(command, address, data, index),
        st.sampled_from([C.LRD, C.LWR, C.LRW]),
        st.sampled_from([0, 4, INPUTS, INPUTS + 4, MAILBOXES]),
        st.sampled_from([1, 4, size, INPUTS + size]).flatmap(
            lambda length: st.binary(min_size=length, max_size=length)
        ),
        st.integers(0, 255),
    )
    registers = st.builds(
        lambda command, who, at, data: Datagram.at(command, who, at, data),
        st.sampled_from([C.BRD, C.FPRD, C.APRD, C.FRMW, C.NOP]),
        st.one_of(st.just(0), station),
        st.sampled_from([AL_STATUS, SM1_STATUS, SYSTEM_TIME, 0x0300]),
        st.sampled_from([bytes(1), bytes(2), bytes(8), b"\x80\x01"]),
    )
    changes = st.builds(
        lambda who, change: Datagram.at(C.FPWR, who, *change),
        station,
        st.sampled_from(
            [
                *((AL_CONTROL, bytes((state, 0))) for state in (1, 2, 4, 8, 0x14)),
                (EVENT_MASK, b"\xff\xff"),
                (EVENT_MASK, b"\0\0"),
                (0x060C, b"\0"),
                (0x060C, b"\1"),
                (0x0816, b"\0"),
            ]
        ),
    )
    return st.one_of(logical, logical, registers, changes)


@st.composite
def sessions(draw: st.DrawFn) -> tuple[int, list[list[Datagram]]]:
    """How many slaves, and a few frames in any order, most of them again and again."""
    count = draw(st.integers(1, MOST))
    kinds = draw(
        st.lists(st.lists(datagrams(count), min_size=1, max_size=5), min_size=1, max_size=4)
    )
    turns = draw(st.lists(st.integers(0, len(kinds) - 1), min_size=2, max_size=12))
    return count, [kinds[turn] for turn in turns]


def in_op(kind: type[Segment], count: int, bring: Callable[[Any], None], cycle_ns: int) -> Segment:
    segment = kind((Slave(Loopback(serial_number=n)) for n in range(count)), cycle_ns=cycle_ns)
    bring(segment)
    for position in range(count):
        place = MAILBOXES + (position >> 3)
        flag = Fmmu(place, 1, position & 7, position & 7, SM1_STATUS, FULL, 1, 1)
        segment.slaves[position].esc.write(0x0620, flag.encode())
    return segment


@settings(max_examples=12)
@given(sessions(), st.sampled_from([0, 1_000_000]), st.data())
def test_planned_frames_come_back_the_same(
    bring: Callable[[Any], None],
    session: tuple[int, list[list[Datagram]]],
    cycle_ns: int,
    data: st.DataObject,
) -> None:
    count, frames = session
    planned, other = (in_op(kind, count, bring, cycle_ns) for kind in (Segment, EachByItself))
    for number, frame in enumerate(frames):
        packet = bytearray(EthercatFrame(frame).encode())
        if data.draw(st.integers(0, 9)) == 0:  # a counter that is not 0, or another header
            packet[data.draw(st.integers(14, len(packet) - 1))] ^= data.draw(st.integers(1, 255))
        fault = data.draw(st.sampled_from([None] * 6 + ["emergency", "cable", "mended"]))
        for segment in (planned, other):
            if fault == "emergency":
                segment.slaves[-1].application.emergencies.append(bytes(8))  # type: ignore[attr-defined]
            elif fault == "cable":
                segment.break_link(segment.slaves[-1])
            elif fault == "mended":
                segment.repair_link(segment.slaves[-1])
            segment.advance(number * 1_000_000)
        assert planned.process(bytes(packet)) == other.process(bytes(packet))
    for one, two in zip(planned.slaves, other.slaves, strict=True):
        assert one.esc.memory == two.esc.memory
        assert one.application.read_inputs() == two.application.read_inputs()


@pytest.fixture(scope="module")
def bring() -> Callable[[Any], None]:
    """Brings all slaves of a segment to Op."""
    from tests.ethercat.conftest import Master

    return lambda segment: Master(segment).bring(AlState.OP)


def test_planned_read_of_registers_ends_their_event(bring: Callable[[Any], None]) -> None:
    planned, other = (in_op(kind, 2, bring, 0) for kind in (Segment, EachByItself))
    look = EthercatFrame([Datagram.at(C.BRD, 0, AL_STATUS, bytes(2))]).encode()
    change = EthercatFrame([Datagram.at(C.FPWR, STATION, AL_CONTROL, b"\4\0")]).encode()
    mask = EthercatFrame([Datagram.at(C.FPWR, STATION, EVENT_MASK, b"\xff\xff")]).encode()
    session = [look, mask, look, look, change, look, look]
    assert [planned.process(each) for each in session] == [other.process(each) for each in session]
    assert planned.slaves[0].esc.memory == other.slaves[0].esc.memory
    assert planned.slaves[0].esc.events == other.slaves[0].esc.events


def test_a_known_frame_is_not_taken_apart(
    bring: Callable[[Any], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    segment = in_op(Segment, 2, bring, 0)
    cyclic = [
        Datagram(C.LRW, 0, bytes(8), 1),
        Datagram(C.LRW, INPUTS, bytes(8)),
        Datagram.at(C.BRD, 0, AL_STATUS, bytes(2)),
        Datagram(C.LRD, MAILBOXES, bytes(1)),
    ]
    segment.process(EthercatFrame(cyclic).encode())

    def refuse(*_: object) -> list[int]:
        raise AssertionError("taken apart")

    with monkeypatch.context() as patch:
        patch.setattr("achse.ethercat.segment.datagram_offsets", refuse)
        segment.slaves[1].application.emergencies.append(bytes(8))  # type: ignore[attr-defined]
        cyclic[0] = Datagram(C.LRW, 0, b"abcdefgh", 77)
        reply = segment.process(EthercatFrame(cyclic).encode())
    assert reply is not None
    came = EthercatFrame.decode(reply).datagrams
    assert [each.counter for each in came] == [4, 2, 2, 2]
    assert came[0].index == 77
    assert came[2].data == b"\x08\x00"
    assert came[3].data == b"\x02"


@pytest.mark.parametrize("start", [0, 14])
@pytest.mark.parametrize("counts", [(True, True), (True, False), (False, True)])
def test_plan_fits_frames_with_the_same_headers(start: int, counts: tuple[bool, bool]) -> None:
    """Length of the frame; commands, addresses, lengths; counters that have to be 0."""
    frame = bytes(range(1, start + 34))
    datagrams = [
        PlannedDatagram(start + offset, length, each)
        for offset, length, each in zip((2, 18), (4, 3), counts, strict=True)
    ]
    plan = FramePlan(frame, start, datagrams, [])
    compared = {start, start + 1}
    for datagram in datagrams:
        compared |= {datagram.offset, *range(datagram.offset + 2, datagram.offset + 8)}
        if datagram.counts:
            end = datagram.offset + 10 + datagram.length
            compared |= {end, end + 1}
    assert plan.fits(frame)
    for at in range(len(frame)):
        changed = bytearray(frame)
        changed[at] ^= 0x80
        assert plan.fits(bytes(changed)) is (at not in compared), at


def test_planned_exchange_touches_nothing_else() -> None:
    """Outputs, one input, a run of inputs and flags; a counter of 0 stays what it was."""
    frame = bytes(range(100))
    taken: list[bytes] = []

    def plan(**parts: Any) -> Any:
        empty: dict[str, Any] = {
            "takes": [],
            "gives": [],
            "flags": [],
            "span": None,
            "count": 0,
            "look": None,
        }
        return SimpleNamespace(**empty | parts)

    step = exchange(
        [
            (PlannedDatagram(0, 6, True), plan(takes=[(taken.append, slice(1, 3))], count=3)),
            (
                PlannedDatagram(18, 6, True),
                plan(gives=[(lambda: b"in", slice(2, 4))], span=slice(2, 4), count=0x102),
            ),
            (
                PlannedDatagram(36, 6, True),
                plan(
                    gives=[(lambda: b"ab", slice(1, 3)), (lambda: b"cd", slice(3, 5))],
                    span=slice(1, 5),
                ),
            ),
            (
                PlannedDatagram(54, 6, True),
                plan(gives=[(lambda: b"x", slice(0, 1)), (lambda: b"y", slice(5, 6))]),
            ),
            (
                PlannedDatagram(72, 6, True),
                plan(flags=[1], look=lambda data: bytes(each ^ 0xFF for each in data)),
            ),
        ]
    )
    buffer = bytearray(frame)
    step(frame, buffer)
    assert taken == [frame[11:13]]
    expected = bytearray(frame)
    expected[16:18], expected[34:36] = b"\3\0", b"\2\1"
    expected[30:32], expected[47:51] = b"in", b"abcd"
    expected[64], expected[69] = b"xy"
    expected[82:88] = bytes(each ^ 0xFF for each in frame[82:88])
    assert buffer == expected


@pytest.mark.parametrize("length", [1, 2, 4, 8])
@pytest.mark.parametrize("position", [0, 0xFFFF])
def test_gathered_registers_are_those_of_all_slaves(length: int, position: int) -> None:
    """Slaves with an event are read, which ends it."""
    reads: list[tuple[int, int, int]] = []

    def slave(number: int, events: int) -> Any:
        memory = bytearray(32)
        memory[8 : 8 + length] = bytes([1 << number] * length)
        read = lambda address, size: reads.append((number, address, size))  # noqa: E731
        return SimpleNamespace(memory=memory, events=events, read=read)

    escs = [slave(number, events) for number, events in enumerate((0, 4, 0))]
    datagram = PlannedDatagram(4, length, True)
    buffer = bytearray(b"\x40" * 40)
    gather_registers(datagram, escs, 8, position)(b"", buffer)
    assert reads == [(1, 8, length)]
    expected = bytearray(b"\x40" * 40)
    expected[6:8] = ((position + 3) & 0xFFFF).to_bytes(2, "little")
    expected[14 : 14 + length] = bytes([0x47] * length)
    expected[14 + length : 16 + length] = b"\3\0"
    assert buffer == expected
