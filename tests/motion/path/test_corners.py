"""Transitions: the values of the printed rules."""

from math import pi, radians

import pytest

from achse.motion.path.corners import ReductionMethod, angle_between, corner_factor, transition
from achse.motion.path.parameters import PathLimits, PathParameters
from achse.motion.path.record import (
    PieceKind,
    axis_record,
    piece_record,
    state_record,
)


@pytest.mark.parametrize(
    ("degrees", "factor"),
    [
        (30, 1.931851653),
        (60, 1.316074013),
        (90, 1.0),
        (120, 0.759835686),
        (150, 0.517638090),
    ],
)
def test_coulomb(degrees: float, factor: float) -> None:
    found = corner_factor(ReductionMethod.COULOMB, radians(degrees), 0.5, 0.0, pi)
    assert found == pytest.approx(min(1.0, 0.5 * factor), abs=1e-9)


def test_coulomb_at_its_ends() -> None:
    assert corner_factor(ReductionMethod.COULOMB, pi, 0.3, 0.0, pi) == 0.3
    assert corner_factor(ReductionMethod.COULOMB, pi, 0.3, pi, pi) == 1.0
    assert corner_factor(ReductionMethod.COULOMB, 0.1, 0.0, 0.0, pi) == 0.0


@pytest.mark.parametrize(
    ("degrees", "factor"),
    [
        (5, 1.0),
        (10, 1.0),
        (30, 0.903508193),
        (50, 0.722162916),
        (70, 0.477837084),
        (90, 0.2),
        (170, 0.2),
    ],
)
def test_cosine(degrees: float, factor: float) -> None:
    low, high = radians(10), radians(90)
    found = corner_factor(ReductionMethod.COSINE, radians(degrees), 0.2, low, high)
    assert found == pytest.approx(factor, abs=1e-9)


@pytest.mark.parametrize(("degrees", "factor"), [(9, 1.0), (50, 0.4), (91, 0.0)])
def test_deviation_angle(degrees: float, factor: float) -> None:
    method = ReductionMethod.DEVIATION_ANGLE
    assert corner_factor(method, radians(degrees), 0.4, radians(10), radians(90)) == factor


def test_a_jump_of_velocity_is_what_the_axis_can_do_in_a_cycle() -> None:
    """Corner of 90°, factor 1, 2000 mm/s², 2 ms: 4 mm/s."""
    state = state_record()
    state.cycle_time, state.used = 0.002, 3
    PathParameters(method=ReductionMethod.VELO_JUMP).fill(state)
    axes = [axis_record() for _ in range(8)]
    for axis in axes:
        PathLimits(1000.0, 2000.0, 1e5).fill(axis, 0.002)
    before, after = piece_record(), piece_record()
    for piece, direction in ((before, 0), (after, 1)):
        piece.kind, piece.length, piece.whole = int(PieceKind.LINE), 10.0, 10.0
        piece.feed = piece.start_feed = piece.caps[0] = 100.0
        piece.spans = 1
        piece.slope[direction] = 1.0
    assert transition(before, after, axes, state) == pytest.approx(4.0)
    assert angle_between(state.before, state.after) == pytest.approx(pi / 2)
    PathParameters(method=ReductionMethod.VELO_JUMP, least_velocity=7.0).fill(state)
    assert transition(before, after, axes, state) == 7.0
