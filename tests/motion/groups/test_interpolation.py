"""Curves between rows, with SciPy and NumPy as oracles."""

import random

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator, CubicSpline

from achse.motion.groups.interpolation import INTERPOLATIONS
from achse.motion.groups.states import FifoInterpolation


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6])
def test_the_spline_is_the_natural_one(count: int) -> None:
    source = random.Random(count)
    curve = INTERPOLATIONS[FifoInterpolation.CUBIC_SPLINE].curve
    points = [source.uniform(-9.0, 9.0) for _ in range(count)]
    oracle = CubicSpline(range(count), points, bc_type="natural") if count > 2 else None
    for _ in range(20):
        first, share = source.randrange(count - 1), source.random()
        expected = (
            points[0] + (points[1] - points[0]) * share
            if oracle is None
            else float(oracle(first + share))
        )
        assert curve(points, first, share) == pytest.approx(expected)


def test_four_points_make_a_cubic() -> None:
    source = random.Random(4)
    points = [source.uniform(-9.0, 9.0) for _ in range(4)]
    oracle = BarycentricInterpolator(np.arange(4), points)
    curve = INTERPOLATIONS[FifoInterpolation.FOUR_POINT].curve
    for first in range(3):
        for share in (0.0, 0.3, 1.0):
            assert curve(points, first, share) == pytest.approx(float(oracle(first + share)))


def test_a_line() -> None:
    assert INTERPOLATIONS[FifoInterpolation.LINEAR].curve([1.0, 3.0], 0, 0.25) == 1.5
