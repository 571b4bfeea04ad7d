"""The table of laws: which function types a point can name, and the elements each becomes.

A segment goes from one point to the next: D along the master, h along the slave. A law gets what
both points say, scaled to a master way of 1 (velocities times D, accelerations times D², jerks
times D³), and answers with elements of w = (master - begin) / D. Which of these values it regards
is what its name says: a rest has none, a turn none that is not 0.

The names are the vendor's; where only a name is printed, the law is our choice and its function
says so. Source: 002 §6.4.8.1 (1 and 15); the others are in the list of the vendor's cam editor, the
formulas are those of VDI 2143.
"""

from array import array
from collections.abc import Callable
from enum import IntEnum
from math import cos, pi, sin
from typing import NamedTuple

from achse.motion.laws.element import make_element


class MotionLaw(IntEnum):
    """Function type of a point: the law of the segment that begins there.

    R rest, V velocity, T turn (velocity 0, acceleration as it comes), MM motion: velocity and
    acceleration at both ends.
    """

    POLYNOMIAL_1 = 1
    POLYNOMIAL_3 = 3
    POLYNOMIAL_5 = 5
    POLYNOMIAL_7 = 7
    POLYNOMIAL_8 = 8
    POLYNOMIAL_9 = 9
    SINE = 10
    MODIFIED_SINE = 11
    BESTEHORN = 12
    ACCELERATION_TRAPEZOID = 13
    POLYNOMIAL_5_MM = 15
    HARMONIC_RT = 17
    HARMONIC_TR = 18
    HARMONIC_VT = 19
    HARMONIC_TV = 20
    ACCELERATION_TRAPEZOID_RT = 21
    ACCELERATION_TRAPEZOID_TR = 22
    MODIFIED_SINE_VV = 23
    POLYNOMIAL_7_MM = 24
    ACCELERATION_TRAPEZOID_RV = 38
    ACCELERATION_TRAPEZOID_VR = 39
    POLYNOMIAL_3_VV = 40
    STEP = 99


NAMES_ONLY = (16, 27, 28)
"""Names without a formula, and without a field for what they would need: refused."""


class NotALaw(ValueError):
    """A function type that is none of `MotionLaw`."""


class Ends(NamedTuple):
    """A segment scaled to a master way of 1: way of the slave, derivatives at begin and end."""

    way: float
    velocity: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    end_velocity: float = 0.0
    end_acceleration: float = 0.0
    end_jerk: float = 0.0


_Part = tuple[float, tuple[float, ...], tuple[float, float, float], tuple[float, float, float]]
"""Begin of an element within the segment, coefficients, both sines as size, turn, lead."""

_NO_SINE = (0.0, 0.0, 0.0)
_FULL = 2.0 * pi


def _part(
    begin: float,
    *coefficients: float,
    sine: tuple[float, float, float] = _NO_SINE,
    second: tuple[float, float, float] = _NO_SINE,
) -> _Part:
    return begin, coefficients, sine, second


def _of(*coefficients: float) -> Callable[[Ends], list[_Part]]:
    """Return a law from rest to rest that is a polynomial, for a way of 1."""

    def law(ends: Ends) -> list[_Part]:
        return [_part(0.0, *(ends.way * each for each in coefficients))]

    return law


def _scaled(unit: list[_Part]) -> Callable[[Ends], list[_Part]]:
    """Return a law that is the same for each way but for its size."""

    def law(ends: Ends) -> list[_Part]:
        h = ends.way
        return [
            _part(
                begin,
                *(h * each for each in coefficients),
                sine=(h * sine[0], *sine[1:]),
                second=(h * second[0], *second[1:]),
            )
            for begin, coefficients, sine, second in unit
        ]

    return law


def _mirrored(law: Callable[[Ends], list[_Part]]) -> Callable[[Ends], list[_Part]]:
    """Return the law run backwards: f(z) = h - g(1 - z)."""

    def mirror(ends: Ends) -> list[_Part]:
        parts = law(Ends(ends.way, ends.end_velocity, 0.0, 0.0, ends.velocity))
        mirrored: list[_Part] = []
        stop = 1.0
        for begin, coefficients, sine, second in reversed(parts):
            width = stop - begin  # g over w in 0..width becomes h - g(width - w)
            shifted = _reversed(coefficients, width)
            mirrored.append(
                _part(
                    1.0 - stop,
                    ends.way - shifted[0],
                    *(-each for each in shifted[1:]),
                    sine=_backwards(sine, width),
                    second=_backwards(second, width),
                )
            )
            stop = begin
        return mirrored

    return mirror


def _reversed(coefficients: tuple[float, ...], width: float) -> list[float]:
    """Coefficients of p(width - w)."""
    shifted = [0.0] * len(coefficients)
    for coefficient in reversed(coefficients):  # Horner with (width - w) as the place
        before = shifted
        shifted = [width * each for each in before]
        for k, each in enumerate(before[:-1]):
            shifted[k + 1] -= each
        shifted[0] += coefficient
    return shifted


