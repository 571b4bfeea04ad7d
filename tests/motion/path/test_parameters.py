"""Parameters of a path are checked where they are made."""

import pytest

from achse.motion.path.corners import ReductionMethod
from achse.motion.path.parameters import PathLimits, PathOverride, PathParameters
from achse.motion.path.record import axis_record, state_record
from achse.motion.path.segments import PathError


@pytest.mark.parametrize(
    "values",
    [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, float("inf")), (1.0, 1.0, 1.0, -1.0)],
)
def test_limits_of_axes_are_positive(values: tuple[float, ...]) -> None:
    with pytest.raises(PathError):
        PathLimits(*values)


def test_a_jump_is_what_the_axis_can_do_in_a_cycle() -> None:
    row = axis_record()
    PathLimits(100.0, 2000.0, 1e5, velo_jump=1.0).fill(row, 0.002)
    assert row.jump == pytest.approx(4.0)
    assert row.deceleration == 2000.0


@pytest.mark.parametrize(("keep_jerk", "jerk"), [(False, 1e5), (True, 7e4)])
def test_kept_jerk_has_a_share_for_jumps(keep_jerk: bool, jerk: float) -> None:
    row = axis_record()
    PathLimits(100.0, 2000.0, 1e5).fill(row, 0.002, keep_jerk=keep_jerk)
    assert row.jerk == pytest.approx(jerk)
    assert row.bend_jump == pytest.approx(0.3 * 1e5 * 0.002)


@pytest.mark.parametrize(
    "values",
    [
        {"c0": 1.1},
        {"c1": -0.1},
        {"angle_low": 181.0},
        {"method": ReductionMethod.COSINE, "angle_low": 90.0, "angle_high": 10.0},
        {"smoothing_radius": float("nan")},
        {"most_override": 0.5},
    ],
)
def test_parameters_are_within_their_ranges(values: dict[str, float]) -> None:
    with pytest.raises(PathError):
        PathParameters(**values)  # type: ignore[arg-type]


def test_only_one_type_of_override_goes_above_one() -> None:
    state = state_record()
    PathParameters(most_override=1.5).fill(state)
    assert state.most_override == 1.0
    PathParameters(most_override=1.5, override_type=PathOverride.REDUCED_ABOVE).fill(state)
    assert state.most_override == 1.5
