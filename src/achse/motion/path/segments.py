"""Segments that a path is made of: lines, arcs and helices, dwell times.

Positions are absolute, in mm, of as many axes as the path has: X, Y, Z, then auxiliary axes. A
segment begins where the one before ends.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, isfinite, pi, sin, sqrt

Vector = tuple[float, float, float]

_MAIN_AXES = 3


class PathError(ValueError):
    """A segment that cannot be; the text says what was expected and what came."""


@dataclass(frozen=True, slots=True)
class Plane:
    """The two axes of an arc, in the order in which an anticlockwise arc turns: 0 X, 1 Y, 2 Z."""

    first: int
    second: int

    @property
    def normal(self) -> int:
        """The third axis, along which a helix rises."""
        return 3 - self.first - self.second


PLANE_XY = Plane(0, 1)
PLANE_ZX = Plane(2, 0)
PLANE_YZ = Plane(1, 2)


@dataclass(frozen=True, slots=True)
class PathLine:
    """A straight line; auxiliary axes go with it in proportion. `feed` in mm/s along X, Y, Z.

    If X, Y, Z do not move, `feed` is that of the auxiliary axes together.
    """

    end: Sequence[float]
    feed: float
    block: int = 0
    """Number that is shown while the path is there; any 63-bit number."""
    exact_stop: bool = False
    """Rest at its end (G9, G60)."""
    start_feed: float | None = None
    """Feed at its beginning, from where it changes evenly with the way; None: as at its end."""


@dataclass(frozen=True, slots=True)
class PathArc:
    """An arc, or a helix if it rises along its axis: see `plane_arc` and `arc_through`."""

    geometry: "ArcGeometry"
    feed: float
    auxiliary: Sequence[float] = ()
    """Ends of the auxiliary axes, which go in proportion to the way. Empty: they stay."""
    block: int = 0
    exact_stop: bool = False
    start_feed: float | None = None


@dataclass(frozen=True, slots=True)
class PathDwell:
    """Rest for a time, s (G4)."""

    time: float
    block: int = 0


PathSegment = PathLine | PathArc | PathDwell


@dataclass(frozen=True, slots=True)
class ArcGeometry:
    """An arc in space: centre, the vector from there to the start, the one a quarter turn further.

    `angle` in rad, above 0; `rise` is the way along the axis, a vector.
    """

    centre: Vector
    first_radius: Vector
    second_radius: Vector
    angle: float
    rise: Vector = (0.0, 0.0, 0.0)

    @property
    def radius(self) -> float:
        return sqrt(sum(x * x for x in self.first_radius))

    @property
    def length(self) -> float:
        return hypot(self.radius * self.angle, *self.rise)

    @property
    def start(self) -> Vector:
        c, r = self.centre, self.first_radius
        return c[0] + r[0], c[1] + r[1], c[2] + r[2]

    @property
    def end(self) -> Vector:
        c, s = cos(self.angle), sin(self.angle)
        x, y, z = (
            centre + first * c + second * s + rise
            for centre, first, second, rise in zip(
                self.centre, self.first_radius, self.second_radius, self.rise, strict=True
            )
        )
        return x, y, z

    def part(self, number: int, count: int) -> "ArcGeometry":
        """One of `count` equal parts, from 0 on; of one part the arc itself."""
        if count == 1:
            return self
        angle = self.angle / count
        c, s = cos(number * angle), sin(number * angle)
        first, second = self.first_radius, self.second_radius
        share, rise = number / count, self.rise
        return ArcGeometry(
            _vector([a + share * b for a, b in zip(self.centre, rise, strict=True)]),
            _vector([a * c + b * s for a, b in zip(first, second, strict=True)]),
            _vector([b * c - a * s for a, b in zip(first, second, strict=True)]),
            angle,
            (rise[0] / count, rise[1] / count, rise[2] / count),
        )


_SAME = 1e-9
_RADIUS_ERROR = 0.01
"""Radii at start and end may differ by this, relative; the centre is moved then (CPCON)."""


def plane_arc(
    start: Sequence[float],
    end: Sequence[float],
    *,
    plane: Plane = PLANE_XY,
    clockwise: bool,
    centre: tuple[float, float] | None = None,
    radius: float | None = None,
    turns: int = 0,
    correct_centre: bool = True,
) -> ArcGeometry:
    """Return the arc (G2, G3) between points X, Y, Z; a difference along the plane's normal is a
    helix.

    `centre` is absolute, in the plane's axes; or `radius`, negative for an arc of more than half a
    turn. `turns` are whole turns besides. An end that is the start is a full circle. PathError if
    there is no such arc: the radii at start and end differ by more than 1 % (without
    `correct_centre` by more than 1e-9), or the radius is less than half the distance.
    """
    _check_numbers("arc", (*start[:3], *end[:3], *(centre or ()), radius or 0.0))
    u, w = plane.first, plane.second
    x0, y0, x1, y1 = start[u], start[w], end[u], end[w]
    if (centre is None) == (radius is None):
        raise PathError("arc: expected either a centre or a radius")
    distance = hypot(x1 - x0, y1 - y0)
    if radius is not None:
        cx, cy = _centre_of(x0, y0, x1, y1, radius, clockwise)
    else:
        assert centre is not None
        cx, cy = centre
        r0, r1 = hypot(x0 - cx, y0 - cy), hypot(x1 - cx, y1 - cy)
        most = _RADIUS_ERROR if correct_centre else _SAME
        if min(r0, r1) <= 0.0 or abs(r0 - r1) > most * max(r0, 1.0):
            raise PathError(f"arc: radius {r0:g} at its start, {r1:g} at its end")
        if distance > 0.0:
            # to the nearest place on the middle line
            nx, ny = (x1 - x0) / distance, (y1 - y0) / distance
            off = (cx - 0.5 * (x0 + x1)) * nx + (cy - 0.5 * (y0 + y1)) * ny
            cx, cy = cx - off * nx, cy - off * ny
    ax, ay = x0 - cx, y0 - cy
    sense = -1.0 if clockwise else 1.0
    angle = sense * (atan2(y1 - cy, x1 - cx) - atan2(ay, ax)) % (2.0 * pi)
    if distance <= _SAME * max(1.0, abs(x0), abs(y0)):
        angle = 2.0 * pi
    angle += 2.0 * pi * turns
    first, second, middle, rise = ([0.0] * 3 for _ in range(4))
    first[u], first[w] = ax, ay
    second[u], second[w] = -sense * ay, sense * ax
    middle[u], middle[w], middle[plane.normal] = cx, cy, start[plane.normal]
    rise[plane.normal] = end[plane.normal] - start[plane.normal]
    return ArcGeometry(_vector(middle), _vector(first), _vector(second), angle, _vector(rise))


def _centre_of(
    x0: float, y0: float, x1: float, y1: float, radius: float, clockwise: bool
) -> tuple[float, float]:
    distance = hypot(x1 - x0, y1 - y0)
    if distance <= _SAME:
        raise PathError("arc: a full circle has a centre, not a radius")
    square = radius * radius - 0.25 * distance * distance
    if square < -_SAME * radius * radius:
        raise PathError(f"arc: radius {radius:g}, expected at least {0.5 * distance:g}")
    off = sqrt(max(square, 0.0)) / distance
    if clockwise != (radius < 0.0):
        off = -off
    return 0.5 * (x0 + x1) - off * (y1 - y0), 0.5 * (y0 + y1) + off * (x1 - x0)


def arc_through(
    start: Sequence[float], middle: Sequence[float], end: Sequence[float]
) -> ArcGeometry:
    """Return the arc in space (CIP) from start through middle to end; PathError for points in a
    line."""
    _check_numbers("arc", (*start[:3], *middle[:3], *end[:3]))
    p, q, r = (_vector(point) for point in (start, middle, end))
    a, b = _minus(q, p), _minus(r, p)
    normal = _cross(a, b)
    square = _dot(normal, normal)
    if square <= (_SAME * max(_dot(a, a), _dot(b, b))) ** 2 or square == 0.0:
        raise PathError("arc through three points: they are in a line")
    to = _cross(normal, a)
    other = _cross(b, normal)
    centre = _vector(
        [p[i] + (_dot(b, b) * to[i] + _dot(a, a) * other[i]) / (2.0 * square) for i in range(3)]
    )
    first = _minus(p, centre)
    size = sqrt(square)
    unit = (normal[0] / size, normal[1] / size, normal[2] / size)
    second = _cross(unit, first)
    last = _minus(r, centre)
    angle = atan2(_dot(last, second), _dot(last, first)) % (2.0 * pi)
    return ArcGeometry(centre, first, second, angle)


def _check_numbers(what: str, numbers: Sequence[float]) -> None:
    for number in numbers:
        if not isfinite(number):
            raise PathError(f"{what}: {number} is not a position")


def _vector(numbers: Sequence[float]) -> Vector:
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def rapid_feed(
    begin: Sequence[float], end: Sequence[float], velocities: Sequence[float | None]
) -> float:
    """Return the feed of a line at which the first axis has its velocity, mm/s; None limits
    nothing.

    X, Y, Z come first. 1 where nothing moves.
    """
    ways = [abs(b - a) for a, b in zip(begin, end, strict=True)]
    length = hypot(*ways[:_MAIN_AXES]) or hypot(*ways)
    feeds = [
        velocity * length / way
        for velocity, way in zip(velocities, ways, strict=False)
        if velocity is not None and way > 0.0
    ]
    return min(feeds, default=1.0)
