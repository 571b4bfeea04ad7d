"""A station that catches up on a network interface: its slaves have the time of the computer."""

from collections import deque
from itertools import pairwise

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from achse.ethercat.master.errors import FrameLost
from tests.station.buses.test_interface_bus import BusRig, Cable, Interface, drives

MS = 1_000_000
CYCLE_NS = 2 * MS


class FarInterface(Interface):
    """Its frames come back `delay_ns` of the computer's time after they were sent."""

    delay_ns = 0

    def open(self, interface: str) -> "FarCable":
        super().open(interface)
        return FarCable(self)


class FarCable(Cable):
    interface: FarInterface

    def __init__(self, interface: FarInterface) -> None:
        super().__init__(interface)
        self.due: deque[int] = deque()

    def send(self, frame: bytes) -> bool:
        before = len(self.waiting)
        sent = super().send(frame)
        if len(self.waiting) > before:
            self.due.append(self.interface.now_ns + self.interface.delay_ns)
        return sent

    def receive(self, timeout_s: float) -> bytes | None:
        if self.due and self.due[0] > self.interface.now_ns:
            return None
        reply = super().receive(timeout_s)
        if reply is not None:
            self.due.popleft()
        return reply


@settings(max_examples=5, phases=[Phase.generate])
@given(
    delay_ns=st.integers(2 * MS, 4 * MS),
    step_ns=st.integers(100_000, 400_000),
    index=st.sampled_from((0x1000, 0x6041, 0x6064)),
)
def test_a_request_has_the_time_of_the_computer(delay_ns: int, step_ns: int, index: int) -> None:
    """5 ms are not over after three cycles of 2 ms that take a moment each."""
    with pytest.MonkeyPatch.context() as patch:
        interface = FarInterface(CYCLE_NS, drives(1))
        rig = BusRig(patch, interface, 1)
        rig.until(rig.operational)
        master = rig.bus.master
        lost = master.traffic.lost_frames
        interface.delay_ns, interface.step_ns = delay_ns, step_ns
        job = master.upload(master.slaves[0], index)
        for _ in range(200 * delay_ns // step_ns):
            if job.is_done:
                break
            rig.station.advance(CYCLE_NS / 1e9)
        assert job.result()
        assert master.traffic.lost_frames == lost


def test_a_link_that_does_not_answer_is_reported_by_the_computer_s_clock(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Three times 5 ms; at 0.1 ms a cycle that takes so many more cycles."""
    interface = FarInterface(CYCLE_NS, drives(1))
    rig = BusRig(monkeypatch, interface, 1)
    rig.until(rig.operational)
    interface.step_ns, interface.up = 100_000, False
    job = rig.bus.master.upload(rig.bus.master.slaves[0], 0x1000)
    began = interface.now_ns
    for _ in range(1000):
        if job.is_done:
            break
        rig.station.advance(CYCLE_NS / 1e9)
    assert 3 * 5 * MS <= interface.now_ns - began < 4 * 5 * MS
    with pytest.raises(FrameLost):
        job.result()


def test_an_interface_is_tried_again_after_a_second_of_the_computer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    interface = Interface(CYCLE_NS, drives(1))
    rig = BusRig(monkeypatch, interface, 1)
    rig.until(rig.operational)
    tries = []
    opened = interface.open

    def count(name: str) -> Cable:
        tries.append(interface.now_ns)
        return opened(name)

    rig.bus._open_link = count
    interface.there = False
    interface.step_ns = 200_000
    rig.station.advance(40.0)
    assert len(tries) in (4, 5)
    assert all(1000 * MS <= later - earlier <= 1001 * MS for earlier, later in pairwise(tries))
