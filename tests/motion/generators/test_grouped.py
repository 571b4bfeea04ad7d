"""Set points from a group: taken as they are, unless the axis cannot be there."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands


def driven_by_group(rig: Any) -> Any:
    assert commands.join_group(rig.axis) == 0
    commands.begin_group_motion(rig.axis)
    return rig.axis


@pytest.mark.parametrize("compiled", [False, True])
def test_the_axis_is_where_its_group_wants_it(make_rig: Any, compiled: bool) -> None:
    rig = make_rig(compiled=compiled)
    axis = driven_by_group(rig)
    for n in range(1, 100):
        axis.group_set_point.position, axis.group_set_point.velocity = n * 0.1, 50.0
        rig.run(1)
        assert (axis.set_position, axis.set_velocity) == (n * 0.1, 50.0)
    commands.end_group_motion(axis)
    rig.run(1)
    assert (axis.set_position, axis.set_velocity) == (9.9, 0.0)


@pytest.mark.parametrize(
    ("position", "values", "error"),
    [
        (100.0, {}, NcError.SET_VELOCITY_TOO_HIGH),
        (float("nan"), {}, NcError.EXTERNAL_SETPOINT_DATA),
        (
            0.5,
            {"encoder_soft_limit_max_enable": 1, "encoder_soft_limit_max": 0.4},
            NcError.SOFT_LIMIT_MAX_PASSED,
        ),
        (
            -0.5,
            {"encoder_soft_limit_min_enable": 1, "encoder_soft_limit_min": -0.4},
            NcError.SOFT_LIMIT_MIN_PASSED,
        ),
    ],
)
def test_where_the_axis_cannot_be(
    make_rig: Any, position: float, values: dict[str, float], error: NcError
) -> None:
    rig = make_rig(**values)
    axis = driven_by_group(rig)
    axis.group_set_point.position = position
    rig.run(1)
    assert axis.error_code == error
    rig.seconds(0.5)
    assert axis.set_velocity == 0.0
    assert abs(axis.set_position) < 0.01
