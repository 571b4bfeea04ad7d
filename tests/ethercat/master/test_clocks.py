"""Clocks: whatever offset and drift, slaves come to the bus time, SYNC0 comes where it was set."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.ethercat.master import ClockConfiguration
from achse.ethercat.master.clocks import ClockWatch, bound_of, difference_of


def test_differences_have_a_sign_bit() -> None:
    assert difference_of(5) == 5
    assert difference_of(0x8000_0005) == -5


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=10)
@given(
    offsets=st.lists(st.integers(-(10**12), 10**12), min_size=2, max_size=5),
    drift=st.integers(-100_000, 100_000),
    shift=st.one_of(st.none(), st.integers(0, 999_999)),
)
def test_slaves_come_to_one_time(
    bus: Callable[..., Any], offsets: list[int], drift: int, shift: int | None
) -> None:
    clock = ClockConfiguration(shift_ns=shift)
    ours = bus(len(offsets), {"clock": clock}, drift_telegrams=100)
    for slave, offset in zip(ours.segment.slaves, offsets, strict=True):
        slave.esc.clock.offset_ns = offset
        slave.esc.clock.drift_ppb = drift
    ours.up()
    ours.run(200)
    now = ours.segment.time.now_ns
    times = [slave.esc.clock.system_time(now) for slave in ours.segment.slaves]
    assert max(times) - min(times) <= 2000
    reference = times[0]
    wanted = ours.ring.master.bus.cycle_ns // 2 if shift is None else shift
    for slave in ours.segment.slaves:
        clock = slave.esc.clock
        assert clock.cycle_ns == 1_000_000
        assert clock.sync0_due_ns is not None
        phase = (reference + clock.sync0_due_ns - now - wanted) % 1_000_000
        assert min(phase, 1_000_000 - phase) <= 4000
    assert ours.master.slaves[0].output_shift_ns == wanted
    assert ours.master.supervision.reference == 1001


def test_a_clock_that_does_not_settle_is_reported_and_the_slave_goes_on(
    bus: Callable[..., Any],
) -> None:
    ours = bus(2, {"clock": ClockConfiguration()}, settle_ns=50_000_000, clock_window_ns=100)
    ours.segment.slaves[1].esc.clock.jitter_ns = 1_000_000
    ours.segment.slaves[1].esc.clock.drift_ppb = 1_050_000
    ours.up()
    assert "CLOCK" in ours.kinds()


@pytest.mark.parametrize("activate", [0x0300, 0x0700])
def test_sync1_is_set_as_configured(bus: Callable[..., Any], activate: int) -> None:
    ours = bus(1, {"clock": ClockConfiguration(activate, 2_000_000, 500_000)}).up()
    registers = ours.segment.slaves[0].esc.read(0x09A0, 8)
    assert registers == (2_000_000).to_bytes(4, "little") + (500_000).to_bytes(4, "little")
    assert ours.segment.slaves[0].esc.read(0x0980, 2) == activate.to_bytes(2, "little")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=5)
@given(
    drifts=st.lists(st.integers(-100_000, 100_000), min_size=2, max_size=6),
    hop=st.integers(50, 5_000),
    jitter=st.integers(0, 40),
    shift=st.integers(0, 999_999),
    telegrams=st.sampled_from([0, 1_000, 2_700]),
)
def test_clocks_of_any_drift_run_together(
    bus: Callable[..., Any], drifts: list[int], hop: int, jitter: int, shift: int, telegrams: int
) -> None:
    """Each slave drifts by itself, cables have any length, receive times jitter."""
    clock = ClockConfiguration(shift_ns=shift)
    ours = bus(len(drifts), {"clock": clock}, drift_telegrams=telegrams)
    ours.segment.hop_ns = hop
    ours.segment._route()
    for slave, drift in zip(ours.segment.slaves, drifts, strict=True):
        slave.esc.clock.drift_ppb = drift
        slave.esc.clock.jitter_ns = jitter
    ours.up()
    # receive times of 32 bits run at the slave's own speed: of a delay that is nothing
    for number, slave in enumerate(ours.master.slaves):
        assert abs(slave.facts.delay_ns - number * hop) <= 2 * jitter * number + 1 + number
    for _ in range(5):
        ours.run(100)
        now = ours.segment.time.now_ns
        times = [slave.esc.clock.system_time(now) for slave in ours.segment.slaves]
    # a clock 200 ppm away runs 200 ns ahead in a cycle, until the next telegram brings it back
    apart = max(drifts) - min(drifts)
    assert max(times) - min(times) <= apart // 1000 * 2 + 4 * jitter * len(drifts) + 400
    differences = [abs(each.clock_difference_ns) for each in ours.master.slaves[1:]]
    assert max(differences) <= apart // 1000 * 2 + 4 * jitter * len(drifts) + 400
    for slave in ours.segment.slaves:
        due = slave.esc.clock.sync0_due_ns
        assert due is not None
        phase = (times[0] + due - now - shift) % 1_000_000
        assert min(phase, 1_000_000 - phase) <= 4000


def test_the_time_is_sent_in_bursts_before_the_start(bus: Callable[..., Any]) -> None:
    without = bus(2, {"clock": ClockConfiguration()}, drift_telegrams=0)
    sent = []
    for ours in (without, bus(2, {"clock": ClockConfiguration()}, drift_telegrams=1_010)):
        ours.until(lambda ours=ours: ours.master.supervision.cyclic_on)
        sent.append(ours.segment.counters.frames)
    assert 51 <= sent[1] - sent[0] <= 60  # those between are of the watch on states


@given(st.lists(st.lists(st.integers(-300, 300), min_size=2, max_size=2), max_size=40))
def test_a_clock_is_apart_after_three_readings_in_a_row(readings: list[list[int]]) -> None:
    watch = ClockWatch(200)
    rows, apart = [0, 0], [False, False]
    for reading in readings:
        for position, difference in enumerate(reading):
            rows[position] = rows[position] + 1 if abs(difference) > 200 else 0
            message = watch.take(position, difference)
            wanted = rows[position] >= 3
            assert message is (wanted if wanted != apart[position] else None)
            apart[position] = wanted
        assert watch.calm == (rows == [0, 0])
    watch.forget(0)
    watch.forget(1)
    assert watch.calm


@given(st.lists(st.integers(-(2**31) + 1, 2**31 - 1), min_size=1, max_size=5))
def test_no_clock_is_further_away_than_the_bound(differences: list[int]) -> None:
    together = 0
    for each in differences:
        together |= abs(each) | (each < 0) << 31
    assert bound_of(together.to_bytes(4, "little")) >= max(map(abs, differences))