def _backwards(sine: tuple[float, float, float], width: float) -> tuple[float, float, float]:
    """-size sin(turn (width - w) + lead), as a sine of w."""
    size, turn, lead = sine
    return size, turn, -lead - turn * width


def _line(ends: Ends) -> list[_Part]:
    return [_part(0.0, 0.0, ends.way)]


def _step(_: Ends) -> list[_Part]:
    """Stands where it begins; the next segment begins elsewhere."""
    return [_part(0.0, 0.0)]


_SINE = [_part(0.0, 0.5, sine=(-0.5, pi, 0.5 * pi))]
_BESTEHORN = [_part(0.0, 0.0, 1.0, sine=(-1.0 / _FULL, _FULL, 0.0))]

_K = 4.0 + pi
_MODIFIED_SINE = [
    _part(0.0, 0.0, pi / _K, sine=(-0.25 / _K, 4.0 * pi, 0.0)),
    _part(0.125, (2.0 + pi / 8.0) / _K, pi / _K, sine=(-2.25 / _K, 4.0 * pi / 3.0, 0.5 * pi)),
    _part(0.875, (4.0 + 7.0 * pi / 8.0) / _K, pi / _K, sine=(-0.25 / _K, 4.0 * pi, 3.5 * pi)),
]


def _accelerated(*phases: tuple[float, float, float, float]) -> list[_Part]:
    """Return a law from rest whose acceleration is constant + size · sin(4π w + lead), phase by
    phase.

    A phase is its width, the constant, the size and the lead.
    """
    parts: list[_Part] = []
    turn = 4.0 * pi
    begin = position = velocity = 0.0
    for width, constant, size, lead in phases:
        ripple = -size / (turn * turn)  # integrated twice
        slope = -size / turn
        offset, rise = position - ripple * sin(lead), velocity - slope * cos(lead)
        parts.append(_part(begin, offset, rise, 0.5 * constant, sine=(ripple, turn, lead)))
        end = turn * width + lead
        position = offset + rise * width + 0.5 * constant * width**2 + ripple * sin(end)
        velocity = rise + constant * width + slope * cos(end)
        begin += width
    return [
        _part(
            begin, *(each / position for each in coefficients), sine=(sine[0] / position, *sine[1:])
        )
        for begin, coefficients, sine, _ in parts
    ]


_RAMP = (0.125, 0.0, 1.0, 0.0)
_TRAPEZOID = _accelerated(
    _RAMP,
    (0.25, 1.0, 0.0, 0.0),
    (0.25, 0.0, 1.0, 0.5 * pi),
    (0.25, -1.0, 0.0, 0.0),
    (0.125, 0.0, 1.0, 1.5 * pi),
)
_HOLD = 5.0 / 16.0 - 1.0 / (8.0 * pi)
"""So long is the acceleration of a rest-turn trapezoid at its height: the turn has velocity 0."""

_TRAPEZOID_RT = _accelerated(
    _RAMP, (_HOLD, 1.0, 0.0, 0.0), (0.25, 0.0, 1.0, 0.5 * pi), (0.625 - _HOLD, -1.0, 0.0, 0.0)
)

_HARMONIC_RT = [
    _part(0.0, 0.375, sine=(-0.5, pi, 0.5 * pi), second=(0.125, 2.0 * pi, 0.5 * pi)),
]


def _harmonic_vt(ends: Ends) -> list[_Part]:
    """Two sines (choice): A sin(πz/2) + B sin(3πz/2), from the given velocity to a turn."""
    small = 0.25 * (2.0 * ends.velocity / pi - ends.way)
    return [
        _part(
            0.0,
            0.0,
            sine=(ends.way + small, 0.5 * pi, 0.0),
            second=(small, 1.5 * pi, 0.0),
        )
    ]


def _cubic(ends: Ends) -> list[_Part]:
    """Hermite's, to velocities at both ends."""
    h, v, w = ends.way, ends.velocity, ends.end_velocity
    return [_part(0.0, 0.0, v, 3.0 * h - 2.0 * v - w, v + w - 2.0 * h)]


def _quintic(ends: Ends) -> list[_Part]:
    """Hermite's, to velocities and accelerations at both ends."""
    c1, c2 = ends.velocity, 0.5 * ends.acceleration
    a = ends.way - c1 - c2
    b = ends.end_velocity - c1 - 2.0 * c2
    c = ends.end_acceleration - 2.0 * c2
    return [
        _part(
            *(0.0, 0.0, c1, c2),
            10.0 * a - 4.0 * b + 0.5 * c,
            -15.0 * a + 7.0 * b - c,
            6.0 * a - 3.0 * b + 0.5 * c,
        )
    ]


def _smooth(ends: Ends) -> list[_Part]:
    """Velocities at both ends, accelerations 0 (choice: the quintic)."""
    return _quintic(Ends(ends.way, ends.velocity, end_velocity=ends.end_velocity))


def _from_rest(ends: Ends) -> list[_Part]:
    return _quintic(Ends(ends.way, end_velocity=ends.end_velocity))


