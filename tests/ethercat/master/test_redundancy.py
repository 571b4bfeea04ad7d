"""Cable redundancy: a cut anywhere keeps all slaves exchanging, and is told."""

from collections.abc import Callable
from itertools import accumulate
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Datagram, EthercatFrame, Loopback, Slave, describe
from achse.ethercat.master import (
    BusConfiguration,
    ClockConfiguration,
    Master,
    Ring,
    from_description,
)
from achse.ethercat.master.redundancy import Redundancy
from achse.ethercat.ring_segment import RingSegment

CYCLE_NS = 1_000_000


class LossyRing(RingSegment):
    """Loses the copies with some numbers; `copies` came so far."""

    copies = hit = 0
    lose: frozenset[int] = frozenset()

    def process_from(self, adapter: int, frame: bytes) -> tuple[bytes, int] | None:
        self.copies += 1
        reply = super().process_from(adapter, frame)
        if self.copies not in self.lose or reply is None:
            return reply
        self.hit += 1
        return None


class RedundantBus:
    """Loopbacks in a ring between two adapters."""

    def __init__(self, count: int, clock: ClockConfiguration | None = None) -> None:
        self.line = [Loopback(serial_number=number) for number in range(count)]
        self.segment = LossyRing(map(Slave, self.line))
        slaves = tuple(
            from_description(describe(each), f"Box {number}", clock=clock)
            for number, each in enumerate(self.line, 1)
        )
        self.master = Master(BusConfiguration(slaves, cycle_ns=CYCLE_NS, redundant=True))
        self.ring = Ring(self.master, self.segment)
        self.master.request(AlState.OP)

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.ring.exchange(self.master.now_ns + CYCLE_NS)

    def until(self, reached: Callable[[], bool], cycles: int = 5000) -> None:
        for _ in range(cycles):
            if reached():
                return
            self.run()
        pytest.fail(f"not within {cycles} cycles: {self.master.take_events()[-5:]}")

    def up(self) -> "RedundantBus":
        self.until(lambda: self.master.operational)
        self.run(10)
        return self

    def cut(self, where: int) -> None:
        """Before slave `where`; behind the last is the second adapter."""
        self.segment.cut(where)

    def mend(self, where: int) -> None:
        self.segment.mend(where)

    def exchanges(self) -> None:
        """All slaves give back what they get."""
        for number, slave in enumerate(self.master.slaves):
            slave.outputs[:] = bytes((number, *self.master.now_ns.to_bytes(8, "little")[2:5]))
        self.run(2)
        for slave in self.master.slaves:
            assert bytes(slave.inputs) == bytes(slave.outputs)
            assert slave.operational

    def kinds(self) -> list[str]:
        return [each.kind.name for each in self.master.take_events()]


@pytest.mark.parametrize("clock", [None, ClockConfiguration()])
@pytest.mark.parametrize("where", range(5))
def test_a_cut_anywhere_loses_no_slave_and_no_cycle(
    where: int, clock: ClockConfiguration | None
) -> None:
    ours = RedundantBus(4, clock).up()
    ours.master.take_events()
    ours.exchanges()
    ours.cut(where)
    before = ours.master.cyclic.counters
    lost, wrong = before.lost, before.wrong
    ours.exchanges()
    assert (before.lost, before.wrong) == (lost, wrong)
    ours.run(300)
    ours.exchanges()
    assert ours.kinds() == ["RING_OPEN"]
    ring = ours.master.redundancy
    assert ring is not None
    assert ring.open
    assert ring.reached == [where, 4 - where]
    job = ours.master.upload(ours.master.slaves[3], 0x1018, 2)
    ours.until(lambda: job.is_done)
    assert job.result() == (0x100B).to_bytes(4, "little")
    ours.mend(where)
    ours.exchanges()
    ours.run(300)
    assert not ring.open
    assert ours.kinds() == ["RING_CLOSED"]
    assert [each.losses for each in ours.master.slaves] == [0] * 4


def test_clocks_behind_the_cut_keep_one_time() -> None:
    ours = RedundantBus(5, ClockConfiguration())
    for number, slave in enumerate(ours.segment.slaves):
        slave.esc.clock.drift_ppb = 20_000 * number
        slave.esc.clock.offset_ns = 10**9 * number
    ours.up().run(500)
    ours.cut(2)
    ours.run(3000)
    now = ours.segment.time.now_ns
    times = [slave.esc.clock.system_time(now) for slave in ours.segment.slaves]
    assert max(times[:2]) - min(times[:2]) < 1000
    assert max(times[2:]) - min(times[2:]) < 1000
    ours.mend(2)
    ours.run(3000)
    now = ours.segment.time.now_ns
    times = [slave.esc.clock.system_time(now) for slave in ours.segment.slaves]
    assert max(times) - min(times) < 1000


