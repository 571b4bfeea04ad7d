"""Points of an element of the path, with their derivatives by the way along it.

Kernel source: compiled as it stands, see `achse.motion.path.compiled`.
"""

from math import cos, sin, sqrt

from achse.motion.path.record import AXES, KNOTS, MAIN_AXES, ElementKind, PathElement, PathPlace

_NODES = (
    -0.9061798459386640,
    -0.5384693101056831,
    0.0,
    0.5384693101056831,
    0.9061798459386640,
)
"""Gauss-Legendre, five places."""
_WEIGHTS = (
    0.2369268850561891,
    0.4786286704993665,
    0.5688888888888889,
    0.4786286704993665,
    0.2369268850561891,
)
_STEPS = 8
"""Newton steps from a way to a parameter; three or four suffice."""
_TINY = 1e-15


def point_at(element: PathElement, way: float, point: PathPlace) -> None:
    """Put the point at a way (0..length) from the beginning of the element into `point`."""
    if element.kind == ElementKind.CURVE:
        curve_point(element, _parameter(element, way), point)
        return
    for i in range(AXES):
        point.position[i] = element.begin[i] + element.slope[i] * way
        point.tangent[i] = element.slope[i]
        point.bend[i] = 0.0
        point.twist[i] = 0.0
    if element.kind == ElementKind.ARC:
        turn = element.turn
        c = cos(turn * way)
        s = sin(turn * way)
        for i in range(MAIN_AXES):
            x = element.first_radius[i]
            y = element.second_radius[i]
            point.position[i] = element.centre[i] + x * c + y * s + element.slope[i] * way
            point.tangent[i] = turn * (y * c - x * s) + element.slope[i]
            point.bend[i] = -turn * turn * (x * c + y * s)
            point.twist[i] = -turn * turn * turn * (y * c - x * s)


def _speed(element: PathElement, u: float) -> float:
    """Way by parameter of a curve."""
    square = 0.0
    for i in range(MAIN_AXES):
        d = _slope(element, i, u)
        square += d * d
    return sqrt(square)


def _slope(element: PathElement, i: int, u: float) -> float:
    c = element.coefficients
    d = 5.0 * c[5 * AXES + i]
    d = d * u + 4.0 * c[4 * AXES + i]
    d = d * u + 3.0 * c[3 * AXES + i]
    d = d * u + 2.0 * c[2 * AXES + i]
    return d * u + c[AXES + i]


def _way_between(element: PathElement, u: float, v: float) -> float:
    half = 0.5 * (v - u)
    middle = 0.5 * (u + v)
    total = 0.0
    for n in range(5):
        total += _WEIGHTS[n] * _speed(element, middle + half * _NODES[n])
    return half * total


def measure_curve(element: PathElement) -> None:
    """Fill in `ways` and `length` of a curve."""
    way = 0.0
    element.ways[0] = 0.0
    for n in range(KNOTS - 1):
        way += _way_between(element, n / (KNOTS - 1.0), (n + 1) / (KNOTS - 1.0))
        element.ways[n + 1] = way
    element.length = way


def _parameter(element: PathElement, way: float) -> float:
    """Parameter of a curve at a way from its beginning."""
    if way <= 0.0:
        return 0.0
    if way >= element.length:
        return 1.0
    n = 0
    while n < KNOTS - 2 and element.ways[n + 1] <= way:
        n += 1
    low = n / (KNOTS - 1.0)
    high = (n + 1) / (KNOTS - 1.0)
    share = (way - element.ways[n]) / (element.ways[n + 1] - element.ways[n])
    u = low + share * (high - low)
    for _ in range(_STEPS):
        error = way - element.ways[n] - _way_between(element, low, u)
        step = error / _speed(element, u)
        u = min(max(u + step, low), high)
        if abs(step) < _TINY:
            break
    return u


def curve_point(element: PathElement, u: float, point: PathPlace) -> None:
    """Put the point of a curve at a parameter, 0..1, into `point`."""
    c = element.coefficients
    for i in range(AXES):
        c0, c1, c2 = c[i], c[AXES + i], c[2 * AXES + i]
        c3, c4, c5 = c[3 * AXES + i], c[4 * AXES + i], c[5 * AXES + i]
        point.position[i] = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
        point.tangent[i] = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))
        point.bend[i] = 2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))
        point.twist[i] = 6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)
    # by the parameter so far; now by the way
    g = along = square = onward = 0.0
    for i in range(MAIN_AXES):
        g += point.tangent[i] * point.tangent[i]
        along += point.tangent[i] * point.bend[i]
        square += point.bend[i] * point.bend[i]
        onward += point.tangent[i] * point.twist[i]
    speed = sqrt(g)
    first = 1.0 / speed
    second = -along / (g * g)
    third = (4.0 * along * along / g - square - onward) / (g * g * speed)
    for i in range(AXES):
        d1, d2, d3 = point.tangent[i], point.bend[i], point.twist[i]
        point.tangent[i] = d1 * first
        point.bend[i] = d2 * first * first + d1 * second
        point.twist[i] = d3 * first * first * first + 3.0 * d2 * first * second + d1 * third
