"""Cartesian portals."""

import pytest

from achse.motion.groups.kinematics.portal import forward, inverse


def test_zeros_directions_and_a_leaning_axis() -> None:
    places = [0.0] * 4
    assert forward([1.0, 2.0, 3.0, 1.0, -1.0, 1.0, 0.0], [10.0, 10.0, 10.0, 7.0], places)
    assert places == [11.0, -8.0, 13.0, 7.0]
    assert forward([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 30.0], [0.0, 10.0, 0.0, 0.0], places)
    assert places[:2] == pytest.approx([5.0, 8.660254038])


def test_where_there_is_no_solution() -> None:
    axes = [0.0] * 4
    assert not inverse([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 90.0], [1.0] * 4, axes)
    assert not inverse([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0], [1.0] * 4, axes)
