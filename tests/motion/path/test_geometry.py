"""Points of elements: derivatives are those of the positions."""

import pytest

from achse.motion.path import PathLimits, PathLine, PathParameters, PathPlanner, Smoothing
from achse.motion.path.geometry import point_at
from achse.motion.path.record import POINT
from achse.motion.path.segments import PathArc, plane_arc

AXES = [PathLimits(100.0, 1000.0, 1e5)] * 4
STEP = 1e-3


@pytest.mark.parametrize("smoothing", list(Smoothing))
def test_derivatives_are_those_of_the_positions(smoothing: Smoothing) -> None:
    parameters = PathParameters(smoothing=smoothing, smoothing_radius=3.0)
    path = PathPlanner(AXES, (0, 0, 0, 0), parameters=parameters)
    path.append(PathLine((20, 5, 1, 3), 100))
    path.append(PathLine((25, -15, 3, 1), 100))
    helix = plane_arc((25, -15, 3), (45, -15, 8), clockwise=False, centre=(35, -15))
    path.append(PathArc(helix, 100, (9.0,)))
    path.append(PathLine((0, 0, 0, 0), 100))
    low, here, high = (POINT.plain() for _ in range(3))
    for number in range(path.state.following):
        element = path._elements[number]
        for n in range(1, 10):
            way = element.length * n / 10
            point_at(element, way - STEP, low)
            point_at(element, way, here)
            point_at(element, way + STEP, high)
            assert sum(x * x for x in here.tangent[:3]) == pytest.approx(1.0, abs=1e-9)
            for i in range(4):
                for value, slope in (
                    ("position", "tangent"),
                    ("tangent", "bend"),
                    ("bend", "twist"),
                ):
                    rise = getattr(high, value)[i] - getattr(low, value)[i]
                    assert getattr(here, slope)[i] == pytest.approx(
                        rise / (2 * STEP), rel=1e-4, abs=1e-4
                    )
