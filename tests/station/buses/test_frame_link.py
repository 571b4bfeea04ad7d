"""A master on a link: cycles wait for their frames as long as they may, and are timed."""

from collections import deque

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.master import BusConfiguration, Master, from_description
from achse.ethercat.master.errors import BusError
from achse.ethercat.master.inspection import count_slaves
from achse.station.buses.frame_link import BusLink, RoundTrips, do_steps

CYCLE_NS = 1_000_000


class CableToSegment:
    """A link to a segment that answers after `delay_ns` of a clock that only waiting moves."""

    def __init__(self, segment: Segment, delay_ns: int = 20_000) -> None:
        self.segment = segment
        self.delay_ns = delay_ns
        self.now_ns = self.arrived_ns = 0
        self.waiting: deque[tuple[int, bytes]] = deque()

    def clock(self) -> int:
        self.now_ns += 100
        return self.now_ns

    def send(self, frame: bytes) -> bool:
        self.segment.advance(self.now_ns)
        reply = self.segment.process(frame)
        if reply is not None:
            self.waiting.append((self.now_ns + self.delay_ns, reply))
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        until = self.now_ns + round(timeout_s * 1e9)
        if self.waiting and self.waiting[0][0] <= until:
            due, reply = self.waiting.popleft()
            self.arrived_ns = due
            self.now_ns = max(self.now_ns, due)
            return reply
        self.now_ns = until
        return None


def bus(delay_ns: int) -> tuple[BusLink, CableToSegment]:
    line = [Loopback(serial_number=number) for number in range(2)]
    cable = CableToSegment(Segment(Slave(each) for each in line), delay_ns)
    slaves = tuple(from_description(describe(each)) for each in line)
    master = Master(BusConfiguration(slaves, cycle_ns=CYCLE_NS))
    return BusLink(master, cable, clock=cable.clock, now=lambda: cable.now_ns), cable


def run(link: BusLink, cable: CableToSegment, cycles: int) -> None:
    for _ in range(cycles):
        now = link.master.now_ns + CYCLE_NS
        cable.now_ns = max(cable.now_ns, now)
        link.exchange(now)


def test_frames_that_come_within_the_cycle_are_its_inputs() -> None:
    link, cable = bus(20_000)
    link.master.request(AlState.OP)
    run(link, cable, 300)
    assert link.master.operational
    link.master.slaves[0].outputs[:] = b"abcd"
    run(link, cable, 2)
    assert bytes(link.master.slaves[0].inputs) == b"abcd"
    assert 20_000 <= link.round_trips.mean_ns <= link.round_trips.largest_ns < 22_000
    assert link.round_trips.missing == 0


def test_late_frames_are_taken_before_the_next_cycle() -> None:
    """They come after the quarter of a cycle that is waited, and are not lost."""
    link, cable = bus(600_000)
    link.master.request(AlState.OP)
    run(link, cable, 600)
    assert link.master.operational
    assert link.round_trips.count == 0
    assert link.round_trips.missing > 100
    assert link.master.cyclic.counters.lost == 0


def test_frames_later_than_a_cycle_are_lost() -> None:
    link, cable = bus(20_000)
    link.master.request(AlState.OP)
    run(link, cable, 300)
    cable.delay_ns = 3 * CYCLE_NS
    run(link, cable, 10)
    assert not link.master.operational
    assert link.master.cyclic.counters.lost > 5
    cable.delay_ns = 20_000
    run(link, cable, 600)
    assert link.master.operational


def test_steps_alone_on_a_bus() -> None:
    _, cable = bus(20_000)
    assert do_steps(cable, count_slaves(), clock=cable.clock) == 2


def test_steps_that_take_too_long_are_ended() -> None:
    from achse.ethercat.master.steps import Pause, Steps

    def forever() -> Steps[None]:
        while True:
            yield Pause(1_000_000)

    _, cable = bus(20_000)
    with pytest.raises(BusError, match="not done within"):
        do_steps(cable, forever(), timeout_s=0.5, clock=cable.clock)


def between_cycles(link: BusLink, cable: CableToSegment, cycles: int, late_ns: int = 0) -> None:
    """As a station does it: send, and take with the next cycle, which may begin `late_ns` late."""
    for _ in range(cycles):
        now = link.master.now_ns + CYCLE_NS
        cable.now_ns = max(cable.now_ns, now + late_ns)
        link.take(link.master.now_ns)
        link.send(now)


def test_frames_travel_between_the_cycles() -> None:
    for delay_ns in (20_000, 600_000):
        link, cable = bus(delay_ns)
        link.master.request(AlState.OP)
        between_cycles(link, cable, 400)
        assert link.master.operational
        assert link.master.cyclic.counters.lost == 0
        assert delay_ns <= link.round_trips.last_ns < delay_ns + 2000
        assert link.round_trips.missing == 0


@pytest.mark.parametrize("jump_s", [-7200, 7200])
def test_round_trips_are_not_those_of_a_clock_that_jumps(jump_s: int) -> None:
    link, cable = bus(20_000)
    link.master.request(AlState.OP)
    between_cycles(link, cable, 400)
    before = link.round_trips.count
    link._now = lambda: cable.now_ns - jump_s * 1_000_000_000  # then it is put right
    between_cycles(link, cable, 20)
    assert link.round_trips.count == before + 20
    assert 0 <= link.round_trips.last_ns <= link.round_trips.largest_ns <= CYCLE_NS
    assert link.master.operational


@given(st.integers(1, 20), st.integers(0, 400_000))
@settings(max_examples=15)
def test_a_station_that_catches_up_waits_for_its_frames(cycles: int, delay_ns: int) -> None:
    link, cable = bus(20_000)
    link.master.request(AlState.OP)
    between_cycles(link, cable, 400)
    cable.delay_ns = delay_ns
    cable.now_ns += cycles * CYCLE_NS  # held up for so long; what follows begins at once
    between_cycles(link, cable, 40)
    assert link.master.cyclic.counters.lost == 0
    assert link.master.operational


@given(st.lists(st.integers(0, 10**9), max_size=50), st.floats(0, 1))
def test_shares_of_round_trips(times: list[int], share: float) -> None:
    trips = RoundTrips()
    for each in times:
        trips.add(each)
    bound = trips.within_ns(share)
    assert sum(each <= bound for each in times) >= share * len(times) - 1e-6
    assert bound <= max(times, default=0)
    trips.reset()
    assert (trips.count, trips.mean_ns, trips.within_ns(share)) == (0, 0.0, 0)
