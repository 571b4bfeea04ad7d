"""Trapezoidal profiles against their equations."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.drive.profile import follow, plan, ramp_velocity, rate_of, stop
from achse.drive.record import DriveSlots

rates = st.floats(1e3, 1e8)
speeds = st.floats(1e2, 1e7)


def _planned(
    start: float, target: float, end: float, velocity: float, up: float, down: float
) -> DriveSlots:
    record = DriveSlots()
    record.demand_velocity = start
    plan(record, target, end, velocity, up, down)
    return record


@given(st.floats(-1e7, 1e7), speeds, rates, rates)
def test_from_rest_to_rest(target: float, velocity: float, up: float, down: float) -> None:
    record = _planned(0.0, target, 0.0, velocity, up, down)
    total = sum(record.plan_time[: record.plan_count])
    peak = min(velocity, math.sqrt(2 * up * down / (up + down) * abs(target)))
    if peak > 1e-6:
        ramps = peak * peak / 2 * (1 / up + 1 / down)
        expected = peak / up + peak / down + (abs(target) - ramps) / peak
        assert total == pytest.approx(expected, rel=1e-9, abs=1e-9)
    left = follow(record, total + 1.0)
    assert left == pytest.approx(1.0)
    assert (record.demand, record.demand_velocity) == (target, 0.0)


@given(st.floats(-1e6, 1e6), st.floats(-1e7, 1e7), speeds, rates, rates, st.integers(1, 50))
def test_from_any_velocity_within_the_limits(
    start: float, target: float, velocity: float, up: float, down: float, parts: int
) -> None:
    """Position and velocity stay continuous, the last part meets the target by itself."""
    record = _planned(start, target, 0.0, velocity, up, down)
    total = sum(record.plan_time[: record.plan_count])
    if total == 0.0:
        return
    before, speed, dt = 0.0, start, total * 0.999999 / parts
    for _ in range(parts):
        assert follow(record, dt) == -1.0
        assert abs(record.demand_velocity - speed) <= max(up, down) * dt * (1 + 1e-9) + 1e-6
        assert abs(record.demand_velocity) <= max(velocity, abs(start)) * (1 + 1e-9)
        speed = record.demand_velocity
        before = record.demand
    assert before == pytest.approx(target, abs=1e-3 * (1 + abs(target) + abs(start)))


@given(st.floats(1.0, 1e6), speeds, st.floats(0.0, 1e6), rates, rates)
def test_an_end_velocity_is_met_as_far_as_possible(
    target: float, velocity: float, end: float, up: float, down: float
) -> None:
    record = _planned(0.0, target, end, velocity, up, down)
    reachable = math.sqrt(2 * up * target)
    follow(record, sum(record.plan_time[: record.plan_count]) + 1e-9)
    assert record.demand == target
    assert record.demand_velocity == pytest.approx(min(end, velocity, reachable), rel=1e-6)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), rates, rates, st.floats(1e-4, 1.0))
def test_ramps(start: float, target: float, up: float, down: float, dt: float) -> None:
    record = DriveSlots()
    record.demand_velocity = start
    ramp_velocity(record, target, up, down, dt)
    if min(start, target) < 0 < max(start, target):
        needed = abs(start) / down + abs(target) / up
    else:
        needed = abs(target - start) / (down if abs(target) < abs(start) else up)
    if dt >= needed:
        rounding = (up + down) * dt * 1e-12
        assert record.demand_velocity == pytest.approx(target, rel=0.0, abs=rounding)
    else:
        assert record.demand_velocity != target
        low, high = sorted((start, target))
        assert low <= record.demand_velocity <= high


def test_a_ramp_covers_the_way_of_its_triangle() -> None:
    record = DriveSlots()
    record.demand_velocity = 1000.0
    stop(record, 2000.0, 2.0)
    assert (record.demand, record.demand_velocity) == (pytest.approx(250.0), 0.0)


def test_one_long_step_is_many_short_ones() -> None:
    whole, parts = (_planned(300.0, 5000.0, 0.0, 800.0, 900.0, 1100.0) for _ in range(2))
    follow(whole, 4.0)
    for _ in range(4000):
        follow(parts, 0.001)
    assert parts.demand == pytest.approx(whole.demand)
    assert parts.demand_velocity == pytest.approx(whole.demand_velocity, abs=1e-6)


def test_rates_are_limited_and_never_nothing() -> None:
    assert [rate_of(0, 10), rate_of(5, 10), rate_of(50, 10)] == [1.0, 5.0, 10.0]


def test_no_velocity_is_no_motion() -> None:
    record = _planned(0.0, 100.0, 0.0, 0.0, 1.0, 1.0)
    follow(record, 10.0)
    assert record.demand == pytest.approx(0.0, abs=1e-6)
