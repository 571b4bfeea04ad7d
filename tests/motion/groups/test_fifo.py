"""FIFO groups: rows at equal times, overrides, stops; oracles are closed forms."""

import random
from math import exp
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion.groups.states import FifoInterpolation, FifoOverrideType, SafState

ANY = list(FifoInterpolation)


def ready(rig: Any, *rows: float, axes: tuple[int, ...] = (1, 2)) -> Any:
    """The FIFO with rows for the first axis; the other has none of its own."""
    assert rig.fifo.assign(axes) == 0
    assert rig.fifo.write([x for row in rows for x in (row, 0.0)]) == 0
    return rig.fifo


def test_velocity_is_way_by_time(make_groups: Any) -> None:
    """Rows 0, 0.1, 0.3 at 2 ms are 50 and 100 mm/s."""
    rig = make_groups()
    assert ready(rig, 0.0, 0.1, 0.3).start() == 0
    seen = []
    for _ in range(3):
        rig.run()
        seen += [rig.axis(1).set_position, rig.axis(1).set_velocity]
    assert seen == pytest.approx([0.1, 50.0, 0.3, 100.0, 0.3, 0.0])


@pytest.mark.parametrize("override", [1.0, 0.5, 0.25])
def test_a_row_may_be_longer_than_a_cycle(make_groups: Any, override: float) -> None:
    rig = make_groups(time_delta=0.01)
    group = ready(rig, 0.0, 1.0)
    group.override = round(override * 1e6)
    assert group.start() == 0
    for n in range(1, round(5 / override) + 1):
        rig.run()
        assert rig.axis(1).set_position == pytest.approx(0.2 * override * n)
    rig.run(3)
    assert rig.axis(1).set_position == 1.0
    assert rig.axis(1).set_velocity == 0.0


def test_a_pt2_override_has_two_equal_poles(make_groups: Any) -> None:
    """1 - (1 + t/T0) e^(-t/T0): 0.264241118 after T0, 0.593994150 after 2 T0."""
    rig = make_groups(time_delta=1.0, length=100)
    group = ready(rig, *range(20))
    group.override_type, group.override_time = FifoOverrideType.PT2, 0.1
    group.start()
    place, t, lag = 0.0, 0.0, 0.1
    for n in range(1, 200):
        rig.run()
        t = n * rig.dt
        place = t - 2 * lag + (2 * lag + t) * exp(-t / lag)  # integral of the step answer
        assert rig.axis(1).set_position == pytest.approx(place, abs=1e-12)
        if n == 50:
            assert group._pace == pytest.approx(0.264241118)
        if n == 100:
            assert group._pace == pytest.approx(0.593994150)
    group.override_type = FifoOverrideType.INSTANTANEOUS
    rig.run()
    assert group._pace == 1.0


