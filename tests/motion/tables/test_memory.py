"""Cams in memory: spans are found at any place, blocks come and go."""

import random
from array import array
from bisect import bisect_right
from typing import Any

import pytest

from achse.motion.tables.memory import (
    BEGIN,
    COUNT,
    CYCLIC,
    FORM,
    HEADER,
    PERIOD,
    RATE,
    SPAN,
    STEP,
    STROKE,
    CamMemory,
    cam_values,
    row_at,
)


def cam(memory: CamMemory, places: list[float], step: float = 0.0) -> int:
    """Straight lines of slope 2."""
    first = memory.take(HEADER + SPAN * len(places))
    memory.numbers[first : first + HEADER] = array("d", [0.0] * HEADER)
    memory.numbers[first + COUNT] = len(places)
    memory.numbers[first + 2] = places[0]
    memory.numbers[first + STEP] = step
    memory.numbers[first + RATE] = 1.0 / step if step else 0.0
    for n, place in enumerate(places):
        at = first + HEADER + SPAN * n
        slope = 2.0 if n < len(places) - 1 else 0.0
        memory.numbers[at : at + SPAN] = array("d", [place, 2.0 * place, slope, 0.0, 0.0])
    return first


@pytest.mark.parametrize("seed", range(30))
def test_the_row_is_found_from_anywhere(seed: int) -> None:
    dice = random.Random(seed)
    count = dice.randint(2, 60)
    step = dice.choice((0.0, dice.uniform(0.01, 20.0)))
    places = [dice.uniform(-500.0, 500.0)]
    while len(places) < count:
        places.append(
            places[0] + len(places) * step if step else places[-1] + dice.uniform(0.001, 9.0)
        )
    memory = CamMemory()
    first = cam(memory, places, step)
    for _ in range(60):
        place = dice.choice((dice.choice(places), dice.uniform(places[0] - 9.0, places[-1] + 9.0)))
        right = max(bisect_right(places, place) - 1, 0)
        assert row_at(memory.numbers, first, dice.randint(-1, count), place) == right


def test_row_beyond_the_table_is_no_place_to_look_first() -> None:
    memory = CamMemory()
    first = cam(memory, [0.0, 1.0, 3.0])
    end = first + HEADER + 3 * SPAN
    for near in (-1, 3, 1 << 40):
        assert row_at(memory.numbers[:end], first, near, 2.0) == 1


class Counted(list[float]):
    """Numbers that count how often one is read."""

    reads = 0

    def __getitem__(self, index: Any) -> Any:
        self.reads += 1
        return super().__getitem__(index)


@pytest.mark.parametrize(
    ("near", "place", "row", "reads"),
    [
        (2, 3.5, 2, 2),
        (1, 1.0, 1, 2),
        (1, 3.5, 2, 3),
        (1, 3.0, 2, 3),
        (3, 12.0, 4, 2),
        (4, 12.0, 4, 1),
        (3, 3.5, 2, 2),
        (2, 1.0, 1, 2),
        (1, 0.5, 0, 2),
        (0, -1.0, 0, 3),
        (4, 0.5, 0, 4),
        (1, 6.0, 3, 6),
        (-1, 0.5, 0, 2),
        (-1, 1.5, 1, 3),
        (5, 0.5, 0, 2),
        (0, 0.5, 0, 2),
    ],
)
def test_row_is_found_beside_the_one_before(near: int, place: float, row: int, reads: int) -> None:
    """Reads of places: of the row before, of its neighbours, and only then of halves."""
    memory = CamMemory()
    first = cam(memory, [0.0, 1.0, 3.0, 6.0, 10.0])
    numbers = Counted(memory.numbers[: first + HEADER + 5 * SPAN])
    assert row_at(numbers, first, near, place) == row
    assert numbers.reads == 2 + reads


@pytest.mark.parametrize(
    ("place", "row", "reads"),
    [
        (9.0, 0, 1),
        (10.0, 0, 1),
        (10.6, 0, 1),
        (10.75, 1, 2),
        (11.2, 2, 2),
        (11.7, 3, 2),
        (11.5, 3, 2),
        (12.0, 4, 1),
        (99.0, 4, 1),
    ],
)
@pytest.mark.parametrize("near", [0, 4])
def test_row_of_equal_steps_is_computed(place: float, row: int, reads: int, near: int) -> None:
    """Steps of 0.5 from 10 on, less or more by more than a rounding: the neighbour is right."""
    memory = CamMemory()
    first = cam(memory, [10.0, 10.75, 11.0, 11.5, 12.0], 0.5)
    numbers = Counted(memory.numbers[: first + HEADER + 5 * SPAN])
    assert row_at(numbers, first, near, place) == row
    assert numbers.reads == 4 + reads


def test_header_has_a_place_for_each_number() -> None:
    fields = FORM, COUNT, BEGIN, PERIOD, STROKE, CYCLIC, STEP, RATE
    assert sorted(fields) == list(range(HEADER))
    memory = CamMemory()
    assert cam_values(memory.numbers, cam(memory, [0.0, 1.0]), 0, 0.5)[0] == 1.0
    assert row_at(memory.numbers, cam(memory, [0.0, 1.0], 1.0), 0, 0.5) == 0


def test_outside_a_linear_cam_its_ends_hold() -> None:
    memory = CamMemory()
    first = cam(memory, [0.0, 1.0, 3.0])
    assert cam_values(memory.numbers, first, 0, -5.0) == (0.0, 0.0, 0.0, 0.0, 0)
    assert cam_values(memory.numbers, first, 0, 2.0) == (4.0, 2.0, 0.0, 0.0, 1)
    assert cam_values(memory.numbers, first, 0, 99.0) == (6.0, 0.0, 0.0, 0.0, 2)


def test_blocks_stay_and_free_ones_are_used_again() -> None:
    memory = CamMemory()
    a, b, c = (memory.take(size) for size in (100, 50, 70))
    memory.numbers[c] = 7.0
    memory.keep({a, c})
    assert memory.take(50) == b
    big = memory.take(5000)
    assert big > c
    assert memory.numbers[c] == 7.0
    assert memory.arguments == memory.numbers.buffer_info()
    assert len(memory.numbers) >= big + 5000
    memory.keep(())
    assert memory.take(5000) == a


@pytest.mark.parametrize("seed", range(10))
def test_blocks_never_overlap(seed: int) -> None:
    dice = random.Random(seed)
    memory, taken = CamMemory(), dict[int, int]()
    for _ in range(200):
        if taken and dice.random() < 0.4:
            taken.pop(dice.choice(list(taken)))
            memory.keep(taken)
        size = dice.randint(1, 300)
        begin = memory.take(size)
        assert begin > 0
        assert all(begin + size <= other or other + taken[other] <= begin for other in taken)
        assert begin + size <= len(memory.numbers)
        taken[begin] = size
