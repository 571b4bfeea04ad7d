"""Points in space: products, and turning about an axis."""

from math import cos, sin
from typing import TypeAlias

PathPoint: TypeAlias = tuple[float, float, float]
"""X, Y, Z in mm; or a direction without unit."""


def dot(a: PathPoint, b: PathPoint) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: PathPoint, b: PathPoint) -> PathPoint:
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def turned(
    point: PathPoint, centre: PathPoint, normal: PathPoint, angle: float, rise: float
) -> PathPoint:
    """Return the point turned about an axis through `centre`, and moved along the axis by
    `rise`."""
    x, y, z = (a - b for a, b in zip(point, centre, strict=True))
    arm = (x, y, z)
    side = cross(normal, arm)
    along = dot(normal, arm)
    c, s = cos(angle), sin(angle)
    lift = along * (1.0 - c) + rise
    u, v, w = (
        centre[each] + arm[each] * c + side[each] * s + normal[each] * lift for each in range(3)
    )
    return (u, v, w)
