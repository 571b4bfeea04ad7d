"""Look-ahead: as fast as the junctions ahead allow, and at rest where the path ends."""

import pytest

from achse.motion.path import (
    PathLimits,
    PathLine,
    PathParameters,
    PathPlanner,
    ReductionMethod,
    Smoothing,
)

AXES = [PathLimits(1000.0, 1000.0, 10000.0)] * 3


def test_without_further_entries_the_path_ends_at_rest() -> None:
    path = PathPlanner(AXES, (0, 0, 0))
    path.append(PathLine((100, 0, 0), 100))
    path.advance(600)
    assert path.position == (100.0, 0.0, 0.0)
    assert path.finished
    assert path.remaining == 0.0


def test_a_line_from_rest_to_rest_takes_the_time_of_seven_phases() -> None:
    """100 mm, 100 mm/s, 1000 mm/s², 10000 mm/s³: 1.2 s."""
    path = PathPlanner(AXES, (0, 0, 0))
    path.append(PathLine((100, 0, 0), 100))
    path.advance(599)
    assert not path.finished
    path.advance()
    assert path.finished


def test_the_lower_velocity_is_reached_where_the_slower_segment_begins() -> None:
    parameters = PathParameters(method=ReductionMethod.COSINE, c0=1.0, angle_high=90.0)
    path = PathPlanner(AXES, (0, 0, 0), parameters=parameters)
    path.append(PathLine((50, 0, 0), 100, block=1))
    path.append(PathLine((80, 0, 0), 20, block=2))
    path.append(PathLine((150, 0, 0), 100, block=3))
    in_second, fastest = [], 0.0
    while not path.finished:
        path.advance()
        fastest = max(fastest, path.velocity)
        if 50.0 < path.position[0] < 80.0:
            in_second.append(path.velocity)
    assert fastest == pytest.approx(100.0)
    assert max(in_second) == pytest.approx(20.0)
    assert min(in_second) == pytest.approx(20.0)


def test_a_brake_that_is_on_ends_within_the_jerk_of_a_weaker_axis() -> None:
    """X brakes hard and Y lets go slowly: the ramp that began in X has to end before Y begins."""
    axes = [PathLimits(500.0, 5000.0, 1e6), PathLimits(500.0, 200.0, 1000.0)]
    parameters = PathParameters(smoothing=Smoothing.QUINTIC, smoothing_radius=2.0)
    path = PathPlanner(axes, (0, 0), parameters=parameters)
    path.append(PathLine((60, 0), 300))
    path.append(PathLine((60, 60), 300))
    before, most = path.axis_acceleration, 0.0
    while not path.finished:
        path.advance()
        path.override = 0.4 if path.position[0] > 40.0 else 1.0
        rises = zip(path.axis_acceleration, before, axes, strict=True)
        most = max(most, *(abs(a - b) / axis.jerk for a, b, axis in rises))
        before = path.axis_acceleration
    assert most <= 0.002 * (1 + 1e-6)
    assert path.state.lost_cycles == 0


def test_single_block_stops_at_the_first_end_it_can() -> None:
    path = PathPlanner(AXES, (0, 0, 0))
    for n in range(4):
        path.append(PathLine((10.0 * (n + 1), 0, 0), 100, block=n))
    while path.position[0] < 9.0:
        path.advance()
    path.single_block = True
    path.advance(1000)
    assert path.position == pytest.approx((20.0, 0, 0))
    assert path.state.lost_cycles == 0
