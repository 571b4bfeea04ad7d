"""PathPlanner: segments in, set points out, commands between."""

from math import dist

import pytest

from achse.motion.path import (
    PathArc,
    PathDwell,
    PathError,
    PathLimits,
    PathLine,
    PathParameters,
    PathPlanner,
    PathTableFull,
    Smoothing,
    plane_arc,
)
from achse.motion.path.compiled import KERNEL

AXES = [PathLimits(1000.0, 1000.0, 10000.0)] * 3


def planner(**options: int) -> PathPlanner:
    return PathPlanner(AXES, (0, 0, 0), **options)  # type: ignore[arg-type]


def run(path: PathPlanner, most: int = 20_000) -> int:
    for cycle in range(most):
        if path.finished:
            return cycle
        path.advance()
    raise AssertionError("the path does not end")


def test_a_full_table_refuses_and_frees_itself() -> None:
    path = planner(table=2)
    path.append(PathLine((1, 0, 0), 100))
    path.append(PathLine((1, 1, 0), 100))
    assert path.free == 0
    with pytest.raises(PathTableFull):
        path.append(PathLine((0, 1, 0), 100))
    while path.free == 0:
        path.advance()
    assert path.append(PathLine((0, 1, 0), 100))
    run(path)
    assert path.position == pytest.approx((0, 1, 0))


@pytest.mark.parametrize("kind", list(Smoothing))
@pytest.mark.parametrize("keep_jerk", [False, True])
def test_kept_jerk_holds_where_the_curvature_jumps(kind: Smoothing, keep_jerk: bool) -> None:
    """Half a circle without a corner, then corners that the smoothing rounds, in Q1 too."""
    axes = [PathLimits(300.0, 2000.0, 40000.0)] * 3 + [PathLimits(300.0, 2000.0, 4000.0)]
    settings = PathParameters(keep_jerk=keep_jerk, smoothing=kind, smoothing_radius=3.0)
    path = PathPlanner(axes, (0, 0, 0, 0), parameters=settings, compiled=KERNEL.available)
    path.append(PathLine((20, 0, 0, 0), 100))
    half = plane_arc((20, 0, 0), (20, 20, 0), centre=(20, 10), clockwise=False)
    path.append(PathArc(half, 100))
    for end in ((0, 20, 0, 5), (0, 40, 0, 0), (9, 40, 9, -5)):
        path.append(PathLine(end, 100))
    before, worst = path.axis_acceleration, 0.0
    while not path.finished:
        path.advance()
        steps = zip(axes, path.axis_acceleration, before, strict=True)
        worst = max(worst, *(abs(a - b) / (axis.jerk * 0.002) for axis, a, b in steps))
        before = path.axis_acceleration
    if keep_jerk:
        assert worst <= 1.0001
    else:
        assert worst > 10.0  # into the half circle


def test_lines_at_once_are_those_one_by_one() -> None:
    points = [(n * 0.5, (n % 3) * 0.2, 0.0) for n in range(1, 20)]
    one, all_at_once = planner(), planner()
    for n, point in enumerate(points):
        one.append(PathLine(point, 50, block=n))
    assert all_at_once.append_lines(points, 50) == 19
    while not one.finished:
        one.advance()
        all_at_once.advance()
        assert one.position == all_at_once.position
        assert one.block == all_at_once.block


def test_a_full_circle_is_closed() -> None:
    path = planner()
    path.append(PathLine((10, 0, 0), 100))
    path.append(PathArc(plane_arc((10, 0, 0), (10, 0, 0), clockwise=False, centre=(0, 0)), 100))
    run(path)
    assert dist(path.position, (10, 0, 0)) < 1e-9


def test_hold_and_step_on() -> None:
    path = planner()
    path.append(PathLine((100, 0, 0), 100))
    path.advance(200)
    path.hold()
    path.advance(200)
    assert path.standstill
    before = path.position
    path.advance(100)
    assert path.position == before
    path.step_on()
    run(path)
    assert path.position == (100, 0, 0)


def test_an_emergency_stop_is_shorter_and_keeps_the_axes_limits() -> None:
    ways = []
    for strong in (False, True):
        parameters = PathParameters(acceleration=200.0, deceleration=200.0, jerk=2000.0)
        path = PathPlanner(AXES, (0, 0, 0), parameters=parameters)
        path.append(PathLine((300, 0, 0), 100))
        path.advance(1000)
        begin = path.position[0]
        if strong:
            path.emergency_stop(5000.0, 1e6)
        else:
            path.hold()
        most = 0.0
        while not path.standstill:
            path.advance()
            most = max(most, abs(path.axis_acceleration[0]))
        ways.append(path.position[0] - begin)
        assert most <= 1000.0 * (1 + 1e-9)
        path.step_on()
        run(path)
        assert path.position[0] == 300.0
    assert ways[1] < 0.6 * ways[0]


