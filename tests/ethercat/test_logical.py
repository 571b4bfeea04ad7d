"""Logical datagrams: whole buffers, bits, overlaps, registers."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Datagram, DatagramCommand, Loopback, Slave
from achse.ethercat.esc import Esc
from achse.ethercat.fmmu import Fmmu
from achse.ethercat.logical import Plan
from tests.ethercat.conftest import sync_manager

INPUTS = 0x100
C = DatagramCommand


@pytest.fixture
def two(line: Callable[..., Any]) -> Any:
    master = line(2)
    master.bring(AlState.OP)
    return master


@pytest.mark.parametrize(
    ("command", "address", "length", "counter"),
    [
        (C.LWR, 0, 8, 2),
        (C.LWR, 0, 4, 1),
        (C.LRD, INPUTS, 8, 2),
        (C.LRD, 0, 8, 0),
        (C.LWR, INPUTS, 8, 0),
        (C.LRW, 0, 8, 4),
        (C.LRW, INPUTS, 8, 2),
        (C.LRW, 0, INPUTS + 8, 6),
        (C.LRW, 0x1000, 8, 0),
        (C.LRW, 0xFFFFFFF8, 8, 0),
    ],
)
def test_working_counters(two: Any, command: C, address: int, length: int, counter: int) -> None:
    (reply,) = two.send(Datagram(command, address, b"\x55" * length))
    assert reply.counter == counter


def test_outputs_become_inputs_a_cycle_later(two: Any) -> None:
    assert two.exchange(b"abcdefgh") == (bytes(8), 4)
    two.advance(1)
    assert two.exchange(b"ijklmnop") == (b"abcdefgh", 4)


def test_unmapped_bytes_stay(two: Any) -> None:
    (reply,) = two.send(Datagram(C.LRD, INPUTS - 2, b"\x77" * 12))
    assert reply.data == b"\x77\x77" + bytes(8) + b"\x77\x77"


def test_half_a_buffer(two: Any) -> None:
    """The first half waits; the last byte makes the buffer complete."""
    assert two.send(Datagram(C.LWR, 0, b"ab"))[0].counter == 1
    two.advance(1)
    assert two.send(Datagram(C.LRD, INPUTS, bytes(4)))[0].data == bytes(4)
    two.send(Datagram(C.LWR, 2, b"cd"))
    two.advance(1)
    assert two.send(Datagram(C.LRD, INPUTS, bytes(2)))[0].data == b"ab"
    assert two.send(Datagram(C.LRD, INPUTS + 2, bytes(2)))[0].data == b"cd"


def overlapping(master: Any, inputs: int) -> None:
    """Move the inputs' FMMUs to the logical address `inputs`."""
    for n in range(2):
        master.write(0x0610, (inputs + 4 * n).to_bytes(4, "little"), 0x1001 + n)


def test_inputs_may_lie_over_the_outputs_of_the_same_slave(two: Any) -> None:
    overlapping(two, 0)
    two.send(Datagram(C.LRW, 0, b"abcdefgh"))
    two.advance(1)
    (reply,) = two.send(Datagram(C.LRW, 0, b"ijklmnop"))
    assert (reply.data, reply.counter) == (b"abcdefgh", 6)


def test_a_slave_takes_what_the_one_before_gave(two: Any) -> None:
    """Inputs of the first lie over outputs of the second."""
    overlapping(two, 4)
    two.send(Datagram(C.LRW, 0, b"abcdefgh"))
    two.advance(1)
    two.send(Datagram(C.LRW, 0, b"ijklmnop"))
    assert [each.read_object(0x7000, 1) for each in two.line] == [b"i", b"a"]


def test_a_register_can_be_mapped(two: Any) -> None:
    """Some masters map SM1's status to see in every cycle whether a message waits."""
    two.write(0x0620, Fmmu(0x200, 1, 0, 7, 0x080D, 0, 1, 1).encode())
    assert two.send(Datagram(C.LRD, 0x200, b"\0"))[0].data[0] & 0x08 == 0
    two.line[0].emergencies.append(bytes(8))
    (reply,) = two.send(Datagram(C.LRD, 0x200, b"\0"))
    assert (reply.data[0] & 0x08, reply.counter) == (0x08, 1)


def test_a_mapped_mailbox_that_is_empty_does_not_count(two: Any) -> None:
    two.write(0x0620, Fmmu(0x200, 256, 0, 7, 0x1100, 0, 1, 1).encode())
    assert two.send(Datagram(C.LRD, 0x200, bytes(256)))[0].counter == 0
    two.line[0].emergencies.append(bytes(8))
    two.number(0x080D, 1)
    assert two.send(Datagram(C.LRD, 0x200, bytes(256)))[0].counter == 1


