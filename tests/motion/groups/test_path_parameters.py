"""Parameters of a 3D group: each is what was written, and the path uses it."""

from typing import Any

import pytest

from achse.motion.groups.path_parameters import MOST_OVERRIDE
from achse.motion.path import PathError, PathOverride, ReductionMethod

VALUES: tuple[tuple[str, str, Any], ...] = (
    ("reduction_method", "method", ReductionMethod.COSINE),
    ("reduction_factor_c0", "c0", 0.25),
    ("reduction_factor_c1", "c1", 0.5),
    ("reduction_factor_c2", "c2", 0.75),
    ("critical_angle_low", "angle_low", 10.0),
    ("critical_angle_high", "angle_high", 90.0),
    ("min_path_velocity", "least_velocity", 3.0),
    ("keep_jerk", "keep_jerk", True),
    ("override_type", "override_type", PathOverride.ORIGINAL),
)


@pytest.mark.parametrize("begun", [False, True])
def test_parameters_reach_the_path(make_groups: Any, begun: bool) -> None:
    path = make_groups().path
    assert path.assign([1, 2, 3]) == 0
    if begun:
        assert path.begin() == 0
    for name, field, value in VALUES:
        setattr(path, name, value)
        assert getattr(path, name) == value
        assert getattr(path.path_parameters, field) == value
    assert begun or path.begin() == 0
    assert path.planner.parameters == path.path_parameters


def test_an_override_above_100_percent_needs_its_type(make_groups: Any) -> None:
    path = make_groups().path
    path.override_type = PathOverride.REDUCED_ABOVE
    assert path.path_parameters.most_override == MOST_OVERRIDE
    path.override_type = PathOverride.REDUCED
    assert path.path_parameters.most_override == 1.0


def test_a_refused_parameter_changes_nothing(make_groups: Any) -> None:
    path = make_groups().path
    with pytest.raises(PathError, match="c1 2"):
        path.reduction_factor_c1 = 2.0
    assert path.reduction_factor_c1 == 1.0


@pytest.mark.parametrize("by_group", [False, True])
@pytest.mark.parametrize("by_channel", [False, True])
def test_single_block_is_of_the_group_or_of_its_channel(
    make_groups: Any, by_group: bool, by_channel: bool
) -> None:
    path = make_groups().path
    assert path.assign([1, 2, 3]) == 0
    path.single_block_mode = int(by_group)
    assert path.begin() == 0
    path.channel_single_block = by_channel
    assert path.single_block == path.planner.single_block == (by_group or by_channel)
    assert path.single_block_mode == int(by_group)
