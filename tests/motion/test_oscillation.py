"""Oscillations: reversing with pauses, velocity steps, sine and frequency sequence."""

from itertools import pairwise
from math import cos, pi, sin, sqrt
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


def test_velocity_steps_jump_and_pause(rig: Any) -> None:
    axis = rig.axis
    axis.controller_following_error_position_monitoring_enable = 0
    assert commands.start_velocity_steps(axis, 1, 80.0, -50.0, 0.1, 0.05, 2) == 0
    sequence = [80.0] * 50 + [0.0] * 25 + [-50.0] * 50 + [0.0] * 25
    position = axis.set_position
    for velocity in sequence * 2:
        rig.run(1)
        position += velocity * rig.dt
        assert axis.set_velocity == velocity
        assert axis.set_acceleration == 0.0
        assert axis.set_position == pytest.approx(position, abs=1e-9)
        assert rig.has(StateBit.HAS_JOB)
        assert rig.has(StateBit.CONTINUOUS_MOTION)
        assert rig.has(StateBit.POSITIVE_DIRECTION) == (velocity > 0.0)
        assert rig.has(StateBit.NEGATIVE_DIRECTION) == (velocity < 0.0)
    rig.run(1)
    assert rig.has(StateBit.NOT_MOVING)
    assert axis.set_command_state == CommandState.DONE
    assert axis.set_position == pytest.approx(2 * (80.0 - 50.0) * 0.1)
    rig.seconds(1.0)
    assert rig.has(StateBit.IN_TARGET_POSITION)


def test_velocity_steps_without_pause_or_end(rig: Any) -> None:
    rig.axis.controller_following_error_position_monitoring_enable = 0
    commands.start_velocity_steps(rig.axis, 1, 80.0, -80.0, 0.02, 0.0, 0)
    trace = rig.trace(4000)
    assert [v for _, v, _ in trace[1:41]] == [80.0] * 10 + [-80.0] * 10 + [80.0] * 10 + [-80.0] * 10
    assert rig.axis.set_motion_phase == MotionPhase.VELOCITY_STEPS


def test_the_override_scales_velocity_steps(rig: Any) -> None:
    rig.axis.controller_following_error_position_monitoring_enable = 0
    rig.axis.velocity_override = 250_000
    commands.start_velocity_steps(rig.axis, 1, 80.0, -50.0, 0.1, 0.05, 0)
    rig.run(1)
    assert rig.axis.set_velocity == 20.0
    rig.axis.velocity_override = 0
    rig.run(1)
    assert rig.axis.set_velocity == 0.0


def test_a_stop_of_velocity_steps_is_a_ramp(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS, controller_following_error_position_monitoring_enable=0)
    axis = rig.axis
    commands.start_velocity_steps(axis, 1, 180.0, -50.0, 1.0, 0.0, 0)
    rig.run(100)
    p = axis.set_position
    commands.stop(axis)
    took = rig.until_rest()
    assert took == pytest.approx((180.0 / A + A / J) / rig.dt, abs=1)
    assert axis.set_position == pytest.approx(p + 180.0 * (180.0 / A + A / J) / 2.0, abs=0.01)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)


BASE, FREQUENCY = 40.0, 1.953125
"""256 cycles of 2 ms are one period."""

SINE = (1, BASE, FREQUENCY, 0.0, 10.0, 20.0, 100.0, 2.048, 3, 1)


def test_a_single_sine_is_one_of_the_velocity(rig: Any) -> None:
    axis, omega = rig.axis, 2.0 * pi * FREQUENCY
    assert commands.start_sine_oscillation(axis, *SINE) == 0
    for cycle in range(1, cycles(3 * 2.048, rig.dt) + 1):
        rig.run(1)
        angle = omega * cycle * rig.dt
        assert axis.set_velocity == pytest.approx(BASE * sin(angle), abs=1e-9)
        assert axis.set_acceleration == pytest.approx(BASE * omega * cos(angle), abs=1e-6)
        assert axis.set_position == pytest.approx(BASE / omega * (1.0 - cos(angle)), abs=1e-9)
        assert rig.has(StateBit.HAS_JOB)
        assert rig.has(StateBit.CONTINUOUS_MOTION)
    rig.run(1)
    assert axis.set_motion_phase == MotionPhase.NONE
    assert axis.set_command_state == CommandState.DONE
    assert axis.set_position == pytest.approx(0.0, abs=1e-9)
    assert axis.error_code == 0


