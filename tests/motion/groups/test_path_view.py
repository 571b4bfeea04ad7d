"""States of a path: ways add up, velocities fit the axes, errors are along and beside it."""

from math import hypot
from typing import Any

import pytest

from achse.motion.path import PathLine


def test_states_of_a_slanted_line(make_groups: Any) -> None:
    rig = make_groups(values={"default_jerk": 20_000.0})
    assert rig.path.assign([1, 2, 3]) == 0
    view = rig.path.view
    assert (view.remaining, view.velocity, view.target[0], view.override_percent) == (
        *(0.0, 0.0, 0.0, 100.0),
    )
    assert rig.path.begin() == 0
    end = (30.0, 40.0, 0.0)
    assert rig.path.append(PathLine(end, 100.0)) == 0
    rig.path.total_remaining_path_enable = 1
    for _ in range(200):
        rig.run()
        set_velocity = hypot(rig.axis(1).set_velocity, rig.axis(2).set_velocity)
        assert view.velocity == pytest.approx(set_velocity, abs=1e-6)
        assert view.done + view.remaining == pytest.approx(50.0)
        assert view.total_remaining == pytest.approx(view.remaining)
        assert view.done_normalized == pytest.approx(view.done / 50.0)
        assert view.safety_distance == pytest.approx(view.remaining - view.stop_distance)
        assert view.orthogonal_error < 1e-2
        assert rig.path.way == pytest.approx(view.done)
    assert view.velocity > 50.0
    assert view.tangential_error > 0.0
    assert view.actual_velocity == pytest.approx(view.velocity, rel=0.1)
    assert view.programmed_velocity == view.velocity_max == 100.0
    assert view.end_velocity_max == 0.0
    assert view.stop_distance < view.remaining
    assert view.target[:3] == end
    assert view.acceleration_abs == pytest.approx(abs(view.acceleration), abs=1e-6)
    assert view.differences[0] == view.set_positions[0] - view.actual_positions[0]
    rig.until(lambda: rig.path.rests)
    rig.path.end()
    rig.run(100)
    assert (view.velocity, view.acceleration) == (0.0, 0.0)
    assert view.actual_acceleration_abs == pytest.approx(abs(view.actual_acceleration))
