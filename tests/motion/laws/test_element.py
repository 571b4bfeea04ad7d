"""Elements: what they are worth, plain and as machine code."""

from array import array
from collections.abc import MutableSequence, Sequence
from math import cos, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.laws.element import (
    COEFFICIENTS,
    ELEMENT,
    element_at,
    element_values,
    make_element,
)
from achse.motion.laws.table import LAWS, Ends, segment, standing
from achse.native.compiled import Kernel

NUMBERS = st.floats(-100.0, 100.0)


def look(numbers: Sequence[float], values: MutableSequence[float], near: int, place: float) -> None:
    """Values at a place."""
    at = element_at(numbers, 0, len(numbers) // ELEMENT, near, place)
    s, v, a, j = element_values(numbers, ELEMENT * at, place)
    values[0] = s
    values[1] = v
    values[2] = a
    values[3] = j


KERNEL = Kernel("elements", look, {})


@given(
    st.lists(NUMBERS, min_size=COEFFICIENTS, max_size=COEFFICIENTS),
    st.tuples(*[NUMBERS] * 6),
    st.floats(0.01, 10.0),
    NUMBERS,
    st.floats(0.0, 1.0),
)
def test_values_are_a_polynomial_and_two_sines(
    coefficients: list[float],
    sines: tuple[float, float, float, float, float, float],
    rate: float,
    begin: float,
    w: float,
) -> None:
    element = make_element(begin, rate, coefficients, sines[:3], sines[3:])
    place = begin + w / rate
    w = (place - begin) * rate
    size, turn, lead, second, second_turn, second_lead = sines
    expected = [
        sum(each * w**k for k, each in enumerate(coefficients)),
        sum(k * each * w ** (k - 1) for k, each in enumerate(coefficients) if k),
        sum(k * (k - 1) * each * w ** (k - 2) for k, each in enumerate(coefficients) if k > 1),
        sum(
            k * (k - 1) * (k - 2) * each * w ** (k - 3)
            for k, each in enumerate(coefficients)
            if k > 2
        ),
    ]
    for one, two, three in ((size, turn, lead), (second, second_turn, second_lead)):
        x = two * w + three
        expected[0] += one * sin(x)
        expected[1] += one * two * cos(x)
        expected[2] -= one * two**2 * sin(x)
        expected[3] -= one * two**3 * cos(x)
    for order, (result, value) in enumerate(
        zip(element_values(element, 0, place), expected, strict=True)
    ):
        assert result == pytest.approx(value * rate**order, rel=1e-9, abs=1e-9 * 1e6 * rate**order)


@pytest.mark.parametrize("near", range(-1, 5))
def test_the_element_is_the_last_that_has_begun_and_leads_to_the_end(near: int) -> None:
    numbers = sum((make_element(x, 1.0, (0.0,)) for x in (0.0, 1.0, 4.0)), array("d"))
    places = (-1.0, 0.0, 0.5, 1.0, 3.9, 4.0, 4.1)
    results = [element_at(numbers, 0, 3, near, place) for place in places]
    assert results == [0, 0, 0, 1, 1, 1, 2]
    behind = make_element(-9.0, 1.0, (0.0,)) + numbers
    assert [element_at(behind, ELEMENT, 3, near, place) for place in (-5.0, 4.0, 7.0)] == [0, 1, 2]


def test_before_its_begin_an_element_stands() -> None:
    element = segment(1, 10.0, 20.0, 3.0, Ends(5.0))
    assert element_values(element, 0, 9.0) == (3.0, 0.0, 0.0, 0.0)
    assert element_values(element, 0, 10.0) == (3.0, 0.5, 0.0, 0.0)


@given(
    st.sampled_from(sorted(LAWS)),
    st.tuples(*[NUMBERS] * 7),
    NUMBERS,
    st.floats(-0.2, 1.2),
    st.integers(-1, 6),
)
def test_machine_code_has_the_same_bits(
    law: int, ends: tuple[float, ...], begin: float, part: float, near: int
) -> None:
    end = begin + 7.0
    elements = segment(law, begin, end, 1.5, Ends(*ends)) + standing(end, 1.5 + ends[0])
    values, compiled = array("d", [0.0] * 4), array("d", [0.0] * 4)
    place = begin + part * 7.0
    KERNEL.bind(*elements.buffer_info(), *compiled.buffer_info())(near, place)
    look(elements, values, near, place)
    assert compiled == values
