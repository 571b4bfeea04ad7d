"""Segments: every command, every working counter, topology, broken frames."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import (
    Datagram,
    DatagramCommand,
    Disturbance,
    EthercatFrame,
    Loopback,
    Segment,
    Slave,
)

STATION = 0x1001
RAM = 0x2000
C = DatagramCommand


@pytest.fixture
def three(line: Callable[..., Any]) -> Any:
    """Three slaves with station addresses and 'A', 'B', 'D' (one bit each) at 0x2000."""
    master = line(3)
    master.address()
    for slave, value in zip(master.segment.slaves, b"\x01\x02\x04", strict=True):
        slave.esc.write(RAM, bytes((value,)))
    return master


def memory(master: Any) -> list[int]:
    return [(slave.esc.read(RAM, 1) or b"")[0] for slave in master.segment.slaves]


@pytest.mark.parametrize(
    ("command", "adp", "data", "counter", "after", "adp_after"),
    [
        # the addressed slave is the second; memory before is 1, 2, 4, the datagram holds 0x80
        (C.NOP, 0x1234, 0x80, 0, [1, 2, 4], 0x1234),
        (C.APRD, 0xFFFF, 0x02, 1, [1, 2, 4], 2),
        (C.APWR, 0xFFFF, 0x80, 1, [1, 0x80, 4], 2),
        (C.APRW, 0xFFFF, 0x02, 3, [1, 0x80, 4], 2),
        (C.FPRD, 0x1002, 0x02, 1, [1, 2, 4], 0x1002),
        (C.FPWR, 0x1002, 0x80, 1, [1, 0x80, 4], 0x1002),
        (C.FPRW, 0x1002, 0x02, 3, [1, 0x80, 4], 0x1002),
        (C.BRD, 0, 0x87, 3, [1, 2, 4], 3),
        (C.BWR, 0, 0x80, 3, [0x80, 0x80, 0x80], 3),
        (C.BRW, 0, 0x87, 9, [0x80, 0x81, 0x83], 3),
        (C.ARMW, 0xFFFF, 0x02, 3, [0x80, 2, 2], 2),
        (C.FRMW, 0x1002, 0x02, 3, [0x80, 2, 2], 0x1002),
        # nobody is addressed
        (C.APRD, 3, 0x80, 0, [1, 2, 4], 6),
        (C.FPWR, 0x1009, 0x80, 0, [1, 2, 4], 0x1009),
        (C.ARMW, 0x0005, 0x80, 3, [0x80, 0x80, 0x80], 8),
        # commands that do not exist
        (15, 0x1002, 0x80, 0, [1, 2, 4], 0x1002),
        (255, 0x1002, 0x80, 0, [1, 2, 4], 0x1002),
    ],
)
def test_each_command(
    three: Any,
    command: int,
    adp: int,
    data: int,
    counter: int,
    after: list[int],
    adp_after: int,
) -> None:
    (reply,) = three.send(Datagram(command, adp | RAM << 16, b"\x80", index=9))
    assert (reply.data[0], reply.counter, reply.adp, reply.ado) == (data, counter, adp_after, RAM)
    assert reply.index == 9
    assert memory(three) == after


@pytest.mark.parametrize(
    ("command", "counter"), [(C.FPRD, 0), (C.FPWR, 0), (C.FPRW, 0), (C.BRD, 0), (C.BRW, 0)]
)
def test_a_refused_access_leaves_data_and_counter(three: Any, command: C, counter: int) -> None:
    """There is no memory at 0x8000."""
    (reply,) = three.send(Datagram.at(command, 0x1002, 0x8000, b"\x55"))
    assert (reply.data, reply.counter) == (b"\x55", counter)


def test_read_write_of_a_read_only_register_reads(three: Any) -> None:
    assert three.one(C.FPRW, 0x1001, 0x0000, b"\x55").counter == 1


def test_counters_are_added_to_and_wrap(three: Any) -> None:
    reply = three.send(Datagram(C.BRD, RAM << 16, b"\0", counter=0xFFFE))[0]
    assert reply.counter == 1


def test_slaves_of_the_same_address_all_answer(three: Any) -> None:
    three.one(C.BWR, 0, 0x0010, b"\x05\x00")
    assert three.one(C.FPRD, 5, 0, b"\0").counter == 3


def test_several_datagrams_in_one_frame_act_in_order(three: Any) -> None:
    replies = three.send(
        Datagram.at(C.FPRD, 0x1001, RAM, b"\0"),
        Datagram.at(C.FPWR, 0x1001, RAM, b"\x42"),
        Datagram.at(C.FPRD, 0x1001, RAM, b"\0"),
        Datagram.at(C.NOP, 0x7777, 0x1234, b"tag"),
    )
    assert [reply.data for reply in replies] == [b"\x01", b"\x42", b"\x42", b"tag"]
    assert [reply.counter for reply in replies] == [1, 1, 1, 0]


# frames that are none


@pytest.mark.parametrize(
    "packet",
    [
        b"",
        bytes(14),
        b"\xff" * 12 + b"\x08\x06" + bytes(46),
    ],
)
def test_other_protocols_pass_unless_they_are_to_be_destroyed(three: Any, packet: bytes) -> None:
    segment = three.segment
    assert segment.process(packet) is None  # DL control bit 0 is set at power-up
    three.one(C.BWR, 0, 0x0100, b"\x00")
    assert segment.process(packet) == packet
    assert segment.counters.foreign == 2


@given(st.binary(max_size=80))
def test_malformed_frames_come_back_untouched_and_are_counted(payload: bytes) -> None:
    segment = Segment([Slave(Loopback())])
    packet = b"\xff" * 12 + b"\x88\xa4" + payload
    before = bytes(segment.slaves[0].esc.memory[0x1000:])
    reply = segment.process(packet)
    if segment.counters.malformed:
        assert reply == packet
        assert segment.slaves[0].esc.read(0x030C, 1) == b"\x01"
        assert bytes(segment.slaves[0].esc.memory[0x1000:]) == before
    else:
        assert reply is not None
        assert len(reply) == len(packet)


def test_a_frame_of_another_type_passes(three: Any) -> None:
    packet = b"\xff" * 12 + b"\x88\xa4" + b"\x10\x40" + bytes(16)
    assert three.segment.process(packet) == packet[:6] + b"\xff" + packet[7:]
    assert three.segment.counters.malformed == 0


def test_the_source_address_is_marked_on_the_way_back(three: Any) -> None:
    frame = EthercatFrame([Datagram(C.NOP, 0, b"")], source=bytes.fromhex("101112131415")).encode()
    reply = three.segment.process(frame)
    assert reply[6:12] == bytes.fromhex("121112131415")
    assert (reply[:6], reply[12:]) == (frame[:6], frame[12:])


def test_padding_and_vlan_tag_stay(three: Any) -> None:
    frame = EthercatFrame([Datagram.at(C.BRD, 0, 0, bytes(1))]).encode()
    tagged = (frame[:12] + b"\x81\x00\x20\x05" + frame[12:]).ljust(64, b"\xaa")
    reply = three.segment.process(tagged)
    assert len(reply) == 64
    assert reply[12:16] == tagged[12:16]
    assert reply[-20:] == b"\xaa" * 20
    assert EthercatFrame.decode(reply).datagrams[0].counter == 3


def test_udp_payloads(three: Any) -> None:
    payload = EthercatFrame([Datagram.at(C.BRD, 0, 0, bytes(1))]).encode_payload()
    reply = three.segment.process_payload(payload)
    assert EthercatFrame.decode_payload(reply).datagrams[0].counter == 3


# topology


def status(slave: Slave) -> int:
    return int.from_bytes(slave.esc.memory[0x0110:0x0112], "little")


def test_dl_status_shows_the_line(three: Any) -> None:
    """Middle slaves have ports 0 and 1 open with communication, the last only port 0."""
    assert [status(slave) for slave in three.segment.slaves] == [0x5A33, 0x5A33, 0x5613]


def test_an_empty_segment_returns_nothing() -> None:
    segment = Segment()
    assert segment.process(EthercatFrame([Datagram(C.NOP, 0, b"")]).encode()) is None
    assert segment.counters.lost == 1


def test_branches_are_passed_in_the_order_of_their_ports() -> None:
    """A frame leaves by ports 3, 1, 2 in this order."""
    slaves = {name: Slave(Loopback()) for name in ("root", "one", "two", "three", "behind three")}
    segment = Segment([slaves["root"]])
    segment.attach(slaves["one"], slaves["root"], 1)
    segment.attach(slaves["two"], slaves["root"], 2)
    segment.attach(slaves["three"], slaves["root"], 3)
    segment.attach(slaves["behind three"], slaves["three"], 1)
    names = {id(slave): name for name, slave in slaves.items()}
    order = [names[id(slave)] for slave in segment.reachable]
    assert order == ["root", "three", "behind three", "one", "two"]
    assert status(slaves["root"]) == 0xAAF3
    times: list[Any] = [slave.esc.clock.port_delays for slave in segment.reachable]
    root, third, _, first, second = times
    assert root[0] < third[0] < third[1] < root[3] < first[0] < root[1] < second[0] < root[2]


def test_a_port_has_one_cable() -> None:
    slaves = [Slave(Loopback()) for _ in range(3)]
    segment = Segment(slaves[:2])
    with pytest.raises(ValueError, match="once"):
        segment.attach(slaves[0])
    with pytest.raises(ValueError, match="port 1"):
        segment.attach(slaves[2], slaves[0], 1)
    with pytest.raises(ValueError, match="port 0"):
        segment.attach(slaves[2], slaves[0], 0)
    with pytest.raises(ValueError, match="not in this segment"):
        segment.break_link(slaves[2])


def test_a_broken_link_hides_what_is_behind_until_it_is_mended(three: Any) -> None:
    segment = three.segment
    first, second, third = segment.slaves
    three.read(0x0110, 2)
    segment.break_link(second)
    segment.break_link(second)
    assert segment.reachable == (first,)
    assert three.one(C.BRD, 0, 0, b"\0").counter == 1
    assert status(first) == 0x5613
    assert three.number(0x0310, 2) == 0x0100  # lost link at port 1, once
    assert three.number(0x0210, 2) & 0x04
    segment.repair_link(second)
    assert segment.reachable == (first, second, third)
    assert three.one(C.FPRD, 0x1003, RAM, b"\0").data == b"\x04"


def test_the_cable_to_the_master_can_break(three: Any) -> None:
    first = three.segment.slaves[0]
    three.segment.break_link(first)
    assert three.segment.process(EthercatFrame([Datagram(C.NOP, 0, b"")]).encode()) is None
    three.segment.repair_link(first)
    assert three.one(C.BRD, 0, 0, b"\0").counter == 3


def test_the_master_closes_and_opens_a_port(three: Any) -> None:
    three.write(0x0101, b"\x0c")  # port 1 closed
    assert len(three.segment.reachable) == 1
    three.write(0x0101, b"\x00")
    assert len(three.segment.reachable) == 3
    three.write(0x0101, b"\x08", 0x1003)  # port 1 of the last slave always open: into the void
    assert three.segment.process(EthercatFrame([Datagram(C.NOP, 0, b"")]).encode()) is None


def test_a_frame_that_does_not_come_back_has_passed_the_slaves_before(three: Any) -> None:
    """A master can undo what it held open, though it sees no answer; before, nothing could."""
    void = EthercatFrame(
        [Datagram.at(C.FPWR, 0x1002, 0x0101, b"\x20")]
    ).encode()  # port 2, without link
    assert three.segment.process(void) is not None
    assert three.segment.reachable == three.segment.slaves
    again = EthercatFrame([Datagram.at(C.FPWR, 0x1002, 0x0101, b"\x00")]).encode()
    assert three.segment.process(again) is None
    assert three.one(C.BRD, 0, 0, b"\0").counter == 3


def test_what_is_lost_passes_no_slave_behind_the_open_port(three: Any) -> None:
    three.segment.process(EthercatFrame([Datagram.at(C.FPWR, 0x1001, 0x0101, b"\x80")]).encode())
    assert three.segment.reachable == three.segment.slaves[:1], "port 3 comes before port 1"
    write = EthercatFrame([Datagram.at(C.BWR, 0, RAM, b"\x7f")]).encode()
    assert three.segment.process(write) is None
    assert memory(three) == [0x7F, 2, 4]


@given(
    st.lists(st.tuples(st.integers(0, 2), st.integers(0, 255)), max_size=8),
    st.sampled_from([C.APWR, C.BWR]),
)
def test_whatever_dl_control_does_the_link_opens_the_segment(
    writes: list[tuple[int, int]], command: DatagramCommand
) -> None:
    """Any loop control of any slave in any order; then the cable to the master is pulled."""
    segment = Segment(Slave(Loopback()) for _ in range(3))
    for position, control in writes:
        frame = EthercatFrame([Datagram.at(command, -position & 0xFFFF, 0x0101, bytes((control,)))])
        segment.process(frame.encode())
    segment.break_link(segment.slaves[0])
    segment.repair_link(segment.slaves[0])
    reply = segment.process(EthercatFrame([Datagram.at(C.BRD, 0, 0, b"\0")]).encode())
    assert reply is not None
    assert EthercatFrame.decode(reply).datagrams[0].counter == 3


def test_a_mended_cable_opens_its_own_ports_only(three: Any) -> None:
    first, second, third = three.segment.slaves
    for slave in (first, second):
        slave.esc.write(0x0101, b"\xcc")  # ports 1 and 3 closed
    three.segment.break_link(third)
    three.segment.repair_link(third)
    controls = [slave.esc.look(0x0101, 1)[0] for slave in (first, second)]
    assert controls == [0xCC, 0xC0]


def test_time_goes_on_behind_a_broken_link(line: Callable[..., Any]) -> None:
    master = line(2)
    master.bring(AlState.OP)
    master.segment.break_link(master.segment.slaves[1])
    for _ in range(150):
        master.advance(1)
        master.exchange(bytes(8))
    assert [slave.state for slave in master.segment.slaves] == [AlState.OP, AlState.SAFEOP]


# disturbances, clock of frames


def test_lost_frames(three: Any) -> None:
    three.segment.disturbance = Disturbance(lose=2)
    frame = EthercatFrame([Datagram.at(C.BWR, 0, RAM, b"\x33")]).encode()
    assert three.segment.process(frame) is None
    assert three.segment.process(frame) is None
    assert three.segment.process(frame) is not None
    assert memory(three) == [0x33] * 3  # the slaves saw it
    assert three.segment.counters.lost == 2


def test_wrong_working_counters(three: Any) -> None:
    three.segment.disturbance = Disturbance(counter=-1, counter_frames=1)
    datagrams = [Datagram.at(C.BRD, 0, 0, b"\0"), Datagram.at(C.BRD, 0, 0, b"\0\0")]
    assert [reply.counter for reply in three.send(*datagrams)] == [2, 2]
    assert [reply.counter for reply in three.send(*datagrams)] == [3, 3]


def test_frames_with_process_data_are_the_clock(line: Callable[..., Any]) -> None:
    master = line(2, cycle_ns=1_000_000)
    master.bring(AlState.OP)
    now = master.segment.time.now_ns
    for _ in range(10):
        master.exchange(bytes(8))  # two logical datagrams, one cycle
    master.read(0x0130, 2)
    assert master.segment.time.now_ns - now == 10_000_000