def test_a_frequency_sequence_goes_up_in_equal_ratios(make_rig: Any) -> None:
    rig = make_rig(max_acceleration=1e6, default_acceleration=1e4)
    axis, small = rig.axis, 2.0
    frequencies = [20.0, 20.0 * sqrt(5.0), 100.0]
    assert commands.start_sine_oscillation(axis, 1, BASE, FREQUENCY, small, *SINE[4:]) == 0
    omega, fast = 2.0 * pi * FREQUENCY, 0.0
    position = 0.0
    for step, frequency in enumerate(frequencies):
        for cycle in range(1, cycles(2.048, rig.dt) + 1):
            rig.run(1)
            base = omega * (step * 2.048 + cycle * rig.dt)
            begin, fast = fast, fast + 2.0 * pi * frequency * rig.dt
            velocity = BASE * sin(base) + small * sin(fast)
            assert axis.set_velocity == pytest.approx(velocity, abs=1e-6)
            position += BASE / omega * (cos(base - omega * rig.dt) - cos(base))
            position += small / (2.0 * pi * frequency) * (cos(begin) - cos(fast))
            assert axis.set_position == pytest.approx(position, abs=1e-6)
    rig.until_rest(0.2)
    assert axis.error_code == 0


def test_amplitudes_follow_the_override_without_a_jump(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS)
    axis, omega = rig.axis, 2.0 * pi * FREQUENCY
    commands.start_sine_oscillation(axis, *SINE)
    rig.run(64)
    assert axis.set_velocity == pytest.approx(BASE)
    axis.velocity_override = 0
    before = BASE
    for _ in range(cycles(2 * BASE / A, rig.dt)):
        rig.run(1)
        assert abs(axis.set_velocity - before) <= (BASE * omega + A) * rig.dt
        before = axis.set_velocity
    rig.run(1)
    assert axis.set_velocity == 0.0
    assert axis.set_motion_phase == MotionPhase.SINE
    axis.velocity_override = 1_000_000
    assert max(v for _, v, _ in rig.trace(512)) == pytest.approx(BASE, rel=1e-3)


def test_the_set_values_of_a_fading_sine_belong_together(make_rig: Any) -> None:
    rig = make_rig(**DYNAMICS | {"default_acceleration": 100.0})
    axis, dt = rig.axis, rig.dt
    commands.start_sine_oscillation(axis, *SINE)
    rig.run(40)
    axis.velocity_override = 0
    rig.run(2)
    trace = rig.trace(cycles(0.5 * BASE / 100.0, dt))
    omega = 2.0 * pi * FREQUENCY
    bend = BASE * omega**2 * dt**3 / 6.0  # twice what a chord leaves of an arc
    for (p0, v0, a0), (p1, v1, a1) in pairwise(trace):
        assert p1 - p0 == pytest.approx(0.5 * (v0 + v1) * dt, abs=bend)
        assert v1 - v0 == pytest.approx(0.5 * (a0 + a1) * dt, abs=omega * bend)


def test_a_stop_of_a_sine_leads_on_smoothly(make_rig: Any) -> None:
    rig = make_rig(max_acceleration=1e6)
    axis = rig.axis
    commands.start_sine_oscillation(axis, 1, BASE, FREQUENCY, 4.0, 10.0, 100.0, 100.0, 2.0, 1, 1)
    rig.run(40)
    p, v, a = axis.set_position, axis.set_velocity, axis.set_acceleration
    assert commands.stop(axis) == 0
    trace = rig.trace(1)
    assert abs(trace[1][1] - v) <= abs(a) * rig.dt + axis.job_jerk * rig.dt**2
    rig.until_rest()
    assert abs(axis.set_position - p) < 5.0
    assert axis.error_code == 0
