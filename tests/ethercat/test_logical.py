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


def test_bytes_nobody_maps_stay(two: Any) -> None:
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