def test_plans_follow_changes(two: Any) -> None:
    assert two.exchange(bytes(8))[1] == 4
    two.write(0x060C, b"\0")
    assert two.exchange(bytes(8))[1] == 3
    two.write(0x060C, b"\1")
    assert two.exchange(bytes(8))[1] == 4
    two.request(AlState.PREOP)
    assert two.exchange(bytes(8))[1] == 2
    two.segment.break_link(two.segment.slaves[0])
    assert two.segment.reachable == ()


def test_many_addresses_do_not_fill_memory(two: Any) -> None:
    for address in range(0, 5000, 4):
        two.send(Datagram(C.LRD, address, bytes(4)))
    assert two.exchange(bytes(8))[1] == 4


fmmus = st.builds(
    Fmmu,
    logical=st.integers(0, 20),
    length=st.integers(0, 6),
    start_bit=st.integers(0, 7),
    stop_bit=st.integers(0, 7),
    physical=st.integers(0x2000, 0x2010),
    physical_bit=st.integers(0, 7),
    direction=st.integers(0, 3),
    active=st.just(1),
)


def bit(data: bytes | bytearray, number: int) -> int:
    return data[number >> 3] >> (number & 7) & 1


@given(
    st.lists(fmmus, min_size=1, max_size=3),
    st.sampled_from([C.LRD, C.LWR, C.LRW]),
    st.integers(0, 20),
    st.binary(min_size=1, max_size=16),
    st.binary(min_size=32, max_size=32),
)
def test_bitwise_mapping_is_bit_by_bit(
    entries: list[Fmmu], command: C, address: int, data: bytes, memory: bytes
) -> None:
    """Against a loop over single bits: writes of all FMMUs first, then reads."""
    esc: Esc = Slave(Loopback()).esc
    esc.write(0x2000, memory)
    for number, entry in enumerate(entries):
        esc.write(0x0600 + 16 * number, entry.encode())
    expected_memory, expected_data = bytearray(memory), bytearray(data)
    wrote = read = False

    def pairs(entry: Fmmu) -> list[tuple[int, int]]:
        first = entry.logical * 8 + entry.start_bit
        last = (entry.logical + entry.length - 1) * 8 + entry.stop_bit
        memory_bit = (entry.physical - 0x2000) * 8 + entry.physical_bit
        if entry.length == 0:
            return []
        return [
            (logical - address * 8, memory_bit + logical - first)
            for logical in range(first, last + 1)
            if 0 <= logical - address * 8 < len(data) * 8
        ]

    def put(target: bytearray, number: int, value: int) -> None:
        target[number >> 3] = target[number >> 3] & ~(1 << (number & 7)) | value << (number & 7)

    for entry in entries:
        if command.writes and entry.writes:
            for in_data, in_memory in pairs(entry):
                put(expected_memory, in_memory, bit(data, in_data))
                wrote = True
    for entry in entries:
        if command.reads and entry.reads:
            for in_data, in_memory in pairs(entry):
                put(expected_data, in_data, bit(expected_memory, in_memory))
                read = True
    result = bytearray(data)
    plan = Plan([esc], command, address, len(data))
    count = plan.exchange(command, result)
    assert esc.read(0x2000, 32) == expected_memory
    assert result == expected_data
    weight = 2 if command is C.LRW else 1
    assert count == read + weight * wrote


OUTPUTS_AT, INPUTS_AT, SM1_STATUS = 0x1200, 0x1300, 0x080D


def esc_with(*fmmus: Fmmu, locked: bool = False, size: int = 4) -> Esc:
    """A slave with two mailboxes, outputs and inputs, and the FMMUs."""
    esc = Slave(Loopback()).esc
    esc.write(0x0800, sync_manager(0x1000, 256, 0x26) + sync_manager(0x1100, 256, 0x22))
    esc.write(0x0810, sync_manager(OUTPUTS_AT, size, 0x64) + sync_manager(INPUTS_AT, size, 0x20))
    for each in esc.sync_managers:
        each.locked = locked
    esc.sync_managers[3].source = lambda: b"in..."[:size]
    for number, fmmu in enumerate(fmmus):
        esc.write(0x0600 + 16 * number, fmmu.encode())
    return esc


def outputs(logical: int, length: int = 4, physical: int = OUTPUTS_AT) -> Fmmu:
    return Fmmu(logical, length, 0, 7, physical, 0, 2, 1)


