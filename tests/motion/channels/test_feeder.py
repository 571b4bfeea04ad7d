"""From canonical commands to motion: order, limits of a cycle, settings of the program."""

from math import atan2, hypot, pi
from typing import Any

import pytest

from achse.codes import NcError
from achse.gcode.canon import ArcMove, DwellTime, LineMove, Origin, PathParameter, PathSetting
from achse.motion.channels.feeder import Feeder, FeedOutcome
from achse.motion.channels.technology import TechnologyOutputs
from achse.motion.path import Smoothing

HERE = Origin("a.nc", 1, 0, 10, 1)


def line(x: float, velocity: float = 100.0, **kind: bool) -> LineMove:
    at = (x - 1.0, 0.0, 0.0)
    return LineMove(HERE, at, (x, 0.0, 0.0), (0.0,) * 5, velocity, velocity, **kind)


def begun(program: Any) -> Feeder:
    assert program.group.begin() == 0
    feeder = Feeder(program.group, TechnologyOutputs())
    feeder.begin_cycle()
    return feeder


def test_so_many_segments_go_over_in_a_cycle(program: Any) -> None:
    program.group.max_commands_per_cycle = 3
    feeder = begun(program)
    assert [feeder.feed(line(float(n))) for n in range(1, 5)] == [FeedOutcome.DONE] * 3 + [
        FeedOutcome.FULL
    ]
    feeder.begin_cycle()
    assert feeder.feed(DwellTime(HERE, 0.1)) is FeedOutcome.DONE
    assert program.group.saf_entry_count == 4


def test_the_table_of_segments_fills(program: Any) -> None:
    program.group.max_commands_per_cycle = 1000
    feeder = begun(program)
    taken = [feeder.feed(line(float(n))) for n in range(1, 140)]
    assert taken.count(FeedOutcome.DONE) == 128
    assert program.group.saf_free_entry_count == 0


def test_rapid_moves_are_as_fast_as_the_axes(program: Any) -> None:
    program.nc.axis(1).rapid_traverse_velocity = 250.0
    feeder = begun(program)
    feeder.feed(line(400.0, 0.0, rapid=True))
    program.cycle(600)
    assert abs(program.nc.axis(1).set_velocity - 250.0) < 1.0


def test_settings_are_of_the_program(program: Any) -> None:
    before = program.group.path_parameters
    feeder = begun(program)
    for parameter, values in (
        (PathParameter.VERTEX_SMOOTHING, (5.0, 1.0, 0.5)),
        (PathParameter.C1_REDUCTION_FACTOR, (0.5,)),
        (PathParameter.C2_REDUCTION_FACTOR, (0.25,)),
        (PathParameter.PATH_DYNAMICS, (100.0, 200.0, 3000.0)),
        (PathParameter.MINIMUM_VELOCITY, (2.0,)),
        (PathParameter.VELO_JUMP, (1.0, 2.0, 3.0)),
        (PathParameter.DYNAMIC_OVERRIDE, (0.5,)),
    ):
        assert feeder.feed(PathSetting(HERE, parameter, values)) is FeedOutcome.DONE
    now = program.group.path_parameters
    assert (now.smoothing, now.smoothing_radius, now.c1, now.c2) == (
        Smoothing.QUINTIC,
        0.5,
        0.5,
        0.25,
    )
    assert (now.acceleration, now.deceleration, now.jerk) == (100.0, 200.0, 3000.0)
    assert (now.least_velocity, program.group.velo_jumps) == (2.0, (1.0, 2.0, 3.0))
    wrong = PathSetting(HERE, PathParameter.VERTEX_SMOOTHING, (9.0, 1.0, 0.5))
    assert feeder.feed(wrong) is FeedOutcome.REFUSED
    assert feeder.error == NcError.GROUP_PARAMETER
    feeder.finish()
    assert program.group.path_parameters == before
    assert program.group.dynamic_override == 1.0


def test_half_the_dynamics_take_longer(program: Any) -> None:
    times = []
    for override in (1.0, 0.25):
        program.run(f"DYNOVR={override}\nG01 X10 F60000\nX0\nM30\n")
        times.append(program.until(lambda: program.channel.state == 2))
        program.finish()
    assert times[1] > 1.5 * times[0]


