"""Master positions for a slave position: the documented example, random curves by brute force."""

import random
from array import array
from collections.abc import Callable

import pytest

from achse.motion.tables.joining import Boundary, join
from achse.motion.tables.memory import HEADER, SPAN, CamMemory
from achse.motion.tables.search import SCANNING, CamCurve, nearest, scan


def curve(places: list[float], values: list[float], cyclic: bool, method: int = 0) -> CamCurve:
    memory, count = CamMemory(), len(places)
    first = memory.take(HEADER + SPAN * count)
    head = 0.0, count, places[0], places[-1] - places[0], values[-1] - values[0], cyclic, 0.0, 0.0
    memory.numbers[first : first + HEADER] = array("d", head)
    arguments = array("d", places), array("d", values), memory.numbers
    join(*arguments, first, method, Boundary.SLOPES, 0.0, 0.0, 0, count)
    return CamCurve(memory.numbers, first)


HILL = [0.0, 135.0, 180.0, 225.0, 360.0], [0.0, 80.0, 100.0, 80.0, 0.0]


@pytest.mark.parametrize(
    ("cyclic", "start", "expected"),
    [(True, 180.0, (135.0, 225.0)), (True, 90.0, (-135.0, 135.0)), (False, 90.0, (None, 135.0))],
)
def test_the_documented_example(
    cyclic: bool, start: float, expected: tuple[float | None, ...]
) -> None:
    places = nearest(curve(*HILL, cyclic), 80.0, start)
    assert tuple(each and each.position for each in places) == expected


def test_with_a_lift_the_solution_may_be_cycles_away() -> None:
    lifted = curve([0.0, 180.0, 360.0], [0.0, 100.0, 360.0], True)
    for start, side in ((90.0, 1), (5000.0, 0)):
        places = nearest(lifted, 1000.0, start)
        there = places[side]
        assert places[1 - side] is None
        assert there is not None
        assert there.lift == 720.0
        assert there.position == 720.0 + there.cam_position
        assert lifted.value(there.cam_position) + 720.0 == pytest.approx(1000.0)


def test_beyond_the_curve_there_is_nothing() -> None:
    assert nearest(curve(*HILL, True), 101.0, 10.0) == (None, None)
    assert nearest(curve(*HILL, False), -1.0, 10.0) == (None, None)
    assert nearest(curve(*HILL, False), 50.0, 1000.0)[1] is None
    assert nearest(curve(*HILL, False), 50.0, -1000.0)[0] is None


@pytest.mark.parametrize("seed", range(40))
def test_the_nearest_is_found(seed: int) -> None:
    """Every place of a fine comb where the curve passes the value is farther than the answer."""
    dice = random.Random(seed)
    places = [dice.uniform(-50.0, 50.0)]
    for _ in range(dice.randint(2, 9)):
        places.append(places[-1] + dice.uniform(5.0, 40.0))
    cyclic = dice.random() < 0.6
    values = [dice.uniform(-50.0, 50.0) for _ in places]
    cam = curve(places, values, cyclic, dice.choice((0, 2)))
    value, start = dice.uniform(-60.0, 60.0), dice.uniform(places[0] - 100.0, places[-1] + 100.0)

    def at(position: float) -> float:
        cycles = (position - cam.begin) // cam.period if cyclic else 0.0
        return cam.value(position - cycles * cam.period) + cycles * cam.stroke

    for side, result in zip((-1.0, 1.0), nearest(cam, value, start), strict=True):
        if result is not None:
            assert at(result.position) == pytest.approx(value, abs=1e-6)
            assert (result.position - start) * side >= -1e-6
        reach = min(abs(result.position - start) if result else 3.0 * cam.period, 3.0 * cam.period)
        before: float | None = None
        for n in range(1500):
            position = start + side * reach * (0.5 + n) / 1501.0
            if not cyclic and not places[0] < position < places[-1]:
                before = None
                continue
            miss = at(position) - value
            if before is not None:
                assert before * miss > 0.0 or abs(miss) + abs(before) < 1e-6
            before = miss


@pytest.mark.parametrize("seed", range(5))
def test_machine_code_scans_as_python(seed: int) -> None:
    """A thousand rows from anywhere, both ways, for any values."""
    if not SCANNING.available:
        pytest.skip("no compiler")
    dice = random.Random(seed)
    places = [float(row) for row in range(1000)]
    cam = curve(places, [dice.uniform(-9.0, 9.0) for _ in places], False, dice.randrange(4))
    numbers = cam._cams
    for _ in range(20):
        low = dice.uniform(-14.0, 14.0)
        rest = cam._rows, 1000, dice.randrange(1000), dice.choice((-1, 1)), low, low + dice.random()
        both = []
        functions: tuple[Callable[..., object], ...] = (scan, SCANNING.function)
        for function in functions:
            results = array("d", [0.0, 0.0, 0.0])
            rows: list[object] = [numbers, results]
            if function is not scan:
                rows = [part for each in (numbers, results) for part in each.buffer_info()]
            function(*rows, *rest)
            both.append(list(results))
        assert both[0] == both[1]
