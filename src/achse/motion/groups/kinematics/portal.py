"""Cartesian portals: X, Y and Z carry each other; each has a zero and a direction of its own.

Numbers: zero and direction (1 or -1) of X, Y and Z, then the angle by which Y leans towards X.
Further axes are the places themselves.
"""

from collections.abc import MutableSequence, Sequence
from math import cos, radians, sin


def forward(numbers: Sequence[float], axes: Sequence[float], places: MutableSequence[float]) -> int:
    """Compute the place of the tool."""
    for n in range(len(axes)):
        places[n] = axes[n]
    x = numbers[0] + numbers[3] * axes[0]
    y = numbers[1] + numbers[4] * axes[1]
    lean = radians(numbers[6])
    places[0] = x + y * sin(lean)
    places[1] = y * cos(lean)
    places[2] = numbers[2] + numbers[5] * axes[2]
    return 1


def inverse(numbers: Sequence[float], places: Sequence[float], axes: MutableSequence[float]) -> int:
    """Compute the positions of the axes; an angle of 90° has no solution."""
    lean = radians(numbers[6])
    if abs(cos(lean)) < 1e-9 or numbers[3] * numbers[4] * numbers[5] == 0.0:
        return 0
    for n in range(len(places)):
        axes[n] = places[n]
    y = places[1] / cos(lean)
    axes[0] = (places[0] - y * sin(lean) - numbers[0]) / numbers[3]
    axes[1] = (y - numbers[1]) / numbers[4]
    axes[2] = (places[2] - numbers[2]) / numbers[5]
    return 1
