"""Open loop: the set point follows the axis."""

from typing import Any

from achse.motion.control.open_loop import follow_axis


def test_the_set_point_is_where_the_axis_is_and_as_fast(rig: Any) -> None:
    axis = rig.axis
    axis.actual_position, axis.actual_velocity = 3.0, 7.0
    axis.set_acceleration, axis.set_jerk = 1.0, 2.0
    follow_axis(axis)
    assert (axis.set_position, axis.target_position, axis.set_velocity) == (3.0, 3.0, 7.0)
    assert (axis.set_acceleration, axis.set_jerk) == (0.0, 0.0)
