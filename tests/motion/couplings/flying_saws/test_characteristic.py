"""Characteristic values of a slave that synchronises: each of the 31 numbers, at its place."""

from typing import Any

import pytest

from achse.motion import commands
from achse.motion.couplings.flying_saws.characteristic import characteristic_of, course_of


@pytest.fixture
def rig(make_rig: Any) -> Any:
    rig = make_rig(count=2, max_velocity=1e4, default_acceleration=500.0, default_jerk=5000.0)
    commands.universal_start(rig.nc.axis(1), 3, 0.0, 100.0)
    rig.seconds(2.0)
    return rig


def values(slave: Any) -> list[float]:
    course = course_of(slave)
    assert course is not None
    numbers = characteristic_of(course)
    assert len(numbers) == 64
    assert numbers[31:] == [0.0] * 33
    return numbers


def test_who_does_not_synchronise_has_none(rig: Any) -> None:
    assert course_of(rig.nc.axis(2)) is None


def test_by_position(rig: Any) -> None:
    """200 of the master, 100 of the slave, from rest to its velocity: 3 u⁵ - 7 u⁴ + … is POLY5."""
    master, slave = rig.nc
    here = master.set_position
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, here + 200.0, 100.0) == 0
    for _ in range(3):
        got = values(slave)
        assert got[:11] == pytest.approx(
            [100.0, here, 0.0, 0.0, 0.0, 150.0, here + 200.0, 100.0, 100.0, 0.0, -150.0],
            abs=1e-9,
        )
        assert got[11:15] == pytest.approx([here, 0.0, here, 0.0], abs=1e-9)
        assert got[16] == pytest.approx(0.0, abs=1e-9)
        assert got[18] == pytest.approx(-150.0)
        assert got[20:24] == pytest.approx([here + 200.0, 100.0, here + 200.0, 100.0])
        assert got[24:29] == pytest.approx([here + 100.0, 75.0, 50.0, 150.0, 3750.0], rel=1e-6)
        assert got[29] == pytest.approx(50.0)
        rig.seconds(1.1)  # on its way, and running with its master


def test_in_time(rig: Any) -> None:
    master, slave = rig.nc
    here = master.set_position
    assert commands.synchronise(slave, 5, 1, 0, 0, 1.0) == 0
    got = values(slave)
    assert got[:5] == pytest.approx([100.0, here, 0.0, 0.0, 0.0])
    assert got[6:10] == pytest.approx([here + 30.0, 15.0, 100.0, 0.0], abs=1e-9)
    assert got[25] == pytest.approx(500.0)
    rig.seconds(1.0)
    assert values(slave) == got


def test_a_master_at_rest_counts_as_one(rig: Any) -> None:
    master, slave = rig.nc
    commands.stop(master)
    rig.seconds(2.0)
    here = master.set_position
    assert commands.synchronise(slave, 6, 1, 0, 0, 1.0, here - 200.0, -100.0) == 0
    got = values(slave)
    assert got[:1] + got[6:9] == pytest.approx([-1.0, here - 200.0, -100.0, -1.0])
