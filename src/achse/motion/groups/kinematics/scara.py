"""SCARA with two joints: an arm that turns about its foot, and one that turns about its end.

Numbers: lengths of the first and second arm. The first angle counts from X, the second from the
first arm. Further axes are the places themselves.
"""

from collections.abc import MutableSequence, Sequence
from math import acos, atan2, copysign, cos, degrees, radians, sin, sqrt


def forward(numbers: Sequence[float], axes: Sequence[float], places: MutableSequence[float]) -> int:
    """Compute the end of the second arm."""
    for n in range(len(axes)):
        places[n] = axes[n]
    first = radians(axes[0])
    second = radians(axes[0] + axes[1])
    places[0] = numbers[0] * cos(first) + numbers[1] * cos(second)
    places[1] = numbers[0] * sin(first) + numbers[1] * sin(second)
    return 1


def inverse(numbers: Sequence[float], places: Sequence[float], axes: MutableSequence[float]) -> int:
    """Angles of the arms, the elbow on the side where it is, turns as they are."""
    x = places[0]
    y = places[1]
    reach = sqrt(x * x + y * y)
    both = 2.0 * numbers[0] * numbers[1]
    if both <= 0.0:
        return 0
    bend = (reach * reach - numbers[0] * numbers[0] - numbers[1] * numbers[1]) / both
    if bend > 1.0 + 1e-12 or bend < -1.0 - 1e-12 or reach == 0.0:
        return 0
    bend = 1.0 if bend > 1.0 else -1.0 if bend < -1.0 else bend
    elbow = copysign(acos(bend), axes[1])  # stretched, -0.0 keeps the side
    shoulder = atan2(y, x) - atan2(numbers[1] * sin(elbow), numbers[0] + numbers[1] * bend)
    angle = degrees(shoulder)
    angle += 360.0 * float(round((axes[0] - angle) / 360.0))
    for n in range(2, len(places)):
        axes[n] = places[n]
    axes[0] = angle
    axes[1] = degrees(elbow)
    return 1
