"""Bounds of elements: what they allow keeps every axis in its limits."""

from math import sqrt

import pytest

from achse.motion.path import PathArc, PathLimits, PathLine, PathPlanner, plane_arc

LIMITS = [PathLimits(300.0, 1000.0, 1e6), PathLimits(200.0, 500.0, 1e6), PathLimits(50, 800, 1e6)]


def test_a_line_leaves_all_to_the_velocity() -> None:
    path = PathPlanner(LIMITS, (0, 0, 0))
    path.append(PathLine((30, 40, 0), 1000))
    element = path._elements[0]
    assert element.caps[0] == pytest.approx(250.0)
    assert element.accelerations[0] == pytest.approx(625.0)
    assert element.jerk == pytest.approx(1.25e6)


def test_an_arc_takes_its_share() -> None:
    """Radius 10, 1000 mm/s²: at most 100 mm/s, for which 99 % of the acceleration are used."""
    path = PathPlanner([PathLimits(300.0, 1000.0, 1e7)] * 3, (10, 0, 0))
    path.append(PathArc(plane_arc((10, 0, 0), (10, 0, 0), clockwise=True, centre=(0, 0)), 1000))
    element = path._elements[0]
    assert element.caps[0] == pytest.approx(sqrt(0.99 * 1000.0 * 10.0))
    assert element.decelerations[0] == pytest.approx(1000.0 * sqrt(1 - 0.99**2))
    assert element.rests[0] == pytest.approx(1000.0)
    assert element.jerk > 0.0
