"""Back on the path after an emergency stop, to where it is kept, and forward again."""

from math import dist
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion.groups.way_back import WAY_BACK
from achse.motion.path import PathDwell, PathLine

CORNERS = ((20.0, 0.0, 0.0), (20.0, 20.0, 0.0), (40.0, 20.0, 10.0))


@pytest.fixture
def rig(make_groups: Any) -> Any:
    return make_groups()


@pytest.fixture
def running(rig: Any) -> Any:
    """A path of three lines, about in the middle of the second one, at rest by emergency stop."""
    assert rig.path.assign([1, 2, 3]) == 0
    rig.path.keeps_way_back = True
    assert rig.path.begin() == 0
    for corner in CORNERS:
        assert rig.path.append(PathLine(corner, 50.0)) == 0
    while rig.nc.axis(2).set_position < 10.0:
        rig.nc.cycle()
    _stop(rig)
    return rig


def _stop(rig: Any) -> None:
    assert rig.path.emergency_stop(5000.0, 50000.0) == 0
    while not rig.path.stands:
        rig.nc.cycle()


def _at(rig: Any) -> tuple[float, ...]:
    return tuple(rig.nc.axis(n).set_position for n in (1, 2, 3))


def _beside(point: tuple[float, ...]) -> float:
    """How far a point is from the path."""
    best, begin = 1e9, (0.0, 0.0, 0.0)
    for end in CORNERS:
        way = [b - a for a, b in zip(begin, end, strict=True)]
        square = sum(x * x for x in way)
        share = sum((p - a) * x for p, a, x in zip(point, begin, way, strict=True)) / square
        share = min(max(share, 0.0), 1.0)
        best = min(best, dist(point, [a + share * x for a, x in zip(begin, way, strict=True)]))
        begin = end
    return best


def test_back_to_the_first_segment_and_forward_to_the_end(running: Any) -> None:
    group, back = running.path, running.path.way_back
    turned = _at(running)
    assert not back.repeats
    assert back.go(backwards=True) == 0
    assert not group.emergency_stop_active
    seen = set()
    while not back.at_first:
        running.nc.cycle()
        assert back.backwards
        assert back.repeats
        assert _beside(_at(running)) < 1e-9
        seen.add(group.present)
    assert seen == {1, 2}
    assert _at(running) == pytest.approx((0.0, 0.0, 0.0))
    assert not group.rests
    assert back.go(backwards=False) == 0
    while dist(_at(running), turned) > 1e-9 and back.repeats:
        running.nc.cycle()
        assert _beside(_at(running)) < 1e-9
    while not group.rests:
        running.nc.cycle()
        assert not back.backwards
    assert not back.repeats
    assert _at(running) == CORNERS[-1]


def test_stopped_on_the_way_back_and_on_with_it(running: Any) -> None:
    back = running.path.way_back
    assert back.go(backwards=True) == 0
    running.run(20)
    assert back.go(backwards=False) == NcError.CHANNEL_COMMAND_NOT_NOW  # it moves
    _stop(running)
    assert back.backwards
    assert running.path.step_on() == 0  # on in the same direction
    running.run(20)
    assert back.backwards
    _stop(running)
    assert back.go(backwards=False) == 0
    while not running.path.rests:
        running.nc.cycle()
    assert _at(running) == CORNERS[-1]


def test_refused_without_a_kept_path_or_a_stop(rig: Any) -> None:
    assert rig.path.assign([1, 2, 3]) == 0
    back = rig.path.way_back
    assert back.go(backwards=True) == NcError.NCI_GENERATOR_INACTIVE
    assert rig.path.begin() == 0
    rig.path.append(PathLine(CORNERS[0], 50.0))
    rig.run(50)
    _stop(rig)
    assert back.go(backwards=True) == NcError.NCI_GENERATOR_INACTIVE  # it was not to be kept
    rig.path.stop()
    rig.run(100)
    rig.path.reset()
    rig.path.keeps_way_back = True
    assert rig.path.begin() == 0
    rig.path.append(PathLine((0.0, 5.0, 0.0), 50.0))
    rig.run(500)
    assert rig.path.rests
    assert back.go(backwards=True) == NcError.CHANNEL_COMMAND_NOT_NOW  # no emergency stop


def test_so_many_segments_are_kept(rig: Any) -> None:
    assert rig.path.assign([1, 2, 3]) == 0
    rig.path.keeps_way_back = True
    assert rig.path.begin() == 0
    count = 2 * WAY_BACK + 100
    sent = 0
    while sent < count or not rig.path.rests:
        while sent < count and rig.path.free:
            sent += 1
            segment = PathDwell(0.0) if sent % 50 == 0 else PathLine((sent * 0.1, 0.0, 0.0), 50.0)
            assert rig.path.append(segment) == 0
        rig.nc.cycle()
    _stop(rig)
    assert rig.path.way_back.go(backwards=True) == 0
    while not rig.path.way_back.at_first:
        rig.nc.cycle()
    assert rig.path.present > 1
    assert 0.0 < _at(rig)[0] < 0.1 * (count - WAY_BACK)


def test_a_stop_ends_it_anywhere(running: Any) -> None:
    assert running.path.way_back.go(backwards=True) == 0
    running.run(20)
    assert running.path.stop() == 0
    running.run(200)
    assert not running.path.moving
    assert not running.path.way_back.backwards
    assert not running.path.way_back.repeats
    assert _beside(_at(running)) < 1e-9
