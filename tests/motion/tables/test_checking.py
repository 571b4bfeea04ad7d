"""Steps and reach of a table: machine code and Python say the same."""

import random
from array import array
from ctypes import c_double
from math import inf
from types import SimpleNamespace

import pytest

from achse.motion.tables import checking
from achse.motion.tables.checking import CHECKING, extremes, extremes_of


@pytest.mark.parametrize("rows", [2, 3, 50, 1000, 2500])
def test_all_ways_find_the_same(rows: int) -> None:
    dice = random.Random(rows)
    places = array("d", (dice.uniform(-1e3, 1e3) for _ in range(rows)))
    values = array("d", (dice.uniform(-2e3, 2e3) for _ in range(rows)))
    results = array("d", [0.0] * 3)
    extremes(places, values, results)
    steps = [places[i + 1] - places[i] for i in range(rows - 1)]
    assert list(results) == [min(steps), max(steps), max(map(abs, [*places, *values]))]
    assert extremes_of(places, values) == tuple(results)


def test_numbers_without_end_are_no_steps() -> None:
    places = array("d", [0.0, inf, inf, *range(1000)])
    results = array("d", [0.0] * 3)
    extremes(places, places, results)
    assert not results[0] >= 0.0
    assert CHECKING.plain is not None


@pytest.mark.parametrize(
    ("places", "values", "expected"),
    [
        ([-9.0, 1.0, 2.0], [0.0, 5.0, -6.0], (1.0, 10.0, 9.0)),
        ([0.0, 1.0, 3.0], [0.0, 0.0, -5.0], (1.0, 2.0, 5.0)),
        ([0.0, 1.0, 3.0], [7.0, 0.0, -5.0], (1.0, 2.0, 7.0)),
        ([0.0, 4.0, 1.0], [0.0, 0.0, 0.0], (-3.0, 4.0, 4.0)),
        ([0.0, 1.0], [0.0, 0.5], (1.0, 1.0, 1.0)),
        ([0.0, 0.25], [0.0, 0.125], (0.25, 0.25, 0.25)),
        ([0.0, 2.0, 3.0], [0.0, 0.0, 0.0], (1.0, 2.0, 3.0)),
        ([1.0, 3.0, 8.0], [0.0, 0.0, 0.0], (2.0, 5.0, 8.0)),
    ],
)
def test_steps_and_reach_of_few_rows(
    places: list[float], values: list[float], expected: tuple[float, float, float]
) -> None:
    results = array("d", [0.0] * 3)
    extremes(places, values, results)
    assert tuple(results) == expected
    assert extremes_of(array("d", places), array("d", values)) == expected


def test_step_that_is_no_number_is_the_shortest() -> None:
    results = array("d", [0.0] * 3)
    extremes([0.0, inf, inf], [0.0, 0.0, 0.0], results)
    assert results[0] != results[0]


@pytest.mark.parametrize(
    ("rows", "available", "compiled"),
    [(999, True, False), (1000, True, True), (1000, False, False), (2000, True, True)],
)
def test_machine_code_looks_at_many_rows_where_it_is_at_hand(
    monkeypatch: pytest.MonkeyPatch, rows: int, available: bool, compiled: bool
) -> None:
    calls = []

    def function(*addresses: int) -> None:
        calls.append(addresses)
        pairs = zip(addresses[::2], addresses[1::2], strict=True)
        extremes(*((c_double * count).from_address(at) for at, count in pairs))  # type: ignore[arg-type]

    kernel = SimpleNamespace(available=available, function=function)
    monkeypatch.setattr(checking, "CHECKING", kernel)
    places = array("d", (n * n * 0.5 for n in range(rows)))
    values = array("d", (float(-n) for n in range(rows)))
    far = max(places[-1], -values[-1])
    assert extremes_of(places, values) == (0.5, places[-1] - places[-2], far)
    assert len(calls) == compiled
