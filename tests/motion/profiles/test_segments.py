"""The set-point table: states along a segment are those of the equations of motion."""

import pytest

from achse.motion.profiles.segments import (
    MAX_SEGMENTS,
    append_segment,
    duration,
    end_state,
    segment_acceleration,
    segment_position,
    segment_velocity,
)


def test_a_segment_of_constant_jerk() -> None:
    """p + vt + at²/2 + jt³/6 and its derivatives, for t = 2, j = 6, p = 1, v = 3, a = 4."""
    assert segment_position(2.0, 6.0, 1.0, 3.0, 4.0) == 1.0 + 6.0 + 8.0 + 8.0
    assert segment_velocity(2.0, 6.0, 3.0, 4.0) == 3.0 + 8.0 + 12.0
    assert segment_acceleration(2.0, 6.0, 4.0) == 16.0


def test_what_rounding_leaves_of_an_acceleration_is_none() -> None:
    assert segment_acceleration(0.1, -3.0, 0.1 * 3.0 * (1.0 + 1e-13)) == 0.0


def test_an_empty_segment_is_not_written() -> None:
    time, jerk = [9.0] * MAX_SEGMENTS, [9.0] * MAX_SEGMENTS
    assert append_segment(time, jerk, 2, 0.0, 5.0) == 2
    assert append_segment(time, jerk, 2, 0.5, 5.0) == 3
    assert (time[2], jerk[2], time[3]) == (0.5, 5.0, 9.0)


def test_a_table_is_walked_segment_by_segment() -> None:
    """A ramp of two seconds each way with jerk 1: acceleration 2, then 0; velocity 4."""
    time, jerk = [2.0, 2.0], [1.0, -1.0]
    assert duration(time, 2) == 4.0
    assert end_state(time, jerk, 1, 0.0, 0.0, 0.0) == pytest.approx((8.0 / 6.0, 2.0, 2.0))
    assert end_state(time, jerk, 2, 0.0, 0.0, 0.0) == pytest.approx((8.0, 4.0, 0.0))
