"""Extremes: the printed coefficients of each law, and dense samples of random functions."""

from array import array
from itertools import pairwise

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from achse.motion.laws.element import ELEMENT, element_at, element_values, elements_of
from achse.motion.laws.extremes import extremes_of
from achse.motion.laws.table import LAWS, Ends, segment, standing

COEFFICIENTS = {
    3: (1.5, 6.0, 12.0, 3.464101615, None),
    5: (1.875, 5.773502691896, 60.0, 4.140393356, 6.694268727),
    7: (2.1875, 7.513188404, 52.5, 5.045250, 10.750226164),
    9: (2.4609375, 9.371976218, 78.75, 5.93673, None),
    10: (1.570796327, 4.934802201, 15.503138340, 3.489432100, 3.875784585),
    11: (1.759603386, 5.527957071, 69.466357289, 3.908855931, 5.457752763),
    12: (2.0, 6.283185307, 39.478417604, 4.442882938, 8.162097139),
    13: (2.0, 4.888123763, 61.425974812, 4.233239355, 8.089980982),
    17: (2.040524285, 9.869604401, 42.41372, None, None),
    21: (1.916909054, 4.438664155, 55.7779, None, None),
}
"""Greatest velocity, acceleration, jerk; effective acceleration; greatest momentum."""


def function(*segments: tuple[int, float, tuple[float, ...]]) -> "array[float]":
    """Law, master way and what its ends say, one behind the other from (0, 0) on."""
    elements = array("d")
    place = position = 0.0
    for law, way, ends in segments:
        elements += segment(law, place, place + way, position, Ends(*ends))
        place += way
        position += ends[0]
    return elements + standing(place, position)


@pytest.mark.parametrize("law", sorted(COEFFICIENTS))
def test_coefficients_of_laws(law: int) -> None:
    extremes = extremes_of(function((law, 1.0, (1.0,))))
    velocity, acceleration, jerk, effective, momentum = COEFFICIENTS[law]
    assert extremes.velocity[1].value == pytest.approx(velocity, rel=1e-9)
    assert max(abs(each.value) for each in extremes.acceleration) == pytest.approx(
        acceleration, rel=1e-9
    )
    assert max(abs(each.value) for each in extremes.jerk) == pytest.approx(jerk, rel=1e-6)
    if effective is not None:
        assert extremes.effective_acceleration == pytest.approx(effective, rel=2e-7)
    if momentum is not None:
        assert extremes.momentum[1].value == pytest.approx(momentum, rel=1e-9)


def test_worked_numbers() -> None:
    """POLY5, 0..180 → 100."""
    extremes = extremes_of(function((5, 180.0, (100.0,))))
    least, most = extremes.acceleration
    assert (extremes.velocity[1].value, extremes.velocity[1].master) == pytest.approx(
        (1.041666667, 90.0), abs=6e-10
    )
    assert (most.value, most.master) == pytest.approx((0.017819452753, 38.038475773), abs=6e-10)
    assert (least.value, least.master) == pytest.approx((-0.017819452753, 141.961524227), abs=6e-10)
    assert extremes.jerk[1].value == pytest.approx(0.001028806584, abs=6e-13)
    assert extremes.jerk[0].value == pytest.approx(-0.000514403292, abs=6e-13)
    assert extremes.mean_velocity == pytest.approx(0.555555556, abs=6e-10)
    assert extremes.effective_acceleration == pytest.approx(0.012778991840, abs=6e-13)


SEGMENTS = st.lists(
    st.tuples(
        st.sampled_from(sorted(set(LAWS) - {99})),
        st.floats(0.5, 50.0),
        st.tuples(*[st.floats(-50.0, 50.0)] * 7),
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=60, deadline=None)
@given(SEGMENTS)
@example(
    [
        (1, 1.0, (0.0,) * 7),
        (1, 1.0, (0.0,) * 7),
        (11, 14.978515625, (2.113289653105832e-154, *(0.0,) * 6)),
    ]
)
def test_no_sample_is_beyond_and_each_extreme_is_a_value(
    segments: list[tuple[int, float, tuple[float, ...]]],
) -> None:
    elements = function(*segments)
    extremes = extremes_of(elements)
    pairs = (
        extremes.position,
        extremes.velocity,
        extremes.acceleration,
        extremes.jerk,
        extremes.momentum,
    )
    for element, after in pairwise(elements_of(elements)):
        for n in range(51):
            place = element[0] + (after[0] - element[0]) * n / 50
            s, v, a, j = element_values(element, 0, place)
            for value, (least, most) in zip((s, v, a, j, v * a), pairs, strict=True):
                slack = 1e-9 * (1.0 + abs(value))
                assert least.value - slack <= value <= most.value + slack
    for each in extremes.position:
        number = element_at(elements, 0, len(elements) // ELEMENT, 0, each.master)
        s = element_values(elements, ELEMENT * number, each.master)[0]
        assert s == pytest.approx(each.value, rel=1e-9, abs=1e-9)


def test_a_step_counts_by_its_positions() -> None:
    extremes = extremes_of(function((99, 10.0, (5.0,))))
    assert [each.value for each in extremes.position] == [0.0, 5.0]
    assert extremes.velocity[1].value == 0.0


def test_a_table_that_stands_has_no_extremes() -> None:
    extremes = extremes_of(standing(3.0, 2.0))
    assert [each.value for each in extremes.position] == [2.0, 2.0]
    assert (extremes.mean_velocity, extremes.effective_acceleration) == (0.0, 0.0)
