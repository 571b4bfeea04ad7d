"""Sine oscillation and frequency sequence."""

from itertools import pairwise
from math import cos, pi, sin, sqrt
from typing import Any

import pytest

from achse.motion import CommandState, MotionPhase, StateBit, commands

A, J, V = 1500.0, 15_000.0, 200.0
DYNAMICS = {"default_acceleration": A, "default_deceleration": A, "default_jerk": J}


def cycles(seconds: float, dt: float) -> int:
    return round(seconds / dt)


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
    assert abs(trace[1][1] - v) <= abs(a) * rig.dt + axis.job.jerk * rig.dt**2
    rig.until_rest()
    assert abs(axis.set_position - p) < 5.0
    assert axis.error_code == 0