def inputs(logical: int, length: int = 4, physical: int = INPUTS_AT) -> Fmmu:
    return Fmmu(logical, length, 0, 7, physical, 0, 1, 1)


def flag(bit: int, physical: int = SM1_STATUS, physical_bit: int = 3, bits: int = 1) -> Fmmu:
    return Fmmu(0, 1, bit, bit + bits - 1, physical, physical_bit, 1, 1)


@pytest.mark.parametrize(
    ("slaves", "takes", "gives", "flags", "is_exact"),
    [
        ([[]], [], [], [], False),
        ([[outputs(0)]], [(0, 4)], [], [], False),
        ([[inputs(2)]], [], [(2, 6)], [], False),
        ([[outputs(0), inputs(4)], [outputs(8), inputs(12)]],
         [(0, 4), (8, 12)], [(4, 8), (12, 16)], [], False),
        ([[outputs(0), inputs(0)]], [(0, 4)], [(0, 4)], [], False),
        ([[inputs(4)], [outputs(0)]], [(0, 4)], [(4, 8)], [], False),
        ([[inputs(4)], [outputs(8)]], [(8, 12)], [(4, 8)], [], False),
        ([[inputs(4)], [outputs(1)]], [], [(4, 8)], [], True),
        ([[inputs(4)], [outputs(7)]], [], [(4, 8)], [], True),
        ([[outputs(0, 2)]], [], [], [], True),
        ([[outputs(0, 2, OUTPUTS_AT + 2)]], [], [], [], True),
        ([[outputs(0, 4, INPUTS_AT)]], [], [], [], True),
        ([[outputs(0, 256, 0x1000)]], [], [], [], True),
        ([[outputs(0, 4, 0x0130)]], [], [], [], True),
        ([[inputs(0, 2)]], [], [], [], True),
        ([[inputs(0, 4, OUTPUTS_AT)]], [], [], [], True),
        ([[inputs(0, 256, 0x1100)]], [], [], [], True),
        ([[inputs(0, 2, 0x0FFE)]], [], [(0, 2)], [], False),
        ([[inputs(0, 2, 0x0FFF)]], [], [], [], True),
        ([[Fmmu(0, 1, 0, 3, INPUTS_AT, 0, 1, 1)]], [], [], [], True),
        ([[flag(0)], [flag(1)]], [], [], [1, 2], False),
        ([[flag(0), flag(5)]], [], [], [1, 32], False),
        ([[flag(3)], [flag(3)]], [], [], [8, 8], True),
        ([[flag(0, 0x0805)]], [], [], [1], False),
        ([[flag(0, 0x0805 + 8 * 3)]], [], [], [1], False),
        ([[flag(0, 0x0805 - 8)]], [], [], [], True),
        ([[flag(0, SM1_STATUS, 2)]], [], [], [], True),
        ([[flag(0, SM1_STATUS, 4)]], [], [], [], True),
        ([[flag(0, SM1_STATUS, 3, 2)]], [], [], [], True),
        ([[flag(0)], [inputs(1)]], [], [(1, 5)], [1], True),
        ([[flag(0)], [outputs(1)]], [(1, 5)], [], [1], True),
        ([[flag(0), inputs(1)]], [], [], [1], True),
        ([[flag(0), outputs(1)]], [(1, 5)], [], [1], True),
    ],
)  # fmt: skip
def test_plan_takes_whole_buffers_and_flags_at_once_or_goes_bit_by_bit(
    slaves: list[list[Fmmu]],
    takes: list[tuple[int, int]],
    gives: list[tuple[int, int]],
    flags: list[int],
    is_exact: bool,
) -> None:
    escs = [esc_with(*each) for each in slaves]
    plan = Plan([*escs, esc_with()], C.LRW, 0, 256)
    assert [(part.start, part.stop) for _, part in plan.takes] == takes
    assert [(part.start, part.stop) for _, part in plan.gives] == gives
    assert [bit for _, bit in plan.flags] == flags
    assert plan.exact is is_exact
    assert plan.escs == [esc for esc, each in zip(escs, slaves, strict=True) if each]
    writes, reads = (
        sum(any(getattr(fmmu, kind) for fmmu in each) for each in slaves)
        for kind in ("writes", "reads")
    )
    assert plan.count == 2 * writes + reads


