"""Cyclic exchange: outputs are memory, wrong counters freeze inputs, lost frames are counted."""

from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.ethercat import DatagramCommand, Disturbance, EthercatFrame
from achse.ethercat.master import ClockConfiguration


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
    from dataclasses import replace

    from achse.ethercat.master import BusConfiguration, Master, Ring

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
    from achse.ethercat import Loopback, Segment, Slave, describe
    from achse.ethercat.master import BusConfiguration, Master, Ring, from_description

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
