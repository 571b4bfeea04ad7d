"""Cubics through the rows of cam tables: worked numbers, SciPy as oracle, both kernels alike."""

import random
from array import array
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from achse.motion.tables.joining import JOINING, Boundary, join
from achse.motion.tables.memory import BEGIN, COUNT, HEADER, PERIOD, SPAN, CamMemory, cam_values

LINES, FOUR_ROWS, SPLINE, LOCAL = range(4)
PLACES = [0.0, 90.0, 180.0, 270.0, 360.0]
VALUES = [0.0, 30.0, 20.0, -10.0, 0.0]


def block(
    places: list[float],
    values: list[float],
    method: int,
    boundary: int,
    slopes: tuple[float, float] = (0.0, 0.0),
    *,
    compiled: bool = False,
) -> tuple[CamMemory, int]:
    memory, count = CamMemory(), len(places)
    first = memory.take(HEADER + SPAN * count)
    memory.numbers[first + COUNT] = count
    memory.numbers[first + BEGIN] = places[0]
    memory.numbers[first + PERIOD] = places[-1] - places[0]
    arguments = array("d", places), array("d", values), memory.numbers
    rest = (first, method, boundary, *slopes, 0, count)
    if compiled:
        JOINING.function(*(part for each in arguments for part in each.buffer_info()), *rest)
    else:
        join(*arguments, first, method, boundary, *slopes, 0, count)
    return memory, first


@pytest.mark.parametrize(
    ("method", "boundary", "expected"),
    [
        (SPLINE, Boundary.PERIODIC, [16.875, 31.303155006859, 12.757201646091, -0.331474622771]),
        (SPLINE, Boundary.NATURAL, [18.214285714286, 31.115030374290, 12.674897119342]),
        (SPLINE, Boundary.SLOPES, [12.053571428571, 32.102684695277, 11.851851851852, -0.0044611]),
        (FOUR_ROWS, Boundary.SLOPES, [21.25, 30.498399634202, 12.949245541838]),
        (LOCAL, Boundary.SLOPES, [20.0, 30.754458161866, 13.909465020576]),
        (LOCAL, Boundary.PERIODIC, [16.25]),
        (LINES, Boundary.SLOPES, [15.0, 30.0 - 10.0 / 9.0, 20.0 - 60.0 / 9.0, -1.0 / 9.0]),
    ],
)
def test_worked_numbers(method: int, boundary: int, expected: list[float]) -> None:
    memory, first = block(PLACES, VALUES, method, boundary)
    for place, value in zip((45.0, 100.0, 200.0, 359.0), expected, strict=False):
        assert cam_values(memory.numbers, first, 0, place)[0] == pytest.approx(value, abs=1e-8)


def test_slopes_of_the_periodic_spline() -> None:
    memory, first = block(PLACES, VALUES, SPLINE, Boundary.PERIODIC)
    for place, slope in ((45.0, 0.375), (100.0, 0.094650205761), (200.0, -0.382716049383)):
        assert cam_values(memory.numbers, first, 0, place)[1] == pytest.approx(slope, abs=1e-11)


def drawn(seed: int, least: int) -> tuple[list[float], list[float]]:
    dice = random.Random(seed)
    places = [dice.uniform(-1000.0, 1000.0)]
    for _ in range(dice.randint(least - 1, 40)):
        places.append(places[-1] + 10.0 ** dice.uniform(-2.0, 2.0))
    return places, [dice.uniform(-100.0, 100.0) for _ in places]


def slopes_of_bessel(places: list[float], values: list[float]) -> list[float]:
    """Derivative at each row of the parabola through the nearest three."""
    results = []
    for n, place in enumerate(places):
        at = min(max(n, 1), len(places) - 2)
        near = slice(at - 1, at + 2)
        x = np.array(places[near]) - place
        results.append(float(np.linalg.solve(np.vander(x, 3), values[near])[1]))
    return results


@pytest.mark.parametrize("seed", range(40))
def test_scipy_says_the_same(seed: int) -> None:
    places, values = drawn(seed, 4)
    dice = random.Random(seed)
    slopes = dice.uniform(-5.0, 5.0), dice.uniform(-5.0, 5.0)
    closed = [*values[:-1], values[0]]
    for arguments, boundary, oracle in (
        (values, Boundary.NATURAL, CubicSpline(places, values, bc_type="natural")),
        (
            values,
            Boundary.SLOPES,
            CubicSpline(places, values, bc_type=tuple((1, s) for s in slopes)),
        ),
        (closed, Boundary.PERIODIC, CubicSpline(places, closed, bc_type="periodic")),
    ):
        memory, first = block(places, arguments, SPLINE, boundary, slopes)
        _compare(memory, first, places, oracle)
    memory, first = block(places, values, LOCAL, Boundary.SLOPES)
    _compare(
        memory, first, places, CubicHermiteSpline(places, values, slopes_of_bessel(places, values))
    )


def _compare(memory: CamMemory, first: int, places: list[float], oracle: object) -> None:
    for before, after in pairwise(places):
        for share in (0.0, 0.25, 0.7):
            place = before + share * (after - before)
            values = cam_values(memory.numbers, first, 0, place)
            for order in range(3):
                right = float(oracle(place, order))  # type: ignore[operator]
                assert values[order] == pytest.approx(right, rel=1e-7, abs=1e-7 * 10.0**order)


@pytest.mark.parametrize("seed", range(10))
def test_a_lift_adds_a_straight_line(seed: int) -> None:
    places, values = drawn(seed, 4)
    values[-1] = values[0]
    lift = 123.0
    period = places[-1] - places[0]
    rising = [y + lift * (x - places[0]) / period for x, y in zip(places, values, strict=True)]
    flat, lifted = (block(places, each, SPLINE, Boundary.PERIODIC) for each in (values, rising))
    for share in (0.1, 0.33, 0.9):
        place = places[0] + share * period
        below = cam_values(flat[0].numbers, flat[1], 0, place)
        above = cam_values(lifted[0].numbers, lifted[1], 0, place)
        assert above[0] - below[0] == pytest.approx(lift * share, abs=1e-7)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("method", [LINES, FOUR_ROWS, SPLINE, LOCAL])
def test_machine_code_joins_alike(method: int, seed: int) -> None:
    places, values = drawn(seed, 4)
    for boundary in (Boundary.NATURAL, Boundary.SLOPES, Boundary.PERIODIC):
        plain, _ = block(places, values, method, boundary, (0.5, -1.5))
        machine, _ = block(places, values, method, boundary, (0.5, -1.5), compiled=True)
        assert plain.numbers == machine.numbers


@pytest.mark.parametrize("seed", range(20))
def test_four_rows_are_met(seed: int) -> None:
    places, values = drawn(seed, 4)
    memory, first = block(places, values, FOUR_ROWS, Boundary.SLOPES)
    for n, (before, after) in enumerate(pairwise(places)):
        near = min(max(n - 1, 0), len(places) - 4)
        x = np.array(places[near : near + 4]) - before
        cubic = np.linalg.solve(np.vander(x, 4), values[near : near + 4])
        place = 0.5 * (before + after)
        scale = 1.0 + float(np.abs(cubic).max()) * (after - before)
        result = cam_values(memory.numbers, first, 0, place)[0]
        assert result == pytest.approx(np.polyval(cubic, place - before), abs=1e-6 * scale)