def test_a_second_emergency_stop_does_not_weaken_the_first() -> None:
    ways = []
    for again in (False, True):
        parameters = PathParameters(deceleration=100.0, jerk=1000.0)
        path = PathPlanner(AXES, (0, 0, 0), parameters=parameters)
        path.append(PathLine((300, 0, 0), 100))
        path.advance(700)
        path.emergency_stop(900.0, 9000.0)
        path.advance(10)
        if again:
            path.emergency_stop(100.0, 1000.0)
        path.advance(300)
        assert path.standstill
        ways.append(path.position[0])
    assert ways[0] == ways[1]


def test_dwell_and_zero_length() -> None:
    path = planner()
    path.append(PathLine((10, 0, 0), 100))
    assert not path.append(PathLine((10, 0, 0), 100))
    path.append(PathDwell(0.1, block=7))
    path.append(PathLine((20, 0, 0), 100))
    cycles = run(path)
    other = planner()
    other.append(PathLine((10, 0, 0), 100, exact_stop=True))
    other.append(PathLine((20, 0, 0), 100))
    assert cycles - run(other) in (50, 51)


def test_delete_distance_to_go() -> None:
    path = planner()
    path.append(PathLine((100, 0, 0), 100))
    path.advance(100)
    with pytest.raises(PathError):
        path.delete_distance_to_go()
    path.hold()
    while not path.standstill:
        path.advance()
    here = path.position
    path.delete_distance_to_go()
    assert path.finished
    assert path.programmed_position == here
    path.append(PathLine((0, 50, 0), 100))
    run(path)
    assert path.position == pytest.approx((0, 50, 0))


def test_single_block() -> None:
    path = planner()
    path.single_block = True
    for n in range(3):
        path.append(PathLine((10 * (n + 1), 0, 0), 100, block=n))
    for n in range(3):
        path.advance(1000)
        assert path.position == pytest.approx((10 * (n + 1), 0, 0))
        path.next_block()
    assert path.finished


def test_single_block_that_is_switched_off_waits_for_the_next_block() -> None:
    path = planner()
    path.single_block = True
    for n in range(3):
        path.append(PathLine((10 * (n + 1), 0, 0), 100, block=n))
    path.advance(1000)
    for on in (False, True, False):
        path.single_block = on
        path.advance(1000)
        assert path.position == pytest.approx((10, 0, 0))
    path.next_block()
    run(path)
    assert path.position == pytest.approx((30, 0, 0))


def test_the_path_goes_back() -> None:
    path = planner()
    path.append(PathLine((10, 0, 0), 100))
    path.append(PathArc(plane_arc((10, 0, 0), (20, 10, 0), clockwise=True, centre=(20, 0)), 50))
    path.append(PathLine((20, 30, 0), 100))
    there = []
    while not path.finished:
        path.advance()
        there.append(path.position)
    path.backwards = True
    path.advance(3000)
    assert path.position == pytest.approx((0, 0, 0), abs=1e-9)
    path.backwards = False
    run(path)
    assert path.position == pytest.approx((20, 30, 0))


@pytest.mark.parametrize(
    "segment",
    [
        PathLine((1, 2), 100),
        PathLine((1, 2, float("nan")), 100),
        PathLine((1, 2, 3), 0),
        PathLine((1, 2, 3), float("inf")),
        PathDwell(-1),
        PathArc(plane_arc((1, 0, 0), (2, 0, 0), clockwise=True, radius=5), 10),
    ],
)
def test_wrong_segments_change_nothing(segment: PathLine) -> None:
    path = planner()
    with pytest.raises(PathError):
        path.append(segment)
    assert path.entries == 0
    assert path.finished
    path.append(PathLine((1, 2, 3), 100))
    run(path)
    assert path.position == pytest.approx((1, 2, 3))


def test_wrong_set_ups_are_refused() -> None:
    wrong: tuple[dict[str, object], ...] = (
        {"axes": []},
        {"axes": AXES * 3},
        {"cycle_time": 0.0},
        {"table": 0},
        {"position": (0, 0)},
    )
    for arguments in wrong:
        options: dict[str, object] = {"axes": AXES, "position": (0, 0, 0)} | arguments
        with pytest.raises(PathError):
            PathPlanner(**options)  # type: ignore[arg-type]
