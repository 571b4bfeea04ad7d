"""Points turned about an axis keep their distance from it."""

from math import hypot, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.gcode.vectors import PathPoint, cross, dot, turned

COORDINATES = st.floats(-1e3, 1e3)
POINTS = st.tuples(COORDINATES, COORDINATES, COORDINATES)


def length(a: PathPoint) -> float:
    return hypot(*a)


def difference(a: PathPoint, b: PathPoint) -> PathPoint:
    x, y, z = (one - other for one, other in zip(a, b, strict=True))
    return (x, y, z)


def test_a_quarter_about_z_goes_from_x_to_y_and_rises() -> None:
    assert turned((2.0, 1.0, 0.0), (1.0, 1.0, 5.0), (0.0, 0.0, 1.0), pi / 2, 3.0) == pytest.approx(
        (1.0, 2.0, 3.0)
    )


@given(point=POINTS, centre=POINTS, axis=POINTS, angle=st.floats(-10.0, 10.0), rise=COORDINATES)
def test_the_distance_from_the_axis_stays_and_the_height_grows_by_the_rise(
    point: PathPoint, centre: PathPoint, axis: PathPoint, angle: float, rise: float
) -> None:
    size = length(axis)
    if size < 1e-3:
        axis, size = (0.0, 0.0, 1.0), 1.0
    normal = (axis[0] / size, axis[1] / size, axis[2] / size)
    before = difference(point, centre)
    after = difference(turned(point, centre, normal, angle, rise), centre)
    assert length(cross(normal, after)) == pytest.approx(length(cross(normal, before)), abs=1e-6)
    assert dot(normal, after) == pytest.approx(dot(normal, before) + rise, abs=1e-6)
