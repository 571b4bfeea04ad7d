"""Delta robots."""

import pytest

from achse.motion.groups.kinematics.delta import forward, inverse

NUMBERS = [200.0, 50.0, 300.0, 700.0]


def test_equal_angles_are_in_the_middle() -> None:
    places = [0.0] * 3
    assert forward(NUMBERS, [0.0, 0.0, 0.0], places)
    assert places == pytest.approx([0.0, 0.0, -((700.0**2 - 450.0**2) ** 0.5)], abs=1e-9)


def test_the_arm_towards_the_place_is_lower() -> None:
    axes = [0.0] * 3
    assert inverse(NUMBERS, [50.0, 0.0, -600.0], axes)
    assert axes[1] == pytest.approx(axes[2])
    assert axes[0] != pytest.approx(axes[1])


def test_out_of_reach() -> None:
    assert not inverse(NUMBERS, [0.0, 0.0, -2000.0], [0.0] * 3)
    assert not inverse(NUMBERS, [0.0, 900.0, -300.0], [0.0] * 3)
    assert not forward([200.0, 50.0, 300.0, 10.0], [0.0, 40.0, 80.0], [0.0] * 3)
