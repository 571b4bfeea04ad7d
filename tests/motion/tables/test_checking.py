"""Steps and reach of a table: machine code and Python say the same."""

import random
from array import array
from math import inf

import pytest

from achse.motion.tables.checking import CHECKING, extremes, extremes_of


@pytest.mark.parametrize("rows", [2, 3, 50, 1000, 2500])
def test_all_ways_find_the_same(rows: int) -> None:
    dice = random.Random(rows)
    places = array("d", (dice.uniform(-1e3, 1e3) for _ in range(rows)))
    values = array("d", (dice.uniform(-2e3, 2e3) for _ in range(rows)))
    found = array("d", [0.0] * 3)
    extremes(places, values, found)
    steps = [places[i + 1] - places[i] for i in range(rows - 1)]
    assert list(found) == [min(steps), max(steps), max(map(abs, [*places, *values]))]
    assert extremes_of(places, values) == tuple(found)


def test_numbers_without_end_are_no_steps() -> None:
    places = array("d", [0.0, inf, inf, *range(1000)])
    found = array("d", [0.0] * 3)
    extremes(places, places, found)
    assert not found[0] >= 0.0
    assert CHECKING.plain is not None
