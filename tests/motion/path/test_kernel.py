"""Appending in the kernel: lengths, tables, curves between."""

import pytest

from achse.motion.path import PathLimits, PathLine, PathParameters, PathPlanner, Smoothing
from achse.motion.path.kernel import AppendOutcome, PathOperation
from achse.motion.path.record import ElementKind

AXES = [PathLimits(1000.0, 1000.0, 10000.0)] * 3


def test_outcomes_have_numbers() -> None:
    assert [AppendOutcome.FULL, AppendOutcome.NO_LENGTH, AppendOutcome.APPENDED] == [-1, 0, 1]
    assert len(PathOperation) == 5


def test_a_curve_comes_between_two_lines() -> None:
    parameters = PathParameters(smoothing=Smoothing.QUINTIC, smoothing_radius=2.0)
    path = PathPlanner(AXES, (0, 0, 0), parameters=parameters)
    path.append(PathLine((10, 0, 0), 100, block=1))
    path.append(PathLine((10, 10, 0), 100, block=2))
    elements = path._elements[:3]
    assert [element.kind for element in elements] == [
        ElementKind.LINE,
        ElementKind.CURVE,
        ElementKind.LINE,
    ]
    assert [element.first for element in elements[1:]] == [
        8.0,
        pytest.approx(8.0 + elements[1].length),
    ]
    assert path.entries == 2
    assert path.total_remaining == pytest.approx(16.0 + elements[1].length)


def test_no_curve_where_the_path_is_already() -> None:
    parameters = PathParameters(smoothing=Smoothing.QUINTIC, smoothing_radius=5.0)
    path = PathPlanner(AXES, (0, 0, 0), parameters=parameters)
    path.append(PathLine((10, 0, 0), 100))
    while path.position[0] < 9.0:
        path.advance()
    path.append(PathLine((10, 10, 0), 100))
    assert path.state.following == 2