@pytest.mark.parametrize("kind", ANY)
def test_every_interpolation_goes_through_its_rows(make_groups: Any, kind: Any) -> None:
    """At random: rows are met, what is left is counted, axes never jump; both kernels alike."""
    source = random.Random(f"fifo {kind}")
    for _ in range(6):
        count = source.randrange(1, 30)
        stretch = source.randrange(1, 6)
        rows = [0.0]
        for _ in range(count):
            rows.append(rows[-1] + source.uniform(-1.0, 1.0))
        rig = make_groups(interpolation=kind, time_delta=0.002 * stretch)
        group = ready(rig, *rows)
        assert group.start() == 0
        for n in range(1, count * stretch + 1):
            rig.run()
            if n % stretch == 0:
                assert rig.axis(1).set_position == pytest.approx(rows[n // stretch], abs=1e-9)
                assert group.saf_entry_count == count - n // stretch
        rig.run(4)
        assert rig.axis(1).set_position == rows[-1]
        assert not rig.axis(1).error_code


def test_rows_may_come_while_it_runs(make_groups: Any) -> None:
    rig = make_groups()
    group = ready(rig, 0.0, 0.1)
    group.start()
    for n in range(2, 400):
        assert group.write([n * 0.1, 0.0]) == 0
        rig.run()
        assert rig.axis(1).set_position == pytest.approx((n - 1) * 0.1)
    assert len(group._rows) < 10


@pytest.mark.parametrize("kind", ANY)
def test_overwritten_rows_leave_the_running_interval_as_it_is(make_groups: Any, kind: Any) -> None:
    rig = make_groups(interpolation=kind, time_delta=0.01)
    group = ready(rig, *(0.1 * n for n in range(50)))
    group.start()
    rig.run(52)
    before = rig.axis(1).set_position
    behind = {0: 1, 1: 2, 4: 3}[kind]
    next_row = 10 + behind + 1
    assert group.overwrite([x for n in range(20) for x in (0.1 * (next_row + n), 5.0)]) == 0
    rig.run(1)
    assert rig.axis(1).set_position == pytest.approx(before + 0.02)
    assert rig.axis(1).set_velocity == pytest.approx(10.0)
    assert group.overwrite([0.0] * 2 * 251) == NcError.TABLE_FIFO_OVERWRITE


def test_a_stop_brakes_no_harder_than_the_axes_want(make_groups: Any) -> None:
    rig = make_groups(values={"default_deceleration": 500.0})
    group = ready(rig, *(0.2 * n for n in range(249)))
    group.start()
    rig.run(50)
    assert rig.axis(1).set_velocity == pytest.approx(100.0)
    assert group.stop() == 0
    before = rig.axis(1).set_velocity
    assert group.saf_state is SafState.STOPPING
    while group.moving:
        rig.run()
        now = rig.axis(1).set_velocity
        assert 0.0 <= before - now <= 500.0 * rig.dt * 1.01
        before = now
    rest = rig.axis(1).set_position
    assert group.start() == 0
    rig.run(1)
    assert rig.axis(1).set_position == pytest.approx(rest + 0.2)
    group.clear()
    rig.until(lambda: not group.moving)
    assert group.saf_entry_count == 0
    assert group.start() == NcError.TABLE_FIFO_EMPTY


def test_an_axis_that_is_too_slow_ends_it(make_groups: Any) -> None:
    rig = make_groups()
    group = ready(rig, 0.0, 1.0, 1000.0, 1001.0)
    group.start()
    rig.until(lambda: not group.moving)
    assert group.error_code == NcError.SET_VELOCITY_TOO_HIGH
    assert group.start() == NcError.SET_VELOCITY_TOO_HIGH
    rig.until(lambda: rig.axis(1).set_velocity == 0.0)
    group.reset()
    rig.run()
    assert (group.error_code, rig.axis(1).error_code) == (0, 0)


def test_both_kernels_do_the_same(make_groups: Any) -> None:
    source = random.Random(7)
    rows = [0.0]
    for _ in range(100):
        rows.append(rows[-1] + source.uniform(0.0, 0.5))
    digests = set()
    for compiled in (False, True):
        rig = make_groups(compiled=compiled, interpolation=FifoInterpolation.CUBIC_SPLINE)
        group = ready(rig, *rows)
        group.start()
        rig.run(60)
        group.stop()
        rig.run(100)
        digests.add(rig.nc.digest())
    assert len(digests) == 1


def test_why_it_does_not_start(make_groups: Any) -> None:
    rig = make_groups()
    assert rig.fifo.start() == NcError.GROUP_NOT_READY
    group = ready(rig, 0.5)
    assert group.start() == NcError.START_NOT_ON_CONTOUR
    group.clear()
    group.write([0.0, 0.0])
    group.time_delta = 0.0
    assert group.start() == NcError.FIFO_TIME_UNIT
    group.time_delta = 0.001
    rig.axis(2).control_dword = 0
    rig.run()
    assert group.start() == NcError.CONTROLLER_ENABLE_MISSING
    rig.axis(2).control_dword = 7
    rig.run(3)
    assert group.start() == 0
    assert group.start() == NcError.GROUP_BUSY
