"""From the workpiece to the axes: mirror, rotation, zero shift, tool; and back.

axes = shift + rotation · mirror · programmed + tool. A rotation turns about the origin that the
zero shifts make; first about Z, then Y, then X, each about an axis that does not move: the matrix
is Rx·Ry·Rz. The tool's length and offsets are along the machine's axes, whatever the rotation.
Source: tf5100, rotation.
"""

from dataclasses import dataclass, field
from math import cos, radians, sin

from achse.gcode.vectors import PathPoint

_Matrix = tuple[PathPoint, PathPoint, PathPoint]

UNTURNED: _Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ORIGIN = (0.0, 0.0, 0.0)


def rotation(angles: PathPoint) -> _Matrix:
    """Rx·Ry·Rz for angles about X, Y and Z in degrees; quarter turns are exact."""
    (a, b), (c, d), (e, f) = (_cos_sin(angle) for angle in angles)
    return (
        (c * e, -c * f, d),
        (b * d * e + a * f, a * e - b * d * f, -b * c),
        (b * f - a * d * e, a * d * f + b * e, a * c),
    )


def _cos_sin(angle: float) -> tuple[float, float]:
    quarters, rest = divmod(angle, 90.0)
    if rest:
        return cos(radians(angle)), sin(radians(angle))
    return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]


@dataclass(frozen=True, slots=True)
class WorkFrame:
    """Position and rotation of the workpiece. All lengths in mm."""

    shift: PathPoint = _ORIGIN
    turn: _Matrix = UNTURNED
    mirror: PathPoint = (1.0, 1.0, 1.0)
    """1 or -1 for each axis."""
    tool: PathPoint = _ORIGIN
    is_translation: bool = field(init=False)
    """True without rotation and mirror."""

    def __post_init__(self) -> None:
        is_translation = self.turn is UNTURNED and self.mirror == (1.0, 1.0, 1.0)
        object.__setattr__(self, "is_translation", is_translation)

    def to_axes(self, point: PathPoint) -> PathPoint:
        """Positions of the axes for a point of the workpiece."""
        x, y, z = point if self.is_translation else self.turned(point)
        (a, b, c), (d, e, f) = self.shift, self.tool
        return (x + a + d, y + b + e, z + c + f)

    def turned(self, vector: PathPoint) -> PathPoint:
        """Return a direction of the workpiece as one of the axes."""
        x, y, z = (value * sign for value, sign in zip(vector, self.mirror, strict=True))
        (a, b, c), (d, e, f), (g, h, i) = self.turn
        return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)

    def to_work(self, axes: PathPoint) -> PathPoint:
        """Return the point of the workpiece at positions of the axes."""
        x, y, z = (
            value - shift - tool
            for value, shift, tool in zip(axes, self.shift, self.tool, strict=True)
        )
        if self.is_translation:
            return (x, y, z)
        (a, b, c), (d, e, f), (g, h, i) = self.turn
        u, v, w = self.mirror
        return (
            u * (a * x + d * y + g * z),
            v * (b * x + e * y + h * z),
            w * (c * x + f * y + i * z),
        )

    @property
    def flips(self) -> bool:
        """True if the mirror exchanges left and right."""
        u, v, w = self.mirror
        return u * v * w < 0.0
