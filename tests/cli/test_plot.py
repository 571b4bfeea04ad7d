"""The plot shows the curve: every dot where the equation says, scales with round numbers."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.cli.plot import Panel, braille, plot, ticks

BITS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))


def dots(lines: Sequence[str]) -> set[tuple[int, int]]:
    """Column and row (0 at the bottom) of each dot of a canvas."""
    height = len(lines)
    return {
        (2 * x + right, 4 * (height - y) - 1 - down)
        for y, line in enumerate(lines)
        for x, sign in enumerate(line)
        if sign != " "
        for right in (0, 1)
        for down in range(4)
        if ord(sign) - 0x2800 & BITS[right][down]
    }


def test_a_diagonal() -> None:
    assert braille([(0, 0), (7, 7)], 4, 2) == ["  ⡠⠊", "⡠⠊  "]


def test_a_step_is_a_vertical_line() -> None:
    assert braille([(0, 0), (2, 0), (2, 7), (5, 7)], 3, 2) == [" ⡏⠉", "⣀⡇ "]


def test_what_lies_outside_is_drawn_on_the_border() -> None:
    assert dots(braille([(0, 9), (3, 9)], 2, 1)) == {(x, 3) for x in range(4)}


@pytest.mark.parametrize(
    "curve",
    [
        pytest.param(lambda t: 100 * t * t * (3 - 2 * t), id="smooth step"),
        pytest.param(lambda t: 250 * min(t, 1 - t), id="triangle"),
        pytest.param(lambda t: -40 + 80 * math.cos(5 * t), id="wave"),
    ],
)
def test_each_dot_is_on_the_curve(curve: Callable[[float], float]) -> None:
    times = [n / 500 for n in range(501)]
    width, height = 60, 9
    lines = plot(times, [Panel("p", [curve(t) for t in times])], width=width, height=height)
    start = lines[1].index("┤") + 1
    margin_label = {float(line[: start - 2]): n for n, line in enumerate(lines) if "┤" in line}
    low, high = min(margin_label), max(margin_label)
    assert (margin_label[high], margin_label[low]) == (1, height)
    canvas = [line[start:] for line in lines[1 : 1 + height]]
    across, up = 2 * (width - start) - 1, 4 * height - 1
    drawn = dots(canvas)
    assert {column for column, _ in drawn} == set(range(across + 1))
    reach = 0.5 / across + 1 / 500
    for column, row in drawn:
        time = column / across
        near = [curve(time + part * reach) for part in (-1, -0.5, 0, 0.5, 1)]
        slack = 1.01 * (high - low) / up
        assert min(near) - slack <= low + row * (high - low) / up <= max(near) + slack


def test_a_whole_picture() -> None:
    """22 dots across, 8 up: the ramp rises one dot every three columns."""
    ramp = plot([0, 1, 2], [Panel("speed mm/s", [0, 50, 100])], width=16, height=2)
    assert ramp == [
        "    speed mm/s",
        "100 ┤     ⢀⣀⠤⠔⠒⠉",
        "  0 ┤⣀⠤⠔⠒⠉⠁",
        "    └┬────┬────┬",
        "     0    1 s",
    ]


def test_panels_share_the_time_axis() -> None:
    lines = plot([0, 1], [Panel("a", [0, 1]), Panel("b", [0, 1000])], width=30, height=3)
    assert [line.strip() for line in (lines[0], lines[4])] == ["a", "b"]
    assert len({line.index("┤") for line in lines if "┤" in line}) == 1
    assert sum("└" in line for line in lines) == 1
    assert max(map(len, lines)) <= 30


def test_without_time_there_is_no_picture() -> None:
    assert plot([], [Panel("p", [])]) == []
    assert plot([1.0, 1.0], [Panel("p", [0, 1])]) == []


FINITE = st.floats(-1e6, 1e6)


@given(FINITE, FINITE, st.integers(3, 12))
def test_ticks_hold_the_values(one: float, other: float, most: int) -> None:
    low, high = sorted((one, other))
    scale = ticks(low, high, most)
    steps = [after - before for before, after in pairwise(scale)]
    assert 2 <= len(scale) <= most
    assert all(math.isclose(step, steps[0], rel_tol=1e-6) for step in steps)
    slack = 0.011 * (high - low) + 1e-9 * max(abs(low), abs(high))
    assert scale[0] <= low + slack
    assert scale[-1] >= high - slack


@pytest.mark.parametrize(
    ("low", "high", "most", "expected"),
    [
        (0, 100, 5, [0, 25, 50, 75, 100]),
        (0, 100.3, 5, [0, 25, 50, 75, 100]),
        (-0.2, 0.3, 6, [-0.2, -0.1, 0, 0.1, 0.2, 0.3]),
        (0, 0, 5, [-0.5, -0.25, 0, 0.25, 0.5]),
        (319.089, 319.089, 5, [318.5, 319, 319.5, 320]),
    ],
)
def test_ticks_are_round(low: float, high: float, most: int, expected: list[float]) -> None:
    assert ticks(low, high, most) == pytest.approx(expected)
