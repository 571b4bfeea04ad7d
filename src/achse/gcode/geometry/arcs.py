"""Circles: centre from a radius, from three points, corrected centres."""

from math import atan2, hypot, pi, sqrt

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.vectors import PathPoint, cross, dot

PlanePoint = tuple[float, float]
"""First and second axis of a plane, mm."""

SAME_POINT = 1e-9
"""mm: an end this near to the start is the start."""


def swept(start: PlanePoint, end: PlanePoint, centre: PlanePoint, clockwise: bool) -> float:
    """Angle turned from start to end, rad, 0 < angle <= 2π; equal points make a full circle."""
    if hypot(end[0] - start[0], end[1] - start[1]) <= SAME_POINT:
        return 2.0 * pi
    a, b = start[0] - centre[0], start[1] - centre[1]
    c, d = end[0] - centre[0], end[1] - centre[1]
    angle = atan2(a * d - b * c, a * c + b * d)
    if clockwise:
        angle = -angle
    return angle if angle > 0.0 else angle + 2.0 * pi


def centre_of_radius(
    start: PlanePoint, end: PlanePoint, radius: float, clockwise: bool
) -> PlanePoint:
    """Return the centre of an arc given by its radius; a negative one takes the long way round."""
    u, v = end[0] - start[0], end[1] - start[1]
    chord = hypot(u, v)
    if chord <= SAME_POINT:
        raise WordRefused(
            NcError.CIRCLE_NOT_COMPUTABLE, "a full circle needs its centre, not a radius"
        )
    half = chord / 2.0
    square = radius * radius - half * half
    if square < 0.0:
        if half - abs(radius) > 1e-6 * half:
            raise WordRefused(
                NcError.CIRCLE_NOT_COMPUTABLE,
                f"radius {abs(radius):g} mm cannot reach from start to end, {chord:g} mm apart",
            )
        square = 0.0
    height = sqrt(square) / chord
    if clockwise == (radius > 0.0):
        height = -height
    return (start[0] + u / 2.0 - v * height, start[1] + v / 2.0 + u * height)


def corrected_centre(
    start: PlanePoint, end: PlanePoint, centre: PlanePoint, correct: bool
) -> PlanePoint:
    """A centre with equal distance to start and end: the nearest one (CPCON).

    With CPCOF a difference of the radii is refused, unless it comes from rounding.
    """
    first = hypot(start[0] - centre[0], start[1] - centre[1])
    last = hypot(end[0] - centre[0], end[1] - centre[1])
    if first <= SAME_POINT:
        raise WordRefused(NcError.CIRCLE_NOT_COMPUTABLE, "the centre is the start: radius 0")
    if not correct and abs(first - last) > 1e-3:
        raise WordRefused(
            NcError.CIRCLE_NOT_COMPUTABLE,
            f"radius {first:g} mm at the start, {last:g} mm at the end (CPCOF)",
        )
    u, v = end[0] - start[0], end[1] - start[1]
    square = u * u + v * v
    if square <= SAME_POINT * SAME_POINT:
        return centre
    x, y = centre[0] - (start[0] + end[0]) / 2.0, centre[1] - (start[1] + end[1]) / 2.0
    share = (x * u + y * v) / square
    return (centre[0] - share * u, centre[1] - share * v)


def circle_in_space(
    start: PathPoint, middle: PathPoint, end: PathPoint
) -> tuple[PathPoint, PathPoint, float]:
    """Centre, unit normal and angle of the arc from start over middle to end (CIP)."""
    a = (middle[0] - start[0], middle[1] - start[1], middle[2] - start[2])
    b = (end[0] - start[0], end[1] - start[1], end[2] - start[2])
    axis = cross(a, b)
    area = hypot(*axis)
    if area <= 1e-9 * hypot(*a) * hypot(*b) or area == 0.0:
        raise WordRefused(
            NcError.CIRCLE_NOT_COMPUTABLE, "the three points of a circle are on one line"
        )
    normal = (axis[0] / area, axis[1] / area, axis[2] / area)
    aa, bb = dot(a, a), dot(b, b)
    first, second = cross(b, axis), cross(axis, a)
    share = 2.0 * area * area
    arm = tuple((aa * first[i] + bb * second[i]) / share for i in range(3))
    centre = (start[0] + arm[0], start[1] + arm[1], start[2] + arm[2])
    from_centre = (-arm[0], -arm[1], -arm[2])
    to_end = (end[0] - centre[0], end[1] - centre[1], end[2] - centre[2])
    angle = atan2(dot(normal, cross(from_centre, to_end)), dot(from_centre, to_end))
    return centre, normal, angle if angle > 0.0 else angle + 2.0 * pi
