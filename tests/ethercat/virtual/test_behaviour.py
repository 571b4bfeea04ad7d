"""Behaviours: loop-back, recorded signals, a class of one's own."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState, AlStatus
from achse.ethercat.master.esi_reader import read_esi
from achse.ethercat.virtual import LoopBack, RecordedSignals, SlaveBehaviour, VirtualDevice
from tests.ethercat.virtual.esi_text import ANALOG, esi

MS = 1_000_000


def device_with(behaviour: SlaveBehaviour) -> VirtualDevice:
    return VirtualDevice(read_esi(esi(ANALOG))[0], behaviour=behaviour)


@given(data=st.binary(min_size=2, max_size=2))
def test_loop_back(data: bytes) -> None:
    device = device_with(LoopBack())
    device.write_outputs(data)
    device.step(MS)
    assert device.read_inputs() == data + b"\0\0"


@given(
    values=st.lists(st.integers(-100, 100), min_size=2, max_size=6),
    steps=st.lists(st.integers(1, 40), max_size=8),
    repeat=st.booleans(),
)
def test_recording_gives_the_row_of_the_moment(
    values: Sequence[int], steps: Sequence[int], repeat: bool
) -> None:
    lines = ["time,PDO 1A00.Value", *(f"{n / 100},{value}" for n, value in enumerate(values))]
    device = device_with(RecordedSignals.from_csv(lines, repeat=repeat))
    assert device.input("Value") == values[0]
    now = 0
    for step in steps:
        now += step
        device.step(step * MS)
        place = now % (10 * (len(values) - 1)) if repeat else now
        assert device.input("Value") == values[min(place // 10, len(values) - 1)]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "first line"),
        (["x,Value"], "first line"),
        (["time,Value"], "needs rows"),
        (["time,Value", "1"], "line 2: expected 2 values"),
        (["time,Value", "1,a"], "line 2: expected numbers"),
        (["time,Value", "1,2", "0,2"], "do not go back"),
        (["time,Valve", "1,2"], "is an output"),
        (["time,Value", "1,99999"], "expected -32768"),
    ],
)
def test_recording_that_cannot_be_is_refused(lines: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        device_with(RecordedSignals.from_csv(lines))


def test_columns_have_a_value_for_each_time() -> None:
    with pytest.raises(ValueError, match="expected 1 values, got 2"):
        RecordedSignals([0], {"Value": [1, 2]})
    with pytest.raises(KeyError, match="Value"):
        device_with(RecordedSignals([0], {"Valu": [1]}))


def test_class_of_ones_own_sees_states_and_time() -> None:
    class Integrator(SlaveBehaviour):
        """The valve fills, the level tells."""

        cycle_ns = 2 * MS

        def __init__(self) -> None:
            self.states: list[AlState] = []

        def step(self, device: VirtualDevice, elapsed_ns: int) -> None:
            level = device.input("Level")
            valve = device.output("Valve")
            assert isinstance(level, float)
            assert isinstance(valve, int)
            device.set_input("Level", level + valve * elapsed_ns * 1e-9)

        def enter(self, device: VirtualDevice, state: AlState) -> None:
            self.states.append(state)

    behaviour = Integrator()
    device = device_with(behaviour)
    device.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    device.write_outputs(b"\x0a\0")
    device.step(500 * MS)
    assert (device.input("Level"), device.local_cycle_ns) == (5.0, 2 * MS)
    assert behaviour.states == [AlState.PREOP]
