"""Smoothing: a curve in place of a corner, within a tolerance (paramVertexSmoothing).

With the corner V, the directions d1 and d2 and the radius R the control points are: parabola
V - R d1, V, V + R d2; cubic with inner points at R/3; quartic (biquadratic) R, R/2, 0; quintic R,
0.6 R, 0.2 R, whose curvature is that of its neighbours. The curve stays in the ball of radius R.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from enum import IntEnum
from math import pi, sin, sqrt

from achse.motion.path.corners import angle_between
from achse.motion.path.geometry import measure_curve, point_at
from achse.motion.path.record import AXES, MAIN_AXES, ElementKind, PathElement, PathState

_LEAST_ANGLE = 1e-6
_MOST_ANGLE = pi - 0.02
"""Nearly a reversal: a curve would have a point where it turns on the spot."""
_LEAST_RADIUS = 1e-6
_TRIES = 40
_LESS = 0.8
_PLACES = 16
"""Parts of a curve at whose ends its distance from the corner's neighbours is looked at."""
_WITHIN = 0.98
"""For what is between them."""


class Smoothing(IntEnum):
    """Kind of curve that rounds a corner."""

    OFF = 0
    BEZIER = 1
    """The older one; as a cubic."""
    PARABOLA = 2
    """Between lines only."""
    BIQUADRATIC = 3
    CUBIC = 4
    QUINTIC = 5


class SmoothingSubtype(IntEnum):
    """Meaning of the radius."""

    RADIUS = 1
    """Radius of the tolerance ball."""
    DISTANCE = 2
    """Distance of the curve from the corner."""
    ADAPTIVE = 3
    """As 1, at most half of the shorter neighbour."""


def smoothing_radius(
    kind: int, subtype: int, radius: float, angle: float, before: float, after: float
) -> float:
    """Return the distance of the curve from the corner, mm; its neighbours limit it."""
    share = 0.5
    apex = 0.1875
    if kind in (Smoothing.PARABOLA, Smoothing.CUBIC, Smoothing.BEZIER):
        apex = 0.25
    if kind == Smoothing.PARABOLA:
        share = 1.0 / 3.0
    if subtype == SmoothingSubtype.DISTANCE and kind != Smoothing.BEZIER:
        radius = radius / (apex * 2.0 * sin(0.5 * angle))  # |d2 - d1| = 2 sin(angle / 2)
    return min(radius, min(share * before, share * after))


def round_corner(
    element: PathElement, curve: PathElement, following: PathElement, state: PathState, room: float
) -> float:
    """Fill in the geometry of the curve between two elements; 0 or what they lose to it, mm.

    `room` is how much the first of them may lose. The elements themselves stay as they are.
    """
    kind = state.smoothing
    a, b = state.before, state.after
    point_at(element, element.length, a)
    point_at(following, 0.0, b)
    angle = angle_between(a, b)
    if kind == Smoothing.OFF or angle < _LEAST_ANGLE or angle > _MOST_ANGLE:
        return 0.0
    lines = element.kind == ElementKind.LINE and following.kind == ElementKind.LINE
    if kind == Smoothing.PARABOLA and not lines:
        return 0.0
    radius = smoothing_radius(
        kind, state.smoothing_subtype, state.smoothing_radius, angle, element.whole, following.whole
    )
    radius = min(radius, room)
    for _ in range(_TRIES):
        if radius < _LEAST_RADIUS:
            return 0.0
        _draw(element, curve, following, state, radius)
        if state.smoothing_subtype != SmoothingSubtype.DISTANCE or lines:
            return radius
        # beside an arc the distance of the printed formula is not exact
        if _deviation(element, curve, following, state, radius) <= state.smoothing_radius * _WITHIN:
            return radius
        radius *= _LESS
    return 0.0


def _deviation(
    element: PathElement,
    curve: PathElement,
    following: PathElement,
    state: PathState,
    radius: float,
) -> float:
    """Return the largest distance of the curve from the places that it replaces."""
    a, b = state.before, state.after
    most = 0.0
    for n in range(1, _PLACES):
        point_at(curve, curve.length * n / _PLACES, a)
        way = 2.0 * radius * n / _PLACES
        if way < radius:
            point_at(element, element.length - radius + way, b)
        else:
            point_at(following, way - radius, b)
        square = 0.0
        for i in range(MAIN_AXES):
            d = a.position[i] - b.position[i]
            square += d * d
        most = max(most, square)
    return sqrt(most)