def test_blocks_that_are_passed_are_forgotten(program: Any) -> None:
    program.group.max_commands_per_cycle = 1000
    feeder = begun(program)
    for n in range(1, 1000):
        while feeder.feed(line(float(n), 1e5)) is FeedOutcome.FULL:
            program.cycle()
            feeder.begin_cycle()
            feeder.pass_marks()
    assert len(feeder._entries) <= 130


def flin(end: tuple[float, float, float], begin: float, velocity: float) -> LineMove:
    return LineMove(HERE, (0.0, 0.0, 0.0), end, (0.0,) * 5, velocity, begin)


@pytest.mark.parametrize(("begin", "velocity"), [(20.0, 100.0), (90.0, 15.0)])
@pytest.mark.parametrize("single", [0, 1])
def test_a_linear_feed_changes_along_the_block(
    program: Any, begin: float, velocity: float, single: int
) -> None:
    """FLIN: the velocity follows the way, in steps of a 32nd of the change; one segment does it."""
    for axis in program.nc:
        axis.default_acceleration = axis.default_deceleration = 1e5
        axis.max_acceleration = axis.max_deceleration = 1e5
        axis.default_jerk = 1e8
    program.group.single_block_mode = single
    feeder = begun(program)
    assert feeder.feed(flin((100.0, 0.0, 0.0), begin, velocity)) is FeedOutcome.DONE
    assert program.group.number == 1
    step = abs(velocity - begin) / 32.0
    seen = 0
    while not program.group.rests:
        program.cycle()
        x = program.nc.axis(1).set_position
        if 5.0 < x < 95.0:
            seen += 1
            wanted = begin + (velocity - begin) * x / 100.0
            assert abs(program.group.view.velocity - wanted) < 0.8 * step, x
            assert abs(program.group.view.programmed_velocity - wanted) < 1e-6
    assert seen > 100
    assert program.at() == [100.0, 0.0, 0.0]


def test_a_linear_feed_keeps_to_the_arc(program: Any) -> None:
    feeder = begun(program)
    arc = ArcMove(
        *(HERE, (0.0, 0.0, 0.0), (20.0, 0.0, 4.0), (10.0, 0.0, 0.0), (0.0, 0.0, 1.0), pi, 4.0),
        *((0.0,) * 5, 60.0, 10.0),
    )
    assert feeder.feed(arc) is FeedOutcome.DONE
    assert program.group.number == 1
    slow = quick = 0.0
    while not program.group.rests:
        program.cycle()
        x, y, z = (program.nc.axis(n).set_position for n in (1, 2, 3))
        assert abs(hypot(x - 10.0, y) - 10.0) < 1e-9
        assert abs(z - 4.0 * (pi - atan2(-y, x - 10.0)) / pi) < 1e-9 or abs(y) < 1e-9
        slow = program.group.view.velocity if x < 2.0 else slow
        quick = max(quick, program.group.view.velocity)
    assert slow < 25.0
    assert quick > 50.0
    assert program.at() == [20.0, 0.0, 4.0]


def test_dynovr_holds_for_all_axes_of_the_path(program: Any) -> None:
    """A part of acceleration and jerk, of auxiliary axes too."""
    assert program.group.assign([1, 2, 3, 4]) == 0
    program.group.max_commands_per_cycle = 100
    for axis, wanted in ((0, (100.0, 0.0, 0.0)), (3, (0.0, 0.0, 0.0))):
        most = {}
        for part in (1.0, 0.25):
            feeder = begun(program)
            feeder.feed(PathSetting(HERE, PathParameter.DYNAMIC_OVERRIDE, (part,)))
            here = program.group.positions
            end = tuple(a + b for a, b in zip(here[:3], wanted, strict=True))
            auxiliary = (here[3] + (100.0 if axis == 3 else 0.0), 0.0, 0.0, 0.0, 0.0)
            move = LineMove(HERE, here[:3], end, auxiliary, 1e4, 1e4)
            assert feeder.feed(move) is FeedOutcome.DONE
            most[part] = 0.0
            moved = program.nc.axis(axis + 1)
            while not program.group.rests:
                program.cycle()
                most[part] = max(most[part], moved.set_acceleration)
            feeder.finish()
            program.group.end()
            program.cycle(5)
        assert most[0.25] < 0.3 * most[1.0]
