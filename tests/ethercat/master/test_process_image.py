"""The process image: places of entries, datagrams, FMMUs."""

from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import DatagramCommand, Loopback, Segment, Slave, describe
from achse.ethercat.description import Pdo, PdoEntry
from achse.ethercat.master import Master, Ring
from achse.ethercat.master.configuration import (
    BusConfiguration,
    ProcessSyncManager,
    SlaveConfiguration,
    from_description,
)
from achse.ethercat.master.process_image import MAILBOX_BITS, ProcessImage, entry_places
from achse.ethercat.terminals import DigitalTerminal
from tests.ethercat.master.boxes import box


def test_outputs_come_before_inputs_and_count_twice() -> None:
    image = ProcessImage(BusConfiguration((box(16, 8), box(0, 24), box(8, 0))))
    (datagram,) = image.datagrams
    assert datagram.command is DatagramCommand.LRW
    assert (datagram.output_end, datagram.length, datagram.working) == (3, 7, 2 * 2 + 2)
    assert [each.first for each in image.outputs] == [0, 0, 2]
    assert [each.first for each in image.inputs] == [3, 4, 0]
    assert {(each.bit, each.bits) for each in (*image.outputs, *image.inputs)} == {(0, 0)}


def test_one_kind_alone_needs_no_lrw() -> None:
    image = ProcessImage(BusConfiguration((box(0, 8),)))
    assert [(each.command, each.working) for each in image.datagrams] == [(DatagramCommand.LRD, 1)]
    image = ProcessImage(BusConfiguration((box(8, 0),)))
    assert [(each.command, each.working) for each in image.datagrams] == [(DatagramCommand.LWR, 1)]


def test_without_lrw_there_are_two_datagrams() -> None:
    image = ProcessImage(BusConfiguration((box(8, 8), box(8, 8, lrw=False))))
    write, read = image.datagrams
    assert (write.command, write.working, write.length) == (DatagramCommand.LWR, 2, 2)
    assert (read.command, read.working, read.output_end) == (DatagramCommand.LRD, 2, 0)
    assert read.logical == write.logical + 2
    assert image.fmmus(1, 3)[1].logical == read.logical + 1


def test_sync_units_have_datagrams_of_their_own() -> None:
    image = ProcessImage(BusConfiguration((box(8, 8, "a"), box(8, 8, "b"), box(8, 8, "a"))))
    assert [each.slaves for each in image.datagrams] == [[0, 2], [1]]


def test_fmmus_and_the_bit_of_the_mailbox() -> None:
    slave = from_description(describe(Loopback(4)))
    image = ProcessImage(BusConfiguration((slave, slave)))
    outputs, inputs, mailbox = image.fmmus(1, 3)
    assert (outputs.writes, outputs.length, outputs.physical) == (True, 4, 0x1200)
    assert (inputs.reads, inputs.physical) == (True, 0x1300)
    assert (mailbox.logical, mailbox.start_bit, mailbox.stop_bit) == (MAILBOX_BITS, 1, 1)
    assert len(image.fmmus(1, 2)) == 2
    with pytest.raises(ValueError, match="need 2 FMMUs, the slave has 1"):
        image.fmmus(1, 1)


def test_a_slave_larger_than_a_frame_is_refused() -> None:
    with pytest.raises(ValueError, match="at most"):
        ProcessImage(BusConfiguration((box(8 * 1401, 0),)))


def test_datagram_has_1400_bytes_at_most() -> None:
    image = ProcessImage(BusConfiguration((box(8 * 1400, 0), box(0, 8 * 1400))))
    assert [each.length for each in image.datagrams] == [1400, 1400]
    assert [each.logical for each in image.datagrams] == [0x0100_0000, 0x0100_0800]
    with pytest.raises(ValueError, match="at most, got 1401"):
        ProcessImage(BusConfiguration((box(8 * 1400, 8),)))
    halves = tuple(box(8 * 700, 0) for _ in range(5))
    image = ProcessImage(BusConfiguration(halves))
    assert [each.slaves for each in image.datagrams] == [[0, 1], [2, 3], [4]]
    image = ProcessImage(BusConfiguration((box(8 * 1399, 0), box(8, 0), box(8, 0))))
    assert [each.slaves for each in image.datagrams] == [[0, 1], [2]]
    image = ProcessImage(BusConfiguration((box(0, 0), box(8, 0))))
    assert [each.slaves for each in image.datagrams] == [[1]]
    assert (image.writes.keys(), image.reads.keys()) == ({1}, set())


