"""Virtual terminals: bits and values on a bus, by objects, and off outside Op."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState, SdoAbort
from achse.ethercat import Segment, Slave, describe
from achse.ethercat.master import BusConfiguration, Master, Ring, from_description
from achse.ethercat.terminals import AnalogStatus, AnalogTerminal, DigitalTerminal


def bus_of(*terminals: Any) -> Ring:
    """A bus of terminals in Op."""
    slaves = tuple(from_description(describe(each)) for each in terminals)
    master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
    ring = Ring(master, Segment(Slave(each) for each in terminals))
    master.request(AlState.OP)
    ring.run(300_000_000)
    assert master.operational, master.take_events()
    return ring


@given(
    inputs=st.integers(0, 64),
    outputs=st.integers(0, 64),
    on=st.lists(st.integers(0, 63), max_size=10),
    switched=st.lists(st.integers(0, 63), max_size=10),
)
def test_every_bit_gets_through(
    inputs: int, outputs: int, on: list[int], switched: list[int]
) -> None:
    if not inputs + outputs:
        return
    terminal = DigitalTerminal(inputs, outputs)
    ring = bus_of(terminal)
    (slave,) = ring.master.slaves
    on, switched = [n for n in on if n < inputs], [n for n in switched if n < outputs]
    for channel in on:
        terminal.set_input(channel, True)
    for channel in switched:
        slave.write_output(0x7000, channel + 1, 1)
    ring.run(ring.master.now_ns + 3_000_000)
    assert [n for n in range(inputs) if slave.read_input(0x6000, n + 1)] == sorted({*on})
    assert [n for n in range(outputs) if terminal.output(n)] == sorted({*switched})
    for channel in on:
        terminal.set_input(channel, False)
    ring.run(ring.master.now_ns + 2_000_000)
    assert not any(slave.inputs)


def test_outputs_are_off_outside_op() -> None:
    terminal = DigitalTerminal(0, 4)
    ring = bus_of(terminal)
    ring.master.slaves[0].write_output(0x7000, 4, 1)
    ring.run(ring.master.now_ns + 2_000_000)
    assert terminal.output(3)
    ring.master.request(AlState.SAFEOP)
    ring.run(ring.master.now_ns + 50_000_000)
    assert not terminal.output(3)


@settings(max_examples=10)
@given(volts=st.floats(-20, 20), out=st.integers(-32768, 32767), channel=st.integers(0, 3))
def test_analog_values(volts: float, out: int, channel: int) -> None:
    terminal = AnalogTerminal()
    ring = bus_of(terminal)
    (slave,) = ring.master.slaves
    terminal.set_voltage(channel, volts)
    slave.write_output(0x7000 + 16 * channel, 0x11, out)
    ring.run(ring.master.now_ns + 3_000_000)
    value = slave.read_input(0x6000 + 16 * channel, 0x11, signed=True)
    assert value == round(min(max(volts, -10), 10) / 10 * 32767)
    status = slave.read_input(0x6000 + 16 * channel, 1)
    assert bool(status & AnalogStatus.OVERRANGE) == (volts > 10)
    assert bool(status & AnalogStatus.UNDERRANGE) == (volts < -10)
    assert status & AnalogStatus.TOGGLE
    assert terminal.voltage(channel) == pytest.approx(out / 32767 * 10)


def test_objects_are_what_travels() -> None:
    terminal = DigitalTerminal(16, 16)
    ring = bus_of(terminal, AnalogTerminal())
    terminal.set_input(4, True)
    job = ring.master.upload(ring.master.slaves[0], 0x6000, 5)
    ring.run(ring.master.now_ns + 20_000_000)
    assert job.result() == b"\1"
    job = ring.master.upload(ring.master.slaves[1], 0x1018, 0, complete=True)
    ring.run(ring.master.now_ns + 20_000_000)
    assert job.result()[:2] == b"\4\0"
    with pytest.raises(SdoAbort):
        terminal.write_object(0x7000, 1, b"\1")
    with pytest.raises(SdoAbort):
        terminal.read_object(0x7000, 17)


def test_channels_that_are_not_there() -> None:
    for make in (lambda: DigitalTerminal(65, 0), lambda: AnalogTerminal(0, 0)):
        with pytest.raises(ValueError, match="channels"):
            make()
    with pytest.raises(IndexError):
        DigitalTerminal(4, 4).set_input(4, True)
    with pytest.raises(IndexError):
        DigitalTerminal(4, 4).output(-1)
    with pytest.raises(IndexError):
        AnalogTerminal().set_voltage(4, 0)
    with pytest.raises(IndexError):
        AnalogTerminal().voltage(4)
    with pytest.raises(ValueError, match="number"):
        AnalogTerminal().set_voltage(0, float("nan"))
