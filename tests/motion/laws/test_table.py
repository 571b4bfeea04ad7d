"""Laws against closed forms of their own, in forty digits; worked numbers; what joints promise."""

from array import array
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import cos, diff, mp, mpf, pi, quad, sin

from achse.motion.laws.element import (
    COEFFICIENT,
    ELEMENT,
    element_at,
    element_values,
    elements_of,
)
from achse.motion.laws.table import (
    LAWS,
    NAMES_ONLY,
    Ends,
    MotionLaw,
    NotALaw,
    segment,
    standing,
)

mp.dps = 40

Form = Callable[[Any], Any]
"""A law from (0, 0) to (1, 1), exactly."""


def modified_sine(z: Any) -> Any:
    k = 4 + pi
    if z <= mpf(1) / 8:
        return (pi * z - sin(4 * pi * z) / 4) / k
    if z <= mpf(7) / 8:
        return (2 + pi * z - mpf(9) / 4 * sin(pi / 3 + 4 * pi * z / 3)) / k
    return (4 + pi * z - sin(4 * pi * z) / 4) / k


def trapezoid_acceleration(z: Any) -> Any:
    size = 8 * pi / (2 + pi)
    if z <= mpf(1) / 8:
        return size * sin(4 * pi * z)
    if z <= mpf(3) / 8:
        return size
    if z <= mpf(5) / 8:
        return size * cos(4 * pi * (z - mpf(3) / 8))
    if z <= mpf(7) / 8:
        return -size
    return -size * cos(4 * pi * (z - mpf(7) / 8))


TURN = mpf(7) / 16 - 1 / (8 * pi)


def turning_acceleration(z: Any) -> Any:
    """Not scaled."""
    if z <= mpf(1) / 8:
        return sin(4 * pi * z)
    if z <= TURN:
        return mpf(1)
    if z <= TURN + mpf(1) / 4:
        return cos(4 * pi * (z - TURN))
    return mpf(-1)


def twice_integrated(acceleration: Form, corners: list[Any], scale: Any = 1) -> Form:
    """Position from rest: the integral of (z - x) f''(x)."""

    def position(z: Any) -> Any:
        places = [mpf(0), *(each for each in corners if each < z), z]
        return scale * quad(lambda x: (z - x) * acceleration(x), places)

    return position


EIGHTHS = [mpf(n) / 8 for n in (1, 3, 5, 7)]
TURNS = [mpf(1) / 8, TURN, TURN + mpf(1) / 4]
TURNED = twice_integrated(turning_acceleration, TURNS)(mpf(1))
TRAPEZOID_RT = twice_integrated(turning_acceleration, TURNS, 1 / TURNED)


def harmonic_rt(z: Any) -> Any:
    return (1 - cos(pi * z)) / 2 - (1 - cos(2 * pi * z)) / 8


def seventh(z: Any) -> Any:
    return 35 * z**4 - 84 * z**5 + 70 * z**6 - 20 * z**7


FORMS: dict[int, Form] = {
    1: lambda z: z,
    3: lambda z: 3 * z**2 - 2 * z**3,
    5: lambda z: 10 * z**3 - 15 * z**4 + 6 * z**5,
    7: seventh,
    8: seventh,
    9: lambda z: 126 * z**5 - 420 * z**6 + 540 * z**7 - 315 * z**8 + 70 * z**9,
    10: lambda z: (1 - cos(pi * z)) / 2,
    11: modified_sine,
    12: lambda z: z - sin(2 * pi * z) / (2 * pi),
    13: twice_integrated(trapezoid_acceleration, EIGHTHS),
    17: harmonic_rt,
    18: lambda z: 1 - harmonic_rt(1 - z),
    21: TRAPEZOID_RT,
    22: lambda z: 1 - TRAPEZOID_RT(1 - z),
}

CORNERS = {
    11: [0.125, 0.875],
    13: [float(each) for each in EIGHTHS],
    21: [float(each) for each in TURNS],
    22: [1.0 - float(each) for each in TURNS],
}


def function(law: int, ends: Ends, begin: float = 0.0, end: float = 1.0) -> "array[float]":
    return segment(law, begin, end, 0.0, ends) + standing(end, ends.way)


