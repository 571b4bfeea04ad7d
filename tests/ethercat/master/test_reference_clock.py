"""The reference clock: time goes on when its slave is gone, is back, or jumps."""

from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from achse.ethercat.master import ClockConfiguration

MOVED_BY_A_FRAME = 1_000
"""ns: a frame without time moves each clock by so much at most."""


_SETTINGS = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    max_examples=4,
    phases=[Phase.explicit, Phase.reuse, Phase.generate],  # each example is 400 cycles of a bus
)


def _clock_bus(
    bus: Callable[..., Any], offsets: list[int], drifts: list[int], hop: int = 500
) -> Any:
    ours = bus(len(drifts), {"clock": ClockConfiguration()}, drift_telegrams=200)
    ours.segment.hop_ns = hop
    ours.segment._route()
    for slave, offset, drift in zip(ours.segment.slaves, offsets, drifts, strict=False):
        slave.esc.clock.offset_ns, slave.esc.clock.drift_ppb = offset, drift
    ours.up()
    ours.run(100)
    ours.kinds()
    return ours


def _times(ours: Any) -> list[int]:
    now = ours.segment.time.now_ns
    return [slave.esc.clock.system_time(now) for slave in ours.segment.slaves]


@_SETTINGS
@given(
    offsets=st.lists(st.integers(-(10**12), 10**12), min_size=4, max_size=4),
    drifts=st.lists(st.integers(-50_000, 50_000), min_size=2, max_size=4),
    away=st.integers(1, 40),
    leaves=st.integers(0, 3),
    hop=st.integers(50, 2_000),
)
def test_time_of_the_bus_goes_on_when_a_slave_leaves_and_returns(
    bus: Callable[..., Any],
    offsets: list[int],
    drifts: list[int],
    away: int,
    leaves: int,
    hop: int,
) -> None:
    ours = _clock_bus(bus, offsets, drifts, hop)
    line = ours.segment.slaves
    gone = line[leaves % len(line)]
    others = [number for number, slave in enumerate(line) if slave is not gone]
    begin_ns, begin = ours.segment.time.now_ns, _times(ours)

    def check() -> None:
        passed = ours.segment.time.now_ns - begin_ns
        times = _times(ours)
        for number in others:
            error = times[number] - begin[number] - passed
            assert abs(error) <= 3 * MOVED_BY_A_FRAME + passed // 10_000 + 2 * hop, error

    for _ in range(away):
        gone.reset()
        ours.run()
        check()
    for _ in range(300):
        ours.run()
        check()
    assert ours.master.operational
    assert ours.master.supervision.reference == 1001
    times = _times(ours)
    assert max(times) - min(times) <= 1_000


def test_the_next_clock_is_the_reference_until_the_first_is_back(bus: Callable[..., Any]) -> None:
    ours = _clock_bus(bus, [0, 0, 0], [10_000, -20_000, 30_000])
    for _ in range(20):
        ours.segment.slaves[0].reset()
        ours.run()
    assert ours.master.supervision.reference == 1002
    event = next(e for e in ours.master.take_events() if e.kind.name == "REFERENCE")
    assert event.text == ("Box 1 does not answer with its time: Box 2 is the reference now")
    assert event.station == 1002
    ours.run(300)
    assert ours.master.supervision.reference == 1001


def test_a_slave_that_answers_without_its_time_is_replaced(bus: Callable[..., Any]) -> None:
    ours = _clock_bus(bus, [0, 0], [0, 0])
    cyclic, segment = ours.master.cyclic, ours.segment
    passes = segment._pass_time

    def without_the_first(addressed: Any, *more: Any) -> int:
        mute = [slave for slave in addressed if slave is not segment.slaves[0]]
        count: int = passes(mute, *more)
        return count

    segment._pass_time = without_the_first
    ours.until(lambda: ours.master.supervision.reference == 1002, 50)
    ours.run(5)
    assert not cyclic.reference_lost
    assert "REFERENCE" in ours.kinds()


@_SETTINGS
@given(
    jump=st.one_of(st.integers(600_000, 10**15), st.integers(-(10**15), -600_000)),
    drifts=st.lists(st.integers(-50_000, 50_000), min_size=1, max_size=3),
    later=st.integers(0, 130),
)
def test_a_jump_of_the_reference_is_taken_out(
    bus: Callable[..., Any], jump: int, drifts: list[int], later: int
) -> None:
    ours = _clock_bus(bus, [0] * 4, drifts)
    ours.run(later)
    begin_ns, begin = ours.segment.time.now_ns, _times(ours)
    ours.segment.slaves[0].esc.clock.jump(jump)
    ours.run(400)
    passed = ours.segment.time.now_ns - begin_ns
    times = _times(ours)
    assert max(times) - min(times) <= 1_000
    assert abs(times[0] - begin[0] - passed) <= 50_000
    events = [each for each in ours.master.take_events() if each.kind.name == "REFERENCE"]
    assert len(events) == 1
    assert abs(events[0].number - jump) <= 50_000


def test_a_reading_that_was_late_once_is_no_jump(bus: Callable[..., Any]) -> None:
    ours = _clock_bus(bus, [0], [0])
    clock = ours.segment.slaves[0].esc.clock
    clock.jump(3_000_000)
    ours.until(lambda: ours.master.supervision._clock.doubted)
    clock.jump(-3_000_000)
    ours.run(300)
    assert "REFERENCE" not in ours.kinds()
