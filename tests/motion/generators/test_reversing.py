"""Reversing: to and fro between two targets, with pauses."""

from typing import Any

import pytest

from achse.motion import CommandState, MotionPhase, StateBit, commands

A, J, V = 1500.0, 15_000.0, 200.0
DYNAMICS = {"default_acceleration": A, "default_deceleration": A, "default_jerk": J}


def move_time(way: float) -> float:
    """Time of a move from rest to rest that reaches V and A."""
    assert V >= A * A / J
    assert way >= V * (V / A + A / J)
    return way / V + V / A + A / J


def cycles(seconds: float, dt: float) -> int:
    return round(seconds / dt)


def test_reversing_goes_to_and_fro_with_its_pauses(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS)
    axis = rig.axis
    assert commands.start_reversing(axis, 1, 100.0, -50.0, V, 0.4) == 0
    number = axis.command_counter
    expected = [(100.0, move_time(100.0)), (-50.0, move_time(150.0)), (100.0, move_time(150.0))]
    for target, seconds in expected:
        took = rig.until(lambda axis: axis.set_motion_phase == MotionPhase.REVERSING)
        assert took == pytest.approx(seconds / rig.dt, abs=2)
        assert axis.set_position == target
        assert axis.target_position == target
        for _ in range(cycles(0.4, rig.dt) - 1):
            assert rig.has(StateBit.HAS_JOB)
            assert not rig.has(StateBit.NOT_MOVING)
            rig.run(1)
            assert axis.set_velocity == 0.0
        assert rig.has(StateBit.IN_TARGET_POSITION)
        rig.run(2)
        assert axis.set_motion_phase == MotionPhase.POSITIONING
    assert axis.set_command_number == number
    assert axis.set_command_state == CommandState.ACTIVE


def test_reversing_without_pause_never_stands(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS)
    commands.start_reversing(rig.axis, 1, 100.0, -50.0, V, 0.0)
    rig.run(1)
    directions: list[float] = []
    for _ in range(cycles(4 * move_time(150.0), rig.dt)):
        before = rig.axis.set_velocity
        rig.run(1)
        if rig.axis.set_direction not in (0.0, *directions[-1:]):
            directions.append(rig.axis.set_direction)
        assert rig.has(StateBit.HAS_JOB)
        assert abs(rig.axis.set_velocity - before) <= A * rig.dt * 1.000001
    assert directions[:4] == [1.0, -1.0, 1.0, -1.0]


@pytest.mark.parametrize("pausing", [False, True])
def test_a_stop_ends_reversing(make_rig: Any, pausing: bool) -> None:
    rig = make_rig(**DYNAMICS)
    axis = rig.axis
    commands.start_reversing(axis, 1, 100.0, -50.0, V, 0.4)
    phase = MotionPhase.REVERSING if pausing else MotionPhase.POSITIONING
    rig.until(lambda axis: axis.set_motion_phase == phase)
    rig.run(150)
    v, p = axis.set_velocity, axis.set_position
    assert commands.stop(axis) == 0
    rig.until_rest()
    assert abs(axis.set_position - p) <= v * v / (2 * A) + v * A / J + 1e-9
    rig.seconds(1.0)
    assert rig.has(StateBit.NOT_MOVING)
    assert not rig.has(StateBit.HAS_JOB)


@pytest.mark.parametrize("phase", [MotionPhase.POSITIONING, MotionPhase.REVERSING])
def test_another_move_takes_over_from_reversing(make_rig: Any, phase: MotionPhase) -> None:
    rig = make_rig(**DYNAMICS)
    commands.start_reversing(rig.axis, 1, 100.0, -50.0, V, 0.4)
    rig.until(lambda axis: axis.set_motion_phase == phase)
    assert commands.universal_start(rig.axis, 1, 33.0, V) == 0
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.set_position == 33.0
    assert rig.axis.set_motion_phase == MotionPhase.NONE


def test_a_buffered_move_follows_at_the_next_target(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS)
    commands.start_reversing(rig.axis, 1, 100.0, -50.0, V, 0.4)
    rig.seconds(0.2)
    commands.universal_start(rig.axis, 1, 33.0, V, buffer_mode=1)
    farthest = max(p for p, _, _ in rig.trace(1500))
    assert farthest == 100.0
    assert rig.axis.set_position == 33.0
    assert rig.axis.set_motion_phase == MotionPhase.NONE


def test_reversing_stops_in_its_pause_without_enable(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS)
    commands.start_reversing(rig.axis, 1, 100.0, -50.0, V, 0.4)
    rig.until(lambda axis: axis.set_motion_phase == MotionPhase.REVERSING)
    rig.axis.control_dword = 6
    rig.run(5)
    assert rig.axis.error_code == 0x4260
    assert rig.axis.set_motion_phase == MotionPhase.NONE
