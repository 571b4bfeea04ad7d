"""Phasing: the shift follows a jerk-limited profile and stays."""

import itertools
from math import sqrt
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit, commands

V, A, J = 40.0, 200.0, 1000.0


def watch(rig: Any) -> list[float]:
    """The shift in each cycle until the phasing has ended, the present one first."""
    shifts = [rig.axis.phasing_position]
    while rig.axis.phasing_active:
        rig.run(1)
        shifts.append(rig.axis.phasing_position)
        assert rig.has(StateBit.PHASING_ACTIVE) == bool(rig.axis.phasing_active)
    return shifts


def phase(rig: Any, kind: int, shift: float, mask: int = 0) -> int:
    return commands.start_phasing(rig.axis, kind, mask, 0, shift, V, A, A, J)


@pytest.mark.parametrize("shift", [30.0, -30.0, 0.5])
def test_an_absolute_shift(rig: Any, shift: float) -> None:
    assert phase(rig, 1, shift) == 0
    shifts = watch(rig)
    assert shifts[-1] == shift
    # s / v + v / a + a / j with all seven phases, 4 (s / 2j)^(1/3) without v and a at their limits
    way = abs(shift)
    time = way / V + V / A + A / J if way > 10.0 else 4.0 * (way / (2.0 * J)) ** (1.0 / 3.0)
    assert (len(shifts) - 1) * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    speeds = [abs(b - a) / rig.dt for a, b in itertools.pairwise(shifts)]
    assert max(speeds) == pytest.approx(V, rel=1e-6) if way > 10.0 else max(speeds) < V
    rises = [abs(b - a) / rig.dt for a, b in itertools.pairwise(speeds)]
    assert max(rises) <= A * (1.0 + 1e-6)


def test_the_axis_itself_stands(rig: Any) -> None:
    rig.seconds(1.0)
    assert phase(rig, 1, 10.0) == 0
    watch(rig)
    assert rig.axis.set_position == 0.0
    assert rig.has(StateBit.NOT_MOVING)
    assert not rig.has(StateBit.HAS_JOB)


def test_relative_shifts_add_up(rig: Any) -> None:
    for end in (5.0, 10.0, 15.0):
        assert phase(rig, 2, 5.0) == 0
        assert watch(rig)[-1] == pytest.approx(end)
    assert phase(rig, 1, 2.0) == 0
    assert watch(rig)[-1] == 2.0


def test_continuous_update_counts_from_the_begin(rig: Any) -> None:
    for mask, end in ((1, 20.0), (0, None)):
        assert phase(rig, 1, 0.0) == 0
        watch(rig)
        assert phase(rig, 2, 10.0) == 0
        rig.seconds(0.2)
        here = rig.axis.phasing_position
        assert 0.0 < here < 10.0
        assert phase(rig, 2, 20.0, mask) == 0
        assert watch(rig)[-1] == pytest.approx(end or here + 20.0)


def test_a_stop_brakes_the_shift(rig: Any) -> None:
    assert phase(rig, 2, 1000.0) == 0
    rig.seconds(2.0)
    begin = rig.axis.phasing_position
    assert rig.axis.phasing.velocity == pytest.approx(V)
    assert phase(rig, 4096, 0.0) == 0
    shifts = watch(rig)
    # V * J < A²: both jerk phases meet at sqrt(V J), 2 sqrt(V / J) in all
    assert V * J >= A * A
    time = V / A + A / J
    assert (len(shifts) - 1) * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert shifts[-1] - begin == pytest.approx(0.5 * V * time)
    assert phase(rig, 4096, 0.0) == 0  # nothing to stop
    assert watch(rig) == [shifts[-1]]


def test_a_stop_while_it_accelerates(rig: Any) -> None:
    assert phase(rig, 1, 1000.0) == 0
    rig.seconds(0.1)
    v, a = rig.axis.phasing.velocity, rig.axis.phasing.acceleration
    assert a == pytest.approx(J * 0.1)
    assert phase(rig, 4096, 0.0) == 0
    top = v + a * a / (2.0 * J)
    time = a / J + 2.0 * sqrt(top / J)
    assert (len(watch(rig)) - 1) * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.phasing.velocity == 0.0


@pytest.mark.parametrize("master", [1, 0, 9, 255, 256])
def test_its_master_is_an_axis_of_the_nc(rig: Any, master: int) -> None:
    """0 names none; an id that no axis has is unknown."""
    known = master in (0, rig.axis.axis_id)
    code = commands.start_phasing(rig.axis, 1, 0, master, 5.0, V)
    assert code == (0 if known else NcError.AXIS_ID)