def test_a_bus_that_begins_with_an_open_ring_comes_up() -> None:
    ours = RedundantBus(4)
    ours.cut(2)
    ours.up()
    ours.exchanges()
    ours.mend(2)
    ours.run(200)
    ours.exchanges()


def test_a_slave_switched_off_in_an_open_ring_comes_back() -> None:
    ours = RedundantBus(4).up()
    ours.cut(2)
    ours.run(50)
    ours.segment.slaves[3].reset()
    ours.run(3)
    ours.until(lambda: ours.master.operational)
    ours.exchanges()


def test_two_cuts_lose_what_is_between_and_it_comes_back() -> None:
    ours = RedundantBus(5).up()
    ours.cut(1)
    ours.run(20)
    ours.cut(3)
    ours.until(lambda: not ours.master.slaves[1].present)
    assert [each.present for each in ours.master.slaves] == [True, False, False, True, True]
    ours.mend(1)
    ours.until(lambda: ours.master.operational)
    ours.exchanges()


@settings(max_examples=8)
@given(
    happenings=st.lists(
        st.tuples(
            st.sampled_from(["cut", "mend", "reset"]), st.integers(0, 4), st.integers(1, 300)
        ),
        max_size=8,
    )
)
def test_whatever_happens_the_ring_comes_back(happenings: list[tuple[str, int, int]]) -> None:
    ours = RedundantBus(4).up()
    for what, where, cycles in happenings:
        if what == "reset":
            ours.segment.slaves[where % 4].reset()
        elif what == "cut":
            ours.cut(where)
        else:
            ours.mend(where)
        ours.run(cycles)
    for where in range(5):
        ours.mend(where)
    ours.master.request(AlState.OP)
    ours.until(lambda: ours.master.operational, 20_000)
    ours.exchanges()


@settings(max_examples=6)
@given(
    count=st.integers(1, 7),
    clock=st.sampled_from([None, ClockConfiguration()]),
    cuts=st.lists(
        st.tuples(st.integers(0, 7), st.integers(5, 150), st.integers(5, 150)), max_size=4
    ),
    gaps=st.lists(st.integers(8, 300), max_size=8),
)
def test_one_cut_at_a_time_loses_nothing_but_frames_that_are_lost(
    count: int,
    clock: ClockConfiguration | None,
    cuts: list[tuple[int, int, int]],
    gaps: list[int],
) -> None:
    """Any number of slaves; cuts at any place, in any order, for any time; copies lost at any."""
    ours = RedundantBus(count, clock).up()
    ours.master.take_events()
    ring, counters = ours.master.redundancy, ours.master.cyclic.counters
    assert ring is not None
    before = counters.lost + counters.wrong
    copies = ours.segment.copies
    ours.segment.lose = frozenset(copies + number for number in accumulate(gaps))
    expected: list[str] = []
    for place, opened, closed in cuts:
        cable = place % (count + 1)
        line = [
            "the first adapter",
            *(f"Box {n}" for n in range(1, count + 1)),
            "the second adapter",
        ]
        ours.cut(cable)
        ours.run(opened)
        assert ring.open
        assert ring.reached == [cable, count - cable]
        expected.append(f"between {line[cable]} and {line[cable + 1]}")
        ours.mend(cable)
        ours.run(closed)
        assert not ring.open
        expected.append("frames go round the ring again")
    ours.segment.lose = frozenset()
    ours.run(100)
    assert counters.lost + counters.wrong - before <= ours.segment.hit
    assert [each.losses for each in ours.master.slaves] == [0] * count
    assert [each.text for each in ours.master.take_events()] == expected
    ours.exchanges()


@given(seed=st.integers(0, 10**6), size=st.integers(0, 200))
def test_copies_that_are_none_are_counted(seed: int, size: int) -> None:
    dice = Random(seed)
    ring = Redundancy()
    frame = EthercatFrame([Datagram(7, 0, b"\0\0", index=5), Datagram(1, 3, b"ab", 5)]).encode()
    for _ in range(5):
        first, second = ring.copies(frame)
        broken = bytearray(second)
        broken[dice.randrange(len(broken))] ^= 1 << dice.randrange(8)
        for each in (dice.randbytes(size), bytes(broken), first[: dice.randrange(40)], first):
            ring.take(each, dice.randrange(2))
        ring.flush()
    assert len(ring._copies) <= 256
