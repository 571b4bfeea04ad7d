"""Two arms and two rods in a plane."""

import pytest

from achse.motion.groups.kinematics.parallel import forward, inverse

NUMBERS = [200.0, 250.0, 400.0]


def test_a_symmetric_pose() -> None:
    """Arms upright: their ends are 200 apart, the rods make a triangle over them."""
    places = [0.0] * 2
    assert forward(NUMBERS, [90.0, 90.0], places)
    assert places == pytest.approx([0.0, 250.0 + (400.0**2 - 100.0**2) ** 0.5])


def test_out_of_reach() -> None:
    assert not inverse(NUMBERS, [0.0, 900.0], [90.0, 90.0])
    assert not forward([2000.0, 250.0, 400.0], [90.0, 90.0], [0.0, 0.0])
