"""The planner beside TOPP-RA: how much longer a path takes than the shortest time there is.

TOPP-RA knows the whole path and no jerk; so the jerk here is high, and what is left is the price of
look-ahead, of cycles, and of bounds that hold for a whole part of a bend.
"""

from collections.abc import Callable
from math import cos, pi, sin
from random import Random
from statistics import median
from typing import Any

import numpy as np
import pytest

from achse.motion.path import (
    PathArc,
    PathLimits,
    PathLine,
    PathParameters,
    PathPlanner,
    Smoothing,
    plane_arc,
)
from achse.motion.path.compiled import KERNEL
from achse.motion.path.geometry import point_at
from achse.motion.path.record import POINT, ElementKind

pytest.importorskip("toppra")

CYCLE = 0.001
PATHS = 5
JERKS = 20_000.0
"""Jerk by acceleration, 1/s: TOPP-RA knows none."""


class Geometry:
    """Elements of a planner as a path of TOPP-RA."""

    def __init__(self, elements: list[Any], axes: int) -> None:
        self.elements, self.dof, self.waypoints = elements, axes, None
        end = elements[-1].first + elements[-1].length
        self.path_interval = np.array([elements[0].first, end])
        self._point = POINT.plain()

    def element(self, way: float) -> Any:
        for element in self.elements:
            if way < element.first + element.length - 1e-12:
                return element
        return self.elements[-1]

    def __call__(self, ways: Any, order: int = 0) -> Any:
        if np.ndim(ways):
            return np.array([self._at(float(way), order) for way in ways])
        return self._at(float(ways), order)

    def _at(self, way: float, order: int) -> Any:
        element = self.element(way)
        point_at(element, min(max(way - element.first, 0.0), element.length), self._point)
        values = (self._point.position, self._point.tangent, self._point.bend)[order]
        return np.array(values[: self.dof])


def shortest(elements: list[Any], axes: list[PathLimits]) -> float:
    """The shortest time from rest to rest, s."""
    import toppra.algorithm
    import toppra.constraint

    path = Geometry(elements, len(axes))
    start, end = path.path_interval
    length = end - start
    grid = [end - length * np.logspace(-6, -2, 20), start + length * np.logspace(-6, -2, 20)]
    for element in elements:
        count = (
            24 if element.kind == ElementKind.CURVE else max(8, int(200 * element.length / length))
        )
        grid.append(element.first + element.length * np.linspace(0.0, 1.0, count + 1))
    ways = np.unique(np.concatenate(grid))
    ways = ways[np.concatenate([[True], np.diff(ways) > 1e-9 * length])]
    ways[0], ways[-1] = start, end

    def velocities(way: float) -> Any:
        limits = np.array([axis.velocity for axis in axes])
        slope = np.abs(path(way, 1))
        n = int(np.argmax(slope))
        limits[n] = min(limits[n], path.element(way).feed * slope[n])
        return np.stack([-limits, limits], 1)

    accelerations = np.array([[-axis.acceleration, axis.acceleration] for axis in axes])
    bounds = [
        toppra.constraint.JointVelocityConstraintVarying(velocities),
        toppra.constraint.JointAccelerationConstraint(accelerations),
    ]
    bounds[1].set_discretization_type(toppra.constraint.DiscretizationType.Collocation)
    solver = toppra.algorithm.TOPPRA(
        bounds, path, gridpoints=ways, parametrizer="ParametrizeConstAccel"
    )
    speeds = solver.compute_parameterization(0.0, 0.0, return_data=True)[1]
    return float(np.sum(2.0 * np.diff(ways) / np.maximum(speeds[1:] + speeds[:-1], 1e-12)))


def drawn(seed: int, smoothing: Smoothing, arcs: float) -> tuple[PathPlanner, list[PathLimits]]:
    draw = Random(seed)
    a = draw.uniform(500.0, 5000.0)
    axes = [
        PathLimits(draw.uniform(100.0, 400.0), a * draw.uniform(0.5, 1.5), a * JERKS)
        for _ in range(3)
    ]
    parameters = PathParameters(smoothing=smoothing, smoothing_radius=draw.uniform(0.1, 3.0))
    path = PathPlanner(
        axes, (0, 0, 0), cycle_time=CYCLE, parameters=parameters, compiled=KERNEL.available
    )
    feed = draw.uniform(50.0, 300.0)
    for _ in range(draw.randint(3, 10)):
        x, y, z = path.programmed_position
        if draw.random() >= arcs:
            size = 10 ** draw.uniform(0.3, 1.8)
            path.append(PathLine([p + draw.uniform(-size, size) for p in (x, y, z)], feed))
            continue
        radius, angle = 10 ** draw.uniform(0.3, 1.7), draw.uniform(0.3, 5.0)
        place, clockwise = draw.uniform(0.0, 2.0 * pi), draw.random() < 0.5
        centre = (x + radius * cos(place), y + radius * sin(place))
        last = place + pi + (-angle if clockwise else angle)
        end = (centre[0] + radius * cos(last), centre[1] + radius * sin(last), z)
        path.append(PathArc(plane_arc((x, y, z), end, clockwise=clockwise, centre=centre), feed))
    return path, axes


def excess(path: PathPlanner, axes: list[PathLimits]) -> float:
    """Duration of the path beyond the shortest, as a part of it."""
    least, group = 0.0, []
    for n in range(path.state.following):
        element = path._elements[n]
        if element.length > 1e-9:
            group.append(element)
        if group and element.junction <= 0.0:
            least += shortest(group, axes)
            group = []
    cycles = 0
    while not path.finished:
        path.advance()
        cycles += 1
    return cycles * CYCLE / least - 1.0


@pytest.mark.parametrize(
    ("smoothing", "arcs", "most"),
    [
        (Smoothing.OFF, 0.0, 0.01),
        (Smoothing.OFF, 0.3, 0.02),
        (Smoothing.QUINTIC, 0.0, 0.05),
        (Smoothing.QUINTIC, 0.3, 0.05),
    ],
)
def test_paths_take_little_more_than_the_shortest_time(
    smoothing: Smoothing, arcs: float, most: float, many: Callable[[int], int]
) -> None:
    results = [excess(*drawn(seed, smoothing, arcs)) for seed in range(many(PATHS))]
    assert median(results) < most
    assert min(results) > -0.01