def at(elements: "array[float]", place: float) -> tuple[float, float, float, float]:
    number = element_at(elements, 0, len(elements) // ELEMENT, 0, place)
    return element_values(elements, ELEMENT * number, place)


@pytest.mark.parametrize("law", sorted(FORMS))
def test_each_law_is_its_closed_form(law: int) -> None:
    """Value, velocity, acceleration and jerk: differences of the exact form over 1e-10."""
    elements = function(law, Ends(1.0))
    form = FORMS[law]
    is_integral = law in (13, 21, 22)
    for n in range(1, 40, 3 if is_integral else 1):
        z = mpf(n) / 40 + mpf(1) / 999
        if any(abs(float(z) - corner) < 1e-6 for corner in CORNERS.get(law, [])):
            continue
        result = at(elements, float(z))
        z = mpf(float(z))
        assert result[0] == pytest.approx(float(form(z)), abs=1e-13)
        if is_integral:  # its differences would take a minute
            continue
        for order in (1, 2, 3):
            exact = float(diff(form, z, order, h=mpf(10) ** -10))
            assert result[order] == pytest.approx(exact, abs=1e-9), (law, order)


@pytest.mark.parametrize(
    ("law", "acceleration"),
    [
        (13, trapezoid_acceleration),
        (21, lambda z: turning_acceleration(z) / TURNED),
        (22, lambda z: -turning_acceleration(1 - z) / TURNED),
    ],
)
def test_trapezoids_are_the_integrals_of_their_acceleration(law: int, acceleration: Form) -> None:
    elements = function(law, Ends(1.0))
    corners = [mpf(each) for each in CORNERS[law]]
    backwards = -1 if law == 22 else 1
    begin = -quad(acceleration, [0, *sorted(corners), 1]) if backwards < 0 else mpf(0)
    for z in (0.05, 0.1, 0.3, 0.45, 0.62, 0.71, 0.8, 0.93):
        _, v, a, j = at(elements, z)
        within = [each for each in sorted(corners) if each < z]
        velocity = begin + quad(acceleration, [0, *within, mpf(z)])
        assert v == pytest.approx(float(velocity), abs=1e-12)
        assert a == pytest.approx(float(acceleration(mpf(z))), abs=1e-12)
        assert j == pytest.approx(float(diff(acceleration, mpf(z))), abs=1e-9)


WORKED = {
    3: [(0.028, 0.54, 4.8), (0.15625, 1.125, 3.0), (0.352, 1.44, 1.2)],
    5: [(0.00856, 0.243, 4.32), (0.103515625, 1.0546875, 5.625), (0.31744, 1.728, 2.88)],
    7: [
        (0.002728, 0.10206, 2.7216),
        (0.070556640625, 0.9228515625, 7.3828125),
        (0.289792, 1.93536, 4.8384),
    ],
    10: [
        (0.024471742, 0.485402760, 4.693275789),
        (0.146446609, 1.110720735, 3.489432100),
        (0.345491503, 1.493916082, 1.524937744),
    ],
    11: [
        (0.010697213, 0.303964009, 5.257399594),
        (0.117178485, 1.099752116, 4.787351254),
        (0.327865188, 1.645509107, 2.248422702),
    ],
    12: [
        (0.006451072, 0.190983006, 3.693163661),
        (0.090845057, 1.0, 6.283185307),
        (0.306451072, 1.809016994, 3.693163661),
    ],
    13: [
        (0.009459064, 0.268781699, 4.648881957),
        (0.104480194, 1.0, 4.888123763),
        (0.309459064, 1.731218301, 4.648881957),
    ],
    17: [
        (0.000598866, 0.023757302, 0.700936945),
        (0.021446609, 0.325322571, 3.489432100),
        (0.119364379, 1.032270625, 5.517276588),
    ],
}


@pytest.mark.parametrize("law", sorted(WORKED))
def test_worked_numbers(law: int) -> None:
    elements = function(law, Ends(1.0))
    for z, expected in zip((0.1, 0.25, 0.4), WORKED[law], strict=True):
        assert at(elements, z)[:3] == pytest.approx(expected, abs=6e-10)


def test_worked_numbers_of_polynomial_9() -> None:
    elements = function(9, Ends(1.0))
    for z, expected in ((0.1, 0.00089092), (0.25, 0.048927307), (0.4, 0.26656768)):
        assert at(elements, z)[0] == pytest.approx(expected, abs=6e-10)


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [
        (1.0, (0.263988645467, 0.578632469633, 0.874714541952)),
        (2.0, (0.471934599788, 0.803711548672, 0.960848576515)),
    ],
)
def test_worked_numbers_of_velocity_to_turn(
    velocity: float, expected: tuple[float, float, float]
) -> None:
    forth = function(19, Ends(1.0, velocity))
    back = function(20, Ends(1.0, end_velocity=velocity))
    for z, value in zip((0.25, 0.5, 0.75), expected, strict=True):
        assert at(forth, z)[0] == pytest.approx(value, abs=1e-10)  # one is printed with 10 digits
        assert at(back, 1.0 - z)[0] == pytest.approx(1.0 - value, abs=1e-10)


@given(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.floats(0.0, 1.0))
def test_velocity_to_turn_is_two_sines(way: float, velocity: float, z: float) -> None:
    """A sin(πz/2) + B sin(3πz/2) with f(1) = h, f'(0) = v; mirrored from a turn."""
    b = (2 * mpf(velocity) / pi - mpf(way)) / 4
    a = mpf(way) + b
    forth = function(19, Ends(way, velocity))
    back = function(20, Ends(way, end_velocity=velocity))

    def exact(x: Any) -> tuple[float, float, float, float]:
        s, third = pi / 2, 3 * pi / 2
        return (
            float(a * sin(s * x) + b * sin(third * x)),
            float(a * s * cos(s * x) + b * third * cos(third * x)),
            float(-a * s**2 * sin(s * x) - b * third**2 * sin(third * x)),
            float(-a * s**3 * cos(s * x) - b * third**3 * cos(third * x)),
        )

    assert at(forth, z) == pytest.approx(exact(mpf(z)), abs=1e-9)
    s, v, acceleration, j = exact(1 - mpf(z))
    assert at(back, z) == pytest.approx((way - s, v, -acceleration, j), abs=1e-9)


