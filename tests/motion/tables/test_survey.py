"""Characteristic values: the worked example, cubics against a general curve, both kernels alike."""

import random
from array import array

import pytest

from achse.motion.tables.joining import Boundary, join
from achse.motion.tables.memory import COUNT, HEADER, SPAN, CamMemory
from achse.motion.tables.survey import (
    SURVEY,
    VALUES,
    CurveValues,
    at_velocity,
    begin_survey,
    end_survey,
    meet,
    survey,
    survey_curve,
)


def poly5(m: float) -> CurveValues:
    """From 0 to 100 over 0 … 180, at rest at both ends."""
    z = m / 180.0
    return (
        100.0 * (10.0 * z**3 - 15.0 * z**4 + 6.0 * z**5),
        100.0 / 180.0 * (30.0 * z**2 - 60.0 * z**3 + 30.0 * z**4),
        100.0 / 180.0**2 * (60.0 * z - 180.0 * z**2 + 120.0 * z**3),
        100.0 / 180.0**3 * (60.0 - 360.0 * z + 360.0 * z**2),
    )


def test_the_worked_example() -> None:
    survey = survey_curve([(0.0, 180.0, poly5)])
    assert survey[22:24] == pytest.approx([90.0, 1.041666667])
    assert survey[24:26] == pytest.approx([38.038475773, 0.017819452753], abs=1e-9)
    assert survey[15:17] == pytest.approx([141.961524227, -0.017819452753], abs=1e-9)
    assert (survey[27], survey[18]) == pytest.approx((0.001028806584, -0.000514403292), abs=1e-12)
    assert survey[29:31] == pytest.approx([0.555555556, 0.012778991840], abs=1e-9)
    fast = at_velocity(survey, 720.0)
    assert (fast[0], fast[23], fast[25], fast[27]) == pytest.approx(
        (720.0, 750.0, 9237.604307034, 384000.0)
    )
    assert fast[22] == 90.0
    with pytest.raises(ValueError, match="velocity -1"):
        at_velocity(survey, -1.0)


def cubic(places: list[float], values: list[float]) -> tuple[CamMemory, int]:
    memory, count = CamMemory(), len(places)
    first = memory.take(HEADER + SPAN * count)
    memory.numbers[first + COUNT] = count
    arguments = array("d", places), array("d", values), memory.numbers
    join(*arguments, first, 2, Boundary.SLOPES, 0.3, -0.2, 0, count)
    return memory, first


@pytest.mark.parametrize("seed", range(20))
def test_cubics_are_surveyed_exactly(seed: int) -> None:
    dice = random.Random(seed)
    places = [dice.uniform(-100.0, 100.0)]
    for _ in range(dice.randint(2, 12)):
        places.append(places[-1] + dice.uniform(0.5, 50.0))
    memory, first = cubic(places, [dice.uniform(-50.0, 50.0) for _ in places])
    result = array("d", [0.0]) * VALUES
    survey(memory.numbers, first, result)

    def part(row: int) -> tuple[float, float, object]:
        at = first + HEADER + SPAN * row
        begin, value, slope, square, cube, end = memory.numbers[at : at + SPAN + 1]

        def values(place: float) -> CurveValues:
            w = place - begin
            return (
                value + w * (slope + w * (square + w * cube)),
                slope + w * (2.0 * square + 3.0 * w * cube),
                2.0 * square + 6.0 * w * cube,
                6.0 * cube,
            )

        return begin, end, values

    right = survey_curve([part(row) for row in range(len(places) - 1)])  # type: ignore[misc]
    exact = [n for n in range(VALUES) if n not in (19, 28)]  # v·a is only sampled there
    for n in exact:
        assert result[n] == pytest.approx(right[n], rel=1e-6, abs=1e-6), n
    assert result[19] <= right[19] + 1e-9
    assert result[28] >= right[28] - 1e-9
    machine = array("d", [0.0]) * VALUES
    SURVEY.function(*memory.arguments, first, *machine.buffer_info())
    assert machine == result


def test_means_are_of_the_whole_period() -> None:
    results = [0.0] * VALUES
    begin_survey(results)
    meet(results, 3.0, -1.0, 2.0, -3.0, 4.0)
    results[29], results[30] = 20.0, 90.0
    end_survey(results, 10.0)
    assert (results[29], results[30]) == (2.0, 3.0)
    assert (results[11], results[12], results[20], results[21]) == (3.0, -1.0, 3.0, -1.0)
    assert (results[19], results[28]) == (-6.0, -6.0)