def _to_rest(ends: Ends) -> list[_Part]:
    return _quintic(Ends(ends.way, ends.velocity))


def _septic(ends: Ends) -> list[_Part]:
    """Hermite's, to velocities, accelerations and jerks at both ends."""
    c1, c2, c3 = ends.velocity, 0.5 * ends.acceleration, ends.jerk / 6.0
    a = ends.way - c1 - c2 - c3
    b = ends.end_velocity - c1 - 2.0 * c2 - 3.0 * c3
    c = ends.end_acceleration - 2.0 * c2 - 6.0 * c3
    d = ends.end_jerk - 6.0 * c3
    return [
        _part(
            *(0.0, 0.0, c1, c2, c3),
            35.0 * a - 15.0 * b + 2.5 * c - d / 6.0,
            -84.0 * a + 39.0 * b - 7.0 * c + 0.5 * d,
            70.0 * a - 34.0 * b + 6.5 * c - 0.5 * d,
            -20.0 * a + 10.0 * b - 2.0 * c + d / 6.0,
        )
    ]


class Law(NamedTuple):
    """A law and its number."""

    number: MotionLaw
    parts: Callable[[Ends], list[_Part]]
    meaning: str


_POLYNOMIAL_7 = _of(0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)

LAWS: dict[int, Law] = {
    law.number: law
    for law in (
        Law(MotionLaw.POLYNOMIAL_1, _line, "straight line"),
        Law(MotionLaw.POLYNOMIAL_3, _of(0.0, 0.0, 3.0, -2.0), "rest to rest"),
        Law(MotionLaw.POLYNOMIAL_5, _of(0.0, 0.0, 0.0, 10.0, -15.0, 6.0), "rest to rest"),
        Law(MotionLaw.POLYNOMIAL_7, _POLYNOMIAL_7, "rest to rest"),
        Law(MotionLaw.POLYNOMIAL_8, _POLYNOMIAL_7, "rest to rest, as polynomial 7 (choice)"),
        Law(
            MotionLaw.POLYNOMIAL_9,
            _of(*[0.0] * 5, 126.0, -420.0, 540.0, -315.0, 70.0),
            "rest to rest",
        ),
        Law(MotionLaw.SINE, _scaled(_SINE), "rest to rest"),
        Law(MotionLaw.MODIFIED_SINE, _scaled(_MODIFIED_SINE), "rest to rest"),
        Law(MotionLaw.BESTEHORN, _scaled(_BESTEHORN), "rest to rest"),
        Law(MotionLaw.ACCELERATION_TRAPEZOID, _scaled(_TRAPEZOID), "rest to rest"),
        Law(MotionLaw.POLYNOMIAL_5_MM, _quintic, "motion to motion"),
        Law(MotionLaw.HARMONIC_RT, _scaled(_HARMONIC_RT), "rest to turn"),
        Law(MotionLaw.HARMONIC_TR, _mirrored(_scaled(_HARMONIC_RT)), "turn to rest"),
        Law(MotionLaw.HARMONIC_VT, _harmonic_vt, "velocity to turn"),
        Law(MotionLaw.HARMONIC_TV, _mirrored(_harmonic_vt), "turn to velocity"),
        Law(MotionLaw.ACCELERATION_TRAPEZOID_RT, _scaled(_TRAPEZOID_RT), "rest to turn"),
        Law(MotionLaw.ACCELERATION_TRAPEZOID_TR, _mirrored(_scaled(_TRAPEZOID_RT)), "turn to rest"),
        Law(MotionLaw.MODIFIED_SINE_VV, _smooth, "velocity to velocity, a quintic (choice)"),
        Law(MotionLaw.POLYNOMIAL_7_MM, _septic, "motion to motion, with jerks"),
        Law(
            MotionLaw.ACCELERATION_TRAPEZOID_RV, _from_rest, "rest to velocity, a quintic (choice)"
        ),
        Law(MotionLaw.ACCELERATION_TRAPEZOID_VR, _to_rest, "velocity to rest, a quintic (choice)"),
        Law(MotionLaw.POLYNOMIAL_3_VV, _cubic, "velocity to velocity"),
        Law(MotionLaw.STEP, _step, "rests, and steps at its end"),
    )
}
"""Each law by its function type."""


def segment(number: int, begin: float, end: float, position: float, ends: Ends) -> "array[float]":
    """The elements of a law from master position `begin` to `end`; the slave starts at `position`.

    Raises NotALaw.
    """
    law = LAWS.get(number)
    if law is None:
        raise NotALaw(f"function type {number}, expected {', '.join(map(str, LAWS))}")
    way = end - begin
    numbers = array("d")
    for start, coefficients, sine, second in law.parts(ends):
        shifted = position + coefficients[0], *coefficients[1:]
        numbers += make_element(begin + start * way, 1.0 / way, shifted, sine, second)
    return numbers


def standing(begin: float, position: float) -> "array[float]":
    """The slave is at standstill from here on: the last element of a function."""
    return make_element(begin, 1.0, (position,))
