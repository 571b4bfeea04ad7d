"""Delta robots: three arms turn about the sides of a base and carry a plate by rods.

Numbers: radius of the base (its middle to an arm's axis), radius of the plate, length of the arms,
length of the rods. Arm 1 is over X, the others 120° and 240° on. An angle counts from the
horizontal, positive downwards; Z points up, so the plate is at negative Z. Further axes are the
places themselves.
"""

from collections.abc import MutableSequence, Sequence
from math import atan2, cos, degrees, dist, radians, sin, sqrt

_NEAR = 1e-6
"""Of a rod: how far the plate may be from where the angles have it."""


def forward(numbers: Sequence[float], axes: Sequence[float], places: MutableSequence[float]) -> int:
    """Return the lower point in which three spheres about the arms' ends meet."""
    out = numbers[0] - numbers[1]
    rod = numbers[3]
    r1 = out + numbers[2] * cos(radians(axes[0]))
    z1 = -numbers[2] * sin(radians(axes[0]))
    r2 = out + numbers[2] * cos(radians(axes[1]))
    z2 = -numbers[2] * sin(radians(axes[1]))
    r3 = out + numbers[2] * cos(radians(axes[2]))
    z3 = -numbers[2] * sin(radians(axes[2]))
    x2 = r2 * cos(radians(120.0))
    y2 = r2 * sin(radians(120.0))
    x3 = r3 * cos(radians(240.0))
    y3 = r3 * sin(radians(240.0))
    w1 = r1 * r1 + z1 * z1
    w2 = x2 * x2 + y2 * y2 + z2 * z2
    w3 = x3 * x3 + y3 * y3 + z3 * z3
    det = 4.0 * ((x2 - r1) * y3 - (x3 - r1) * y2)
    if abs(det) < 1e-12:
        return 0
    # x = ax z + bx and y = ay z + by are where all three are equally far
    ax = -4.0 * ((z2 - z1) * y3 - (z3 - z1) * y2) / det
    bx = 2.0 * ((w2 - w1) * y3 - (w3 - w1) * y2) / det
    ay = -4.0 * ((x2 - r1) * (z3 - z1) - (x3 - r1) * (z2 - z1)) / det
    by = 2.0 * ((x2 - r1) * (w3 - w1) - (x3 - r1) * (w2 - w1)) / det
    a = ax * ax + ay * ay + 1.0
    b = 2.0 * (ax * (bx - r1) + ay * by - z1)
    c = (bx - r1) * (bx - r1) + by * by + z1 * z1 - rod * rod
    inside = b * b - 4.0 * a * c
    if inside < 0.0:
        return 0
    for n in range(len(axes)):
        places[n] = axes[n]
    z = (-b - sqrt(inside)) / (2.0 * a)
    places[0] = ax * z + bx
    places[1] = ay * z + by
    places[2] = z
    return 1


def inverse(numbers: Sequence[float], places: Sequence[float], axes: MutableSequence[float]) -> int:
    """Angle of each arm, its elbow outwards.

    None where the rods would carry the plate above the ends of the arms: with the same angles it
    hangs below them.
    """
    for n in range(3):
        turn = radians(120.0 * n)
        x = places[0] * cos(turn) + places[1] * sin(turn)
        y = -places[0] * sin(turn) + places[1] * cos(turn)
        z = places[2]
        reach = numbers[3] * numbers[3] - y * y
        if reach < 0.0:
            return 0
        across = x - (numbers[0] - numbers[1])
        away = sqrt(across * across + z * z)
        if away == 0.0 or numbers[2] <= 0.0:
            return 0
        bend = (numbers[2] * numbers[2] + away * away - reach) / (2.0 * numbers[2] * away)
        if bend > 1.0 or bend < -1.0:
            return 0
        axes[n] = degrees(atan2(-z, across) - atan2(sqrt(1.0 - bend * bend), bend))
    for n in range(3, len(places)):
        axes[n] = places[n]
    back = [0.0] * len(places)
    if not forward(numbers, axes, back):
        return 0
    return 1 if dist(back[:3], places[:3]) <= _NEAR * numbers[3] else 0
