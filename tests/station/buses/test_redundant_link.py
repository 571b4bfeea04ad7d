"""Two interfaces as one link: a bus in a ring goes on while a cable is cut."""

from collections import deque

import pytest

from achse.codes import AlState
from achse.ethercat import Loopback, Slave, describe
from achse.ethercat.master import BusConfiguration, Master, from_description
from achse.ethercat.ring_segment import RingSegment
from achse.station.buses.frame_link import BusLink
from achse.station.buses.redundant_link import RedundantLink

CYCLE_NS = 1_000_000


class Adapter:
    """One end of the ring; what comes out at an end waits there."""

    def __init__(self, ring: RingSegment, number: int, ends: list["Adapter"]) -> None:
        self.ring, self.number, self.ends = ring, number, ends
        self.waiting: deque[bytes] = deque()
        self.arrived_ns = 0
        ends.append(self)

    def send(self, frame: bytes) -> bool:
        came = self.ring.process_from(self.number, frame)
        if came is not None:
            self.ends[came[1]].waiting.append(came[0])
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        return self.waiting.popleft() if self.waiting else None


@pytest.mark.parametrize("where", range(4))
def test_a_cut_is_passed_over(where: int) -> None:
    line = [Loopback(serial_number=number) for number in range(3)]
    ring = RingSegment(map(Slave, line))
    slaves = tuple(from_description(describe(each), f"Box {n}") for n, each in enumerate(line))
    master = Master(BusConfiguration(slaves, cycle_ns=CYCLE_NS, redundant=True))
    assert master.redundancy is not None
    ends: list[Adapter] = []
    link = RedundantLink(Adapter(ring, 0, ends), Adapter(ring, 1, ends), master.redundancy)
    bus = BusLink(master, link, wait_s=0.001)
    now = 0

    def run(cycles: int) -> None:
        nonlocal now
        for _ in range(cycles):
            now += CYCLE_NS
            ring.advance(now)
            bus.exchange(now)

    master.request(AlState.OP)
    run(800)
    assert master.operational, master.take_events()
    ring.cut(where)
    wrong = master.cyclic.counters.wrong
    run(100)
    assert master.operational
    assert master.redundancy.open
    assert master.cyclic.counters.wrong == wrong
    master.slaves[2].outputs[:] = b"last"
    run(3)
    assert bytes(master.slaves[2].inputs) == b"last"
    assert link.receive(0.0) is None
