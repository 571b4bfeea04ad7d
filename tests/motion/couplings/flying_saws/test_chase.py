"""Run up to a target that moves: limits are kept in every cycle, and the target is met."""

from math import sin
from typing import Any

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from achse.motion.couplings.flying_saws.chase import (
    approach_place,
    approach_velocity,
    limits_beside,
)
from achse.motion.record import SlotsRecord

DT = 0.002


def slave(**values: float) -> Any:
    """Return a slave with these values of its parts: `sync_jerk` is that of its synchronisation."""
    record = SlotsRecord()
    record.sync.acceleration = record.sync.deceleration = 500.0
    record.sync.jerk = 5000.0
    for name, value in values.items():
        part, _, own = name.partition("_")
        setattr(getattr(record, part), own, value)
    return record


def test_a_constant_target_is_met_as_fast_as_can_be() -> None:
    """Δv = 100, a = 500, j = 5000: 0.3 s, 15 of way."""
    ax = slave(sync_pursued_velocity=100.0)
    cycles = 1
    while not approach_velocity(ax, 100.0, 0.0, 0.0, 100.0 * DT, False, DT):
        cycles += 1
    assert cycles * DT == pytest.approx(0.3, abs=1.01 * DT)
    after = 100.0 * (cycles * DT - 0.3)
    assert ax.set.position - after == pytest.approx(15.0, abs=1e-9)
    assert (ax.set.velocity, ax.set.acceleration) == (100.0, 0.0)


def test_without_jerk_the_way_is_that_of_the_acceleration() -> None:
    """Δv = 100, a = 500: 0.2 s and 10 of way."""
    ax = slave(sync_pursued_velocity=100.0, sync_jerk=1e12)
    cycles = 1
    while not approach_velocity(ax, 100.0, 0.0, 0.0, 100.0 * DT, False, DT):
        cycles += 1
    assert ax.set.position - 100.0 * (cycles * DT - 0.2) == pytest.approx(10.0, abs=1e-6)


@pytest.mark.parametrize(
    ("velocity", "target", "wanted"),
    [(10.0, 20.0, 300.0), (20.0, 10.0, 200.0), (-10.0, 20.0, 200.0), (0.0, 5.0, 300.0)],
)
def test_which_limit_counts(velocity: float, target: float, wanted: float) -> None:
    ax = slave(set_velocity=velocity, sync_acceleration=300.0, sync_deceleration=200.0)
    assert limits_beside(ax, target, 0.0, 0.0) == (wanted, 5000.0)
    assert limits_beside(ax, target, -50.0, 1000.0) == (wanted - 50.0, 4000.0)
    assert limits_beside(ax, target, 1e9, 1e9) == (pytest.approx(0.05 * wanted), 250.0)


LIMIT = st.floats(100.0, 5000.0)


@settings(max_examples=40, deadline=None)
@given(
    start=st.floats(-300.0, 300.0), wanted=st.floats(-300.0, 300.0),
    acceleration=LIMIT, deceleration=LIMIT, jerk=st.floats(500.0, 1e6),
    swing=st.floats(0.0, 1.0), pace=st.floats(0.1, 20.0), calm=st.integers(0, 500),
    place=st.booleans(), offset=st.floats(-200.0, 200.0), noisy=st.booleans(),
)  # fmt: skip
@example(
    start=0.0, wanted=4.0, acceleration=100.0, deceleration=100.0, jerk=8000.0, swing=1.0, pace=1.0,
    calm=8, place=False, offset=0.0, noisy=False,
)  # fmt: skip
def test_limits_are_kept_whatever_the_target_does(
    start: float, wanted: float, acceleration: float, deceleration: float, jerk: float,
    swing: float, pace: float, calm: int, place: bool, offset: float, noisy: bool,
) -> None:  # fmt: skip
    """The target swings for a while, also faster than the slave may; then it keeps its velocity."""
    assume(not (place and noisy))
    if place:
        deceleration = acceleration
    ax = slave(
        set_velocity=start, sync_acceleration=acceleration, sync_deceleration=deceleration,
        sync_jerk=jerk, sync_offset=offset,
    )  # fmt: skip
    target, before, met = 0.0, wanted, False
    ax.sync.pursued_velocity = wanted
    largest = max(acceleration, deceleration)
    for n in range(30000):
        now = wanted * (1.0 + (swing * sin(pace * DT * (n + 1)) if n < calm else 0.0))
        way, rising = 0.5 * (now + before) * DT, (now - before) / DT
        before = now
        target += way
        s, v, a = ax.set.position, ax.set.velocity, ax.set.acceleration
        if place:
            met = approach_place(ax, now, rising, 0.0, way, 1000.0, DT)
            assert ax.sync.offset == pytest.approx(ax.set.position + offset - target, abs=1e-6)
        else:
            met = approach_velocity(ax, now, rising, 0.0, way, noisy, DT)
        assert abs(ax.set.acceleration) <= largest * (1 + 1e-9) + 1e-9
        assert abs(ax.set.acceleration - a) <= jerk * DT * (1 + 1e-9) + 1e-6
        assert abs(ax.set.velocity - v) <= largest * DT * (1 + 1e-9) + 1e-6
        fastest = max(abs(v), abs(ax.set.velocity)) + largest * DT
        assert abs(ax.set.position - s) <= fastest * DT + 1e-9
        if met and n >= calm:
            break
    assert met
    if place:
        assert ax.sync.offset == pytest.approx(0.0, abs=1e-6)
    if not noisy:
        assert ax.set.velocity == pytest.approx(wanted, abs=1e-9)
