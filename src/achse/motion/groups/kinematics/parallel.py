"""Parallel kinematics in a plane: two arms turn about feet on X, two rods join their ends.

Numbers: distance of the feet, which are at -d/2 and d/2; length of the arms; length of the rods.
Angles count from X; the tool, where the rods meet, is on the side of positive Y of the arms' ends.
Further axes are the places themselves.
"""

from collections.abc import MutableSequence, Sequence
from math import acos, atan2, cos, degrees, dist, radians, sin, sqrt

_NEAR = 1e-6
"""Of a rod: how far the tool may be from where the angles have it."""


def forward(numbers: Sequence[float], axes: Sequence[float], places: MutableSequence[float]) -> int:
    """Compute the point where the rods meet; none if the arms' ends are too far apart."""
    half = 0.5 * numbers[0]
    x1 = -half + numbers[1] * cos(radians(axes[0]))
    y1 = numbers[1] * sin(radians(axes[0]))
    x2 = half + numbers[1] * cos(radians(axes[1]))
    y2 = numbers[1] * sin(radians(axes[1]))
    across = sqrt((x2 - x1) * (x2 - x1) + (y2 - y1) * (y2 - y1))
    if across == 0.0 or across > 2.0 * numbers[2]:
        return 0
    height = sqrt(numbers[2] * numbers[2] - 0.25 * across * across)
    for n in range(len(axes)):
        places[n] = axes[n]
    places[0] = 0.5 * (x1 + x2) - height * (y2 - y1) / across
    places[1] = 0.5 * (y1 + y2) + height * (x2 - x1) / across
    return 1


def _angle(arm: float, rod: float, x: float, y: float, outward: float) -> float:
    """Angle of an arm whose rod reaches (x, y) from its foot; 1000 for none."""
    reach = sqrt(x * x + y * y)
    if reach == 0.0 or arm <= 0.0:
        return 1000.0
    bend = (arm * arm + reach * reach - rod * rod) / (2.0 * arm * reach)
    if bend > 1.0 + 1e-12 or bend < -1.0 - 1e-12:
        return 1000.0
    bend = 1.0 if bend > 1.0 else -1.0 if bend < -1.0 else bend
    return degrees(atan2(y, x) + outward * acos(bend))


def inverse(numbers: Sequence[float], places: Sequence[float], axes: MutableSequence[float]) -> int:
    """Angles of the arms, with elbows outwards, turns as they are.

    None where the tool would be on the other side of the arms' ends: with the same angles it is on
    this one.
    """
    half = 0.5 * numbers[0]
    left = _angle(numbers[1], numbers[2], places[0] + half, places[1], 1.0)
    right = _angle(numbers[1], numbers[2], places[0] - half, places[1], -1.0)
    if left > 900.0 or right > 900.0:
        return 0
    for n in range(2, len(places)):
        axes[n] = places[n]
    axes[0] = left + 360.0 * float(round((axes[0] - left) / 360.0))
    axes[1] = right + 360.0 * float(round((axes[1] - right) / 360.0))
    back = [0.0] * len(places)
    if not forward(numbers, axes, back):
        return 0
    return 1 if dist(back[:2], places[:2]) <= _NEAR * numbers[2] else 0