def test_worked_numbers_of_motion_to_motion() -> None:
    """m 0 → 100, s 0 → 50, v 0.2 → 1, a 0 → 0.01; then jerk 0 at both ends."""
    five = function(15, Ends(50.0, 20.0, 0.0, 0.0, 100.0, 100.0), 0.0, 100.0)
    assert list(five[COEFFICIENT : COEFFICIENT + 6]) == [0.0, 20.0, 0.0, 30.0, 10.0, -10.0]
    for m, expected in (
        (25.0, (5.498046875, 0.260546875, 0.0049375)),
        (50.0, (14.0625, 0.44375, 0.0095)),
        (75.0, (28.447265625, 0.716796875, 0.0118125)),
    ):
        assert at(five, m)[:3] == pytest.approx(expected, abs=1e-12)
    seven = function(24, Ends(50.0, 20.0, 0.0, 0.0, 100.0, 100.0, 0.0), 0.0, 100.0)
    for m, value in ((25.0, 5.30029296875), (50.0, 13.59375), (75.0, 28.24951171875)):
        assert at(seven, m)[0] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("law", [5, 15])
def test_worked_numbers_of_a_stroke(law: int) -> None:
    elements = function(law, Ends(100.0), 0.0, 180.0)
    for m, expected in (
        (45.0, (10.3515625, 0.5859375, 0.017361111111, -1.28600823e-4)),
        (90.0, (50.0, 1.041666667, 0.0, -5.144032922e-4)),
        (120.0, (79.012345679, 0.823045267490, -0.013717421125)),
    ):
        assert at(elements, m)[: len(expected)] == pytest.approx(expected, abs=6e-10)


ENDS = st.builds(Ends, *[st.floats(-50.0, 50.0)] * 7)

AT_BEGIN = {15: 3, 24: 4, 19: 2, 23: 2, 39: 2, 40: 2}
AT_END = {15: 3, 24: 4, 20: 2, 23: 2, 38: 2, 40: 2}
"""How many of position, velocity, acceleration and jerk a law takes from its points."""

FREE = {1: 1, 3: 2, 10: 2, 99: 0}
"""How many of these a law has in its hands at all; others have position, velocity, acceleration."""
TURN_AT_BEGIN = (18, 20, 22)
TURN_AT_END = (17, 19, 21)


@settings(max_examples=200)
@given(st.sampled_from(sorted(LAWS)), ENDS)
def test_each_law_keeps_the_ends_it_promises(law: int, ends: Ends) -> None:
    elements = segment(law, 0.0, 1.0, 0.0, ends)
    begin = element_values(elements, 0, 0.0)
    end = element_values(elements, len(elements) - ELEMENT, 1.0)
    given_begin = (0.0, ends.velocity, ends.acceleration, ends.jerk)
    given_end = (ends.way, ends.end_velocity, ends.end_acceleration, ends.end_jerk)
    near = pytest.approx
    scale = 1e-9 * (1.0 + max(map(abs, ends)))
    promised = FREE.get(law, 3)
    if law == MotionLaw.HARMONIC_VT or law == MotionLaw.HARMONIC_TV:
        promised = 2
    if law == MotionLaw.POLYNOMIAL_3_VV:
        promised = 2
    taken = AT_BEGIN.get(law, 1)
    assert begin[:taken] == near(given_begin[:taken], abs=scale)
    if law not in TURN_AT_BEGIN or promised < 3:
        assert begin[taken:promised] == near((0.0,) * max(promised - taken, 0), abs=scale)
    if law == MotionLaw.STEP:
        assert end == (0.0, 0.0, 0.0, 0.0)
        return
    taken = AT_END.get(law, 1)
    assert end[:taken] == near(given_end[:taken], abs=scale)
    if law in TURN_AT_END or law in TURN_AT_BEGIN:
        promised = 2 if law in TURN_AT_END else promised
    assert end[taken:promised] == near((0.0,) * max(promised - taken, 0), abs=scale)


@settings(max_examples=200)
@given(st.sampled_from(sorted(LAWS)), ENDS)
def test_within_a_law_position_velocity_and_acceleration_are_continuous(
    law: int, ends: Ends
) -> None:
    elements = segment(law, 0.0, 1.0, 0.0, ends)
    for before, after in pairwise(elements_of(elements)):
        left = element_values(before, 0, after[0])[:3]
        assert left == pytest.approx(element_values(after, 0, after[0])[:3], abs=1e-7)


@pytest.mark.parametrize("number", [0, 2, *NAMES_ONLY, 14, 98, 100, -1, 1 << 15])
def test_other_numbers_are_refused(number: int) -> None:
    with pytest.raises(NotALaw, match="expected 1, 3, 5"):
        segment(number, 0.0, 1.0, 0.0, Ends(1.0))


def test_the_table_names_each_law() -> None:
    assert set(LAWS) == set(MotionLaw)
    assert all(law.number == number and law.meaning for number, law in LAWS.items())
