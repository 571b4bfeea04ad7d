"""Canonical commands: lengths, planes, points on the way."""

from math import pi

import pytest

from achse.gcode.canon import ArcMove, LineMove, Origin, PathPlane

ORIGIN = Origin("part.nc", 1, 0, 10, 1)
STILL = (0.0,) * 5


def arc(normal: tuple[float, float, float], angle: float, rise: float = 0.0) -> ArcMove:
    return ArcMove(
        ORIGIN,
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (5.0, 0.0, 0.0),
        normal,
        angle,
        rise,
        STILL,
        10.0,
        10.0,
    )


def test_lengths_of_the_facts() -> None:
    half = arc((0.0, 0.0, -1.0), pi)
    assert half.length == pytest.approx(15.707963268)
    assert arc((0.0, 0.0, -1.0), pi, -5.0).length == pytest.approx(16.484541547)
    line = LineMove(ORIGIN, (0.0, 0.0, 0.0), (3.0, 4.0, 12.0), STILL, 10.0, 10.0)
    assert line.length == 13.0
    assert line.at(0.5) == (1.5, 2.0, 6.0)


def test_a_half_circle_goes_through_its_top() -> None:
    assert arc((0.0, 0.0, -1.0), pi).at(0.5) == pytest.approx((5.0, 5.0, 0.0))
    assert arc((0.0, 0.0, -1.0), pi, -5.0).at(1.0) == pytest.approx((10.0, 0.0, 5.0))


def test_arcs_know_their_plane() -> None:
    assert arc((0.0, 0.0, -1.0), pi).plane is PathPlane.XY
    assert arc((0.0, 0.0, -1.0), pi).clockwise
    assert arc((0.0, 1.0, 0.0), pi).plane is PathPlane.ZX
    assert not arc((0.0, 1.0, 0.0), pi).clockwise
    assert arc((-1.0, 0.0, 0.0), pi).plane is PathPlane.YZ
    assert arc((0.0, 0.6, 0.8), pi).plane is None


@pytest.mark.parametrize("plane", PathPlane)
def test_the_axes_of_a_plane_are_right_handed(plane: PathPlane) -> None:
    first, second, third = plane.axes
    assert (second - first) % 3 == 1
    assert (third - second) % 3 == 1