def test_mailbox_state_is_a_bit_by_number_of_the_mailbox() -> None:
    slave = from_description(describe(Loopback(4)))
    slaves = (box(8, 8), *(slave for _ in range(10)))
    image = ProcessImage(BusConfiguration(slaves))
    assert image.mailboxes == list(range(1, 11))
    assert len(image.fmmus(0, 9)) == 2
    for position in (1, 8, 9, 10):
        bit = position - 1
        state = image.fmmus(position, 3)[-1]
        assert (state.logical, state.length) == (MAILBOX_BITS + bit // 8, 1)
        assert (state.start_bit, state.stop_bit) == (bit % 8, bit % 8)
        assert (state.physical, state.physical_bit) == (0x080D, 3)
        assert (state.reads, state.writes) == (True, False)


def many(outputs: int, inputs: int, *, packed: bool = False, pad: int = 2) -> SlaveConfiguration:
    """A slave with two SyncManagers for each direction; the first has one bit behind padding."""
    pdos = {
        number: Pdo(
            0x1600 + number,
            "",
            number,
            True,
            (PdoEntry(0, 0, pad, "", 0), PdoEntry(0x7000, number, bits, "", 1)),
        )
        for number, bits in ((2, 1), (3, outputs), (4, 1), (5, inputs))
    }
    return SlaveConfiguration(
        "many",
        sync_managers=tuple(
            ProcessSyncManager(number, 0x1000 + 0x80 * number, 0x64, number < 4)
            for number in (2, 3, 4, 5)
        ),
        outputs=(pdos[2], pdos[3]),
        inputs=(pdos[4], pdos[5]),
        packed=packed,
    )


@pytest.mark.parametrize("packed", [False, True])
def test_each_sync_manager_begins_at_a_byte_and_has_an_fmmu(packed: bool) -> None:
    slave = many(14, 20, packed=packed)
    image = ProcessImage(BusConfiguration((slave, slave)))
    [datagram] = image.datagrams
    assert (datagram.output_end, datagram.length) == (6, 14)
    assert image.lengths(0) == {2: 1, 3: 2, 4: 1, 5: 3}
    fmmus = image.fmmus(1, 4)
    results = [(each.logical - 0x0100_0000, each.length, each.physical) for each in fmmus]
    assert results == [(3, 1, 0x1100), (4, 2, 0x1180), (10, 1, 0x1200), (11, 3, 0x1280)]
    assert {(each.start_bit, each.stop_bit, each.active) for each in image.fmmus(1, 4)} == {
        (0, 7, 1)
    }
    assert [(each.bit, each.bits, each.pdo) for each in entry_places(slave, True)] == [
        (2, 1, 0x1602),
        (10, 14, 0x1603),
    ]
    assert [(each.bit, each.byte) for each in entry_places(slave, False)] == [(2, 0), (10, 1)]
    whole = many(14, 20, pad=7)
    assert [each.bit for each in entry_places(whole, True)] == [7, 15]
    assert ProcessImage(BusConfiguration((whole,))).lengths(0) == {2: 1, 3: 3, 4: 1, 5: 4}


def test_sync_manager_without_data_has_no_fmmu() -> None:
    managers = (*box(0, 0).sync_managers, ProcessSyncManager(4, 0x1200, 0x64, True))
    slaves = tuple(
        replace(box(bits, 8), sync_managers=managers, packed=bits < 8) for bits in (8, 3, 3)
    )
    image = ProcessImage(BusConfiguration(slaves))
    assert [(each.physical, each.length) for each in image.fmmus(0, 9)] == [
        (0x1100, 1),
        (0x1180, 1),
    ]
    assert [(each.first, each.bit, each.bits) for each in image.outputs[1:]] == [
        (1, 0, 3),
        (1, 3, 3),
    ]


def test_slaves_that_are_not_packed_share_no_byte() -> None:
    image = ProcessImage(BusConfiguration((box(1, 4), box(1, 4))))
    areas = (*image.outputs, *image.inputs)
    assert [(each.first, each.bit, each.bits) for each in areas] == [
        *((0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0))
    ]


@pytest.mark.parametrize(
    ("bits", "places"),
    [
        ((4, 4), [(0, 0, 4), (0, 4, 4)]),
        ((4, 5), [(0, 0, 4), (1, 0, 5)]),
        ((7, 1, 1), [(0, 0, 7), (0, 7, 1), (1, 0, 1)]),
        ((1, 8, 1), [(0, 0, 1), (1, 0, 0), (2, 0, 1)]),
        ((8, 1), [(0, 0, 0), (1, 0, 1)]),
    ],
)
def test_slaves_of_up_to_seven_bits_share_a_byte(
    bits: tuple[int, ...], places: list[tuple[int, int, int]]
) -> None:
    slaves = tuple(replace(box(0, each), packed=True) for each in bits)
    image = ProcessImage(BusConfiguration(slaves))
    assert [(each.first, each.bit, each.bits) for each in image.inputs] == places
    assert image.datagrams[0].length == places[-1][0] + 1
    for position, (first, bit, count) in enumerate(places):
        [fmmu] = image.fmmus(position, 1)
        assert fmmu.logical == 0x0100_0000 + first
        assert (fmmu.start_bit, fmmu.stop_bit) == ((bit, bit + count - 1) if count else (0, 7))
        assert (fmmu.length, fmmu.physical_bit, fmmu.reads) == (1, 0, True)


def test_inputs_of_a_read_begin_behind_the_outputs_of_the_write() -> None:
    image = ProcessImage(BusConfiguration((box(24, 8, lrw=False), box(0, 16))))
    write, read = image.datagrams
    assert (write.command, write.working, write.output_end) == (DatagramCommand.LWR, 1, 3)
    assert (read.command, read.working, read.length) == (DatagramCommand.LRD, 2, 3)
    assert (write.logical, read.logical) == (0x0100_0000, 0x0100_0003)
    assert (write.slaves, read.slaves) == ([0, 1], [0, 1])
    assert (image.writes, image.reads) == ({0: write}, {0: read, 1: read})
    assert [each.first for each in image.inputs] == [0, 1]
    assert (write.valid, write.fresh, write.wrong) == (False, 0, 0)


@given(
    st.lists(
        st.tuples(st.integers(0, 2000), st.integers(0, 2000), st.sampled_from("ab"), st.booleans()),
        max_size=40,
    )
)
def test_no_two_areas_overlap(drawn: list[tuple[int, int, str, bool]]) -> None:
    bus = BusConfiguration(tuple(box(*each) for each in drawn))
    image = ProcessImage(bus)
    for datagram in image.datagrams:
        used = [False] * datagram.length
        for owners, areas in ((image.writes, image.outputs), (image.reads, image.inputs)):
            for position, owner in owners.items():
                if owner is datagram:
                    area = areas[position]
                    for byte in range(area.first, area.first + area.length):
                        assert not used[byte]
                        used[byte] = True
        assert all(used)
    logical = sorted((each.logical, each.length) for each in image.datagrams)
    for (first, length), (second, _) in pairwise(logical):
        assert first + length <= second


def test_entries_know_their_bit() -> None:
    slave = from_description(describe(Loopback(4))).with_entries(
        [(0x7000, 1, 8), (0, 0, 3), (0x7000, 2, 8)]
    )
    first, second = entry_places(slave, True)
    assert (first.bit, second.bit, second.byte) == (0, 11, 1)
    assert [each.subindex for each in entry_places(slave, False)] == [1, 2, 3, 4]


@settings(max_examples=10, deadline=None)
@given(st.data())
def test_slaves_with_few_bits_share_bytes(data: st.DataObject) -> None:
    """All parameters drawn: channels, whether LRW works, which share, values, a lost frame."""
    draw = data.draw
    sizes = draw(
        st.lists(st.tuples(st.integers(0, 17), st.integers(0, 17)), min_size=1, max_size=8),
        "inputs and outputs",
    )
    line = [DigitalTerminal(*each) for each in sizes if any(each)]
    if not line:
        return
    packed = draw(st.lists(st.booleans(), min_size=len(line), max_size=len(line)), "packed")
    whole = draw(st.booleans(), "LRW")
    slaves = tuple(
        replace(from_description(describe(each)), packed=on, logical_read_write=whole)
        for each, on in zip(line, packed, strict=True)
    )
    segment = Segment(map(Slave, line))
    master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
    ring = Ring(master, segment)
    master.request(AlState.OP)
    for _ in range(2000):
        if master.operational:
            break
        ring.exchange(master.now_ns + 1_000_000)
    assert master.operational
    for _ in range(3):
        outputs = []
        for slave, terminal in zip(master.slaves, line, strict=True):
            value = draw(st.integers(0, (1 << terminal.outputs) - 1), "outputs")
            for place in slave.output_entries.values():
                slave.write_output(place.index, place.subindex, value >> place.subindex - 1 & 1)
            outputs.append(value)
            for channel in range(terminal.inputs):
                terminal.set_input(channel, draw(st.booleans(), "input"))
        for _ in range(3):
            ring.exchange(master.now_ns + 1_000_000)
        for slave, terminal, value in zip(master.slaves, line, outputs, strict=True):
            assert int.from_bytes(terminal.output_image, "little") == value
            assert bytes(slave.inputs) == terminal.input_image
        assert all(each.working for each in master.slaves)


def test_eight_terminals_of_one_bit_take_one_byte() -> None:
    line = [DigitalTerminal(1, 1) for _ in range(8)] + [
        DigitalTerminal(4, 4),
        DigitalTerminal(5, 3),
    ]
    slaves = tuple(from_description(describe(each)) for each in line)
    image = ProcessImage(BusConfiguration(slaves))
    (datagram,) = image.datagrams
    assert (datagram.output_end, datagram.length) == (2, 5)  # 4 + 5 bits do not fit into a byte
    assert [(area.first, area.bit, area.bits) for area in image.outputs[7:]] == [
        *((0, 7, 1), (1, 0, 4), (1, 4, 3))
    ]
    fmmu = image.fmmus(7, 4)[0]
    assert (fmmu.length, fmmu.start_bit, fmmu.stop_bit, fmmu.physical_bit) == (1, 7, 7, 0)