def _draw(
    element: PathElement,
    curve: PathElement,
    following: PathElement,
    state: PathState,
    radius: float,
) -> None:
    """Fill in the curve that begins and ends at this distance from the corner."""
    kind = state.smoothing
    a, b = state.before, state.after
    point_at(element, element.length - radius, a)
    point_at(following, radius, b)
    c = curve.coefficients
    for i in range(AXES):
        corner = following.begin[i]
        p0, t0, k0 = a.position[i], a.tangent[i], a.bend[i]
        p1, t1, k1 = b.position[i], b.tangent[i], b.bend[i]
        if kind == Smoothing.PARABOLA:
            _powers_of_2(curve, i, p0, corner, p1)
        elif kind == Smoothing.BIQUADRATIC:
            half = 0.5 * radius
            _powers_of_4(curve, i, p0, p0 + half * t0, corner, p1 - half * t1, p1)
        elif kind == Smoothing.QUINTIC:
            near, far = 0.4 * radius, 0.8 * radius
            bend = 0.2 * radius * radius
            _powers_of_5(curve, i, p0, p0 + near * t0, p0 + far * t0 + bend * k0, p1)
            q3, q4 = p1 - far * t1 + bend * k1, p1 - near * t1
            _add_to_5(curve, i, q3, q4)
        else:
            inner = radius * 2.0 / 3.0
            q1, q2 = p0 + inner * t0, p1 - inner * t1
            c[i] = p0
            c[AXES + i] = 3.0 * (q1 - p0)
            c[2 * AXES + i] = 3.0 * (p0 - 2.0 * q1 + q2)
            c[3 * AXES + i] = p1 - p0 + 3.0 * (q1 - q2)
            c[4 * AXES + i] = 0.0
            c[5 * AXES + i] = 0.0
        curve.begin[i] = p0
        curve.end[i] = p1
        curve.slope[i] = 0.0
    curve.kind = ElementKind.CURVE
    curve.turn = 0.0
    measure_curve(curve)
    curve.whole = curve.length


def _powers_of_2(curve: PathElement, i: int, p0: float, p1: float, p2: float) -> None:
    c = curve.coefficients
    c[i] = p0
    c[AXES + i] = 2.0 * (p1 - p0)
    c[2 * AXES + i] = p0 - 2.0 * p1 + p2
    c[3 * AXES + i] = 0.0
    c[4 * AXES + i] = 0.0
    c[5 * AXES + i] = 0.0


def _powers_of_4(
    curve: PathElement, i: int, p0: float, p1: float, p2: float, p3: float, p4: float
) -> None:
    c = curve.coefficients
    c[i] = p0
    c[AXES + i] = 4.0 * (p1 - p0)
    c[2 * AXES + i] = 6.0 * (p0 - 2.0 * p1 + p2)
    c[3 * AXES + i] = 4.0 * (p3 - p0 + 3.0 * (p1 - p2))
    c[4 * AXES + i] = p0 + p4 - 4.0 * (p1 + p3) + 6.0 * p2
    c[5 * AXES + i] = 0.0


def _powers_of_5(curve: PathElement, i: int, p0: float, p1: float, p2: float, p5: float) -> None:
    """Set the powers of a quintic by four control points of six."""
    c = curve.coefficients
    c[i] = p0
    c[AXES + i] = 5.0 * (p1 - p0)
    c[2 * AXES + i] = 10.0 * (p0 - 2.0 * p1 + p2)
    c[3 * AXES + i] = 10.0 * (3.0 * (p1 - p2) - p0)
    c[4 * AXES + i] = 5.0 * (p0 - 4.0 * p1 + 6.0 * p2)
    c[5 * AXES + i] = p5 - p0 + 5.0 * p1 - 10.0 * p2


def _add_to_5(curve: PathElement, i: int, p3: float, p4: float) -> None:
    """Add the shares of the other two control points."""
    c = curve.coefficients
    c[3 * AXES + i] += 10.0 * p3
    c[4 * AXES + i] += 5.0 * (p4 - 4.0 * p3)
    c[5 * AXES + i] += 10.0 * p3 - 5.0 * p4