def test_plan_of_a_read_ignores_outputs_and_that_of_a_write_inputs() -> None:
    esc = esc_with(outputs(0), inputs(0))
    read, write = Plan([esc], C.LRD, 0, 4), Plan([esc], C.LWR, 0, 4)
    assert (len(read.takes), len(read.gives), read.count) == (0, 1, 1)
    assert (len(write.takes), len(write.gives), write.count) == (1, 0, 1)


def test_flag_is_that_of_a_sync_manager() -> None:
    count = len(esc_with().sync_managers)
    for number, is_flag in ((count - 1, True), (count, False)):
        plan = Plan([esc_with(flag(0, 0x0805 + 8 * number))], C.LRD, 0, 1)
        assert (len(plan.flags), plan.exact) == (int(is_flag), not is_flag)


def test_locked_buffers_are_not_exchanged_at_once() -> None:
    for fmmu in (outputs(0), inputs(0)):
        assert Plan([esc_with(fmmu, locked=True)], C.LRW, 0, 4).exact
    sourceless = esc_with(inputs(0))
    sourceless.sync_managers[3].source = None
    assert Plan([sourceless], C.LRW, 0, 4).exact


@pytest.mark.parametrize(
    ("places", "span"),
    [
        ([], None), ([2], (2, 6)), ([2, 6, 10], (2, 14)), ([2, 7], None), ([2, 6, 11], None),
        ([6, 2], None),
    ],
)  # fmt: skip
def test_span_has_inputs_without_gap(places: list[int], span: tuple[int, int] | None) -> None:
    result = Plan([esc_with(inputs(place)) for place in places], C.LRD, 0, 32).span
    assert (None if result is None else (result.start, result.stop)) == span


def test_flags_are_looked_at_and_other_bits_stay() -> None:
    escs = [esc_with(flag(0)), esc_with(flag(5))]
    plan = Plan(escs, C.LRD, 0, 2)
    assert plan.look(b"\xff\xff") == b"\xde\xff"
    escs[1].sync_managers[1].put(b"message")
    assert plan.look(b"\xff\xff") == b"\xfe\xff"
    assert plan.look(b"\0\0") == b"\x20\0"


@pytest.mark.parametrize("first", [0, 1, 3, 7])
@pytest.mark.parametrize("bits", [1, 2, 5, 8, 12])
@pytest.mark.parametrize("ones", [False, True])
def test_bits_are_exchanged_without_their_neighbours(first: int, bits: int, ones: bool) -> None:
    last = first + bits - 1
    fmmu = Fmmu(1, 1 + last // 8, first, last % 8, 0x2001, 2, 3, 1)
    for command in (C.LRD, C.LWR):
        esc = Slave(Loopback()).esc
        esc.write(0x2000, (b"\0" if ones else b"\xff") * 6)
        esc.write(0x0600, fmmu.encode())
        data = bytearray((b"\xff" if ones else b"\0") * 6)
        assert Plan([esc], command, 0, 6).exchange(command, data) == 1
        in_data = int.from_bytes(data, "little")
        in_memory = int.from_bytes(esc.read(0x2000, 6) or b"", "little")
        changed = ((1 << bits) - 1) << (8 + (first if command is C.LRD else 2))
        target = in_data if command is C.LRD else in_memory
        assert target == ((1 << 48) - 1 - changed if ones is (command is C.LRD) else changed)


def test_registers_and_buffers_are_given_as_they_are() -> None:
    esc = esc_with(inputs(0), inputs(4, 2, 0x0FFE))
    esc.memory[0x0FFE:0x1000] = b"ab"
    plan = Plan([esc], C.LRD, 0, 8)
    assert [give() for give, _ in plan.gives] == [b"in..", b"ab"]


def test_outputs_go_to_the_sink_if_there_is_one() -> None:
    esc = esc_with(outputs(0))
    manager = esc.sync_managers[2]
    [(take, _)] = Plan([esc], C.LWR, 0, 4).takes
    assert take == manager.complete
    taken: list[bytes] = []
    manager.sink = taken.append
    [(take, _)] = Plan([esc], C.LWR, 0, 4).takes
    assert take == taken.append
    take(b"abcd")
    assert taken == [b"abcd"]


@pytest.mark.parametrize("fmmu", [inputs(0, 4, OUTPUTS_AT), inputs(0, 256, 0x1100)])
def test_only_buffers_to_the_master_are_given_at_once(fmmu: Fmmu) -> None:
    """Though the master may have set a SyncManager up in another way than the slave."""
    esc = esc_with(fmmu)
    for each in esc.sync_managers:
        each.source = lambda: b""
    plan = Plan([esc], C.LRD, 0, 256)
    assert (plan.gives, plan.exact) == ([], True)
