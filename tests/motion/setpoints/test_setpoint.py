"""Set-point generation against the equations of jerk-limited motion."""

from collections.abc import Callable
from itertools import pairwise
from math import ceil, sqrt
from operator import attrgetter
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion import (
    BufferMode,
    CommandState,
    MotionState,
    OverrideType,
    StartType,
    StateBit,
    commands,
)
from achse.motion.features import Feature
from achse.motion.profiles.ramps import highest_velocity
from achse.motion.setpoints.dynamics import fault_deceleration, fault_jerk
from achse.motion.setpoints.setpoint import arrived, drop_job, fail, stop_fast

V, A, J = 200.0, 1500.0, 2250.0
DT = 0.002


def ramp_time(change: float, limit: float = A, jerk: float = J) -> float:
    """Time of a velocity ramp from and to zero acceleration."""
    if change * jerk <= limit * limit:
        return 2.0 * sqrt(change / jerk)
    return change / limit + limit / jerk


def assert_smooth(samples: list[tuple[float, float, float]], v: float, a: float, j: float) -> None:
    """Each sample inside the limits, and reached from the one before by a permitted jerk."""
    tolerance = 1.0 + 1e-6
    for (p0, v0, a0), (p1, v1, a1) in pairwise(samples):
        assert abs(v1) <= v * tolerance
        assert abs(a1) <= a * tolerance
        assert abs(a1 - a0) <= j * DT * tolerance
        assert abs(v1 - v0 - 0.5 * (a0 + a1) * DT) <= j * DT * DT / 4.0 * tolerance + 1e-9
        assert abs(p1 - p0 - 0.5 * (v0 + v1) * DT) <= a * DT * DT / 4.0 * tolerance + 1e-9


def crossing_velocity(samples: list[tuple[float, float, float]], border: float) -> float:
    """Velocity where the set point passes `border`, from the samples around it.

    There the acceleration is zero; from the sample before, constant jerk leads to it.
    """
    after = next(i for i, (p, _, _) in enumerate(samples) if p > border)
    p, v, a = samples[after - 1]
    t = (border - p) / v
    for _ in range(5):  # v falls or rises by a t / 2 while a runs out
        t = (border - p) / (v + a * t / 3.0)
    return v + 0.5 * a * t


def test_a_move_takes_the_time_of_two_ramps_and_ends_on_its_target(rig: Any) -> None:
    assert commands.start(rig.axis, StartType.ABSOLUTE, 100.0, V) == 0
    peak = (100.0 / 2.0 * sqrt(J)) ** (2.0 / 3.0)  # two ramps of 2 sqrt(v/j) cover the way
    assert peak < V
    samples = rig.trace(ceil(4.0 * sqrt(peak / J) / DT))
    assert samples[-1] == (100.0, 0.0, 0.0)
    assert samples[-2][0] < 100.0
    assert max(v for _, v, _ in samples) == pytest.approx(peak, rel=1e-4)
    assert_smooth(samples, V, A, J)
    assert rig.axis.set_motion_phase == 0


def test_a_long_move_cruises_at_its_velocity(rig: Any) -> None:
    commands.start(rig.axis, StartType.RELATIVE, -400.0, V)
    cycles = ceil((400.0 / V + ramp_time(V)) / DT)
    samples = rig.trace(cycles)
    assert samples[-1] == (-400.0, 0.0, 0.0)
    assert samples[-2][0] > -400.0
    assert min(v for _, v, _ in samples) == pytest.approx(-V, rel=1e-12)
    assert_smooth(samples, V, A, J)


def test_deceleration_is_its_own_limit_in_both_directions(make_rig: Any) -> None:
    for target in (300.0, -300.0):
        rig = make_rig()
        commands.start(rig.axis, StartType.ABSOLUTE, target, V, 500.0, 250.0, 20000.0)
        samples = rig.trace(2000)
        assert samples[-1] == (target, 0.0, 0.0)
        along = [a if target > 0.0 else -a for _, _, a in samples]
        assert max(along) == pytest.approx(500.0)
        assert min(along) == pytest.approx(-250.0)


@pytest.mark.parametrize("override_type", list(OverrideType))
def test_half_override_halves_the_velocity_without_a_jump(
    make_rig: Any, override_type: int
) -> None:
    rig = make_rig(override_type=override_type)
    commands.start(rig.axis, StartType.ABSOLUTE, 1000.0, V)
    before = rig.trace(round(ramp_time(V) / DT) + 100)
    assert before[-1][1] == pytest.approx(V)
    rig.axis.velocity_override = 500_000
    samples = rig.trace(ceil(ramp_time(V / 2.0) / DT) + 1)
    assert samples[-1][1] == pytest.approx(V / 2.0)
    rest = rig.trace(8000)
    assert_smooth(before + samples[1:] + rest[1:], V, A, J)
    assert rest[-1] == (1000.0, 0.0, 0.0)


def test_a_short_move_at_half_override_reaches_half_of_its_peak(make_rig: Any) -> None:
    peak = (10.0 / 2.0 * sqrt(J)) ** (2.0 / 3.0)
    for override_type, expected in (
        (OverrideType.REDUCED, peak / 2.0),
        (OverrideType.ORIGINAL, peak),
    ):
        rig = make_rig(override_type=override_type, velocity_override=500_000)
        commands.start(rig.axis, StartType.ABSOLUTE, 10.0, V)
        fastest = max(v for _, v, _ in rig.trace(1000))
        assert fastest == pytest.approx(expected, rel=1e-3)
        assert rig.axis.set_position == 10.0


def test_override_zero_stands_and_keeps_the_job(rig: Any) -> None:
    commands.start(rig.axis, StartType.ABSOLUTE, 500.0, V)
    rig.seconds(1.0)
    rig.axis.velocity_override = 0
    stopping = rig.trace(ceil(ramp_time(V) / DT) + 1)
    assert_smooth(stopping, V, A, J)
    p, v, a = stopping[-1]
    assert (v, a) == (0.0, 0.0)
    rig.seconds(5.0)
    assert rig.axis.set_position == p
    assert rig.has(StateBit.HAS_JOB)
    assert not rig.has(StateBit.NOT_MOVING)
    assert rig.axis.motion_state == MotionState.OVERRIDE_ZERO
    rig.axis.velocity_override = 1_000_000
    rig.until_rest()
    assert rig.axis.set_position == 500.0


def test_override_zero_at_the_start_waits(make_rig: Any) -> None:
    rig = make_rig(velocity_override=0)
    assert commands.start(rig.axis, StartType.ABSOLUTE, 50.0, V) == 0
    rig.seconds(1.0)
    assert rig.axis.set_position == 0.0
    assert rig.has(StateBit.HAS_JOB)
    rig.axis.velocity_override = 1_000_000
    rig.until_rest()
    assert rig.axis.set_position == 50.0


def test_the_override_does_not_interrupt_braking(rig: Any) -> None:
    commands.start(rig.axis, StartType.ABSOLUTE, 100.0, V)
    rig.until(lambda axis: axis.remaining_time < 0.2)
    rig.axis.velocity_override = 0
    assert rig.until_rest(1.0) <= ceil(0.2 / DT)
    assert rig.axis.set_position == 100.0


def test_the_override_acts_on_the_way_back(rig: Any) -> None:
    commands.start(rig.axis, StartType.ABSOLUTE, 500.0, V)
    rig.seconds(1.5)
    commands.new_end_position(rig.axis, 1, -500.0)
    rig.run(10)
    rig.axis.velocity_override = 250_000
    samples = rig.trace(8000)
    assert min(v for _, v, _ in samples) == pytest.approx(-0.25 * V)
    assert_smooth(samples, V, A, J)


def test_stop_takes_the_configured_deceleration(make_rig: Any) -> None:
    rig = make_rig(default_deceleration=400.0, default_jerk=4000.0)
    commands.start(rig.axis, StartType.ENDLESS_POSITIVE, 0.0, V)
    rig.seconds(2.0)
    begin = rig.axis.set_position
    distance, time = commands.stop_information(rig.axis, 0.0, 0.0)
    assert time == pytest.approx(V / 400.0 + 400.0 / 4000.0)
    assert distance == pytest.approx(V * time / 2.0)
    assert commands.stop(rig.axis) == 0
    samples = rig.trace(ceil(time / DT))
    assert samples[-1] == (pytest.approx(begin + distance), 0.0, 0.0)
    assert samples[-3][1] > 0.0
    assert min(a for _, _, a in samples) == pytest.approx(-400.0)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    assert not rig.has(StateBit.HAS_JOB)


def test_an_endless_move_keeps_its_velocity(rig: Any) -> None:
    commands.start(rig.axis, StartType.ENDLESS_NEGATIVE, 0.0, V)
    rig.seconds(1.0)
    p = rig.axis.set_position
    rig.seconds(10.0)
    assert rig.axis.set_position == pytest.approx(p - 10.0 * V)
    assert rig.axis.set_velocity == -V
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert rig.has(StateBit.CONSTANT_VELOCITY)
    assert rig.has(StateBit.NEGATIVE_DIRECTION)


@pytest.mark.parametrize(
    ("start", "kind", "position", "end"),
    [
        (90.0, StartType.MODULO_SHORTEST, 350.0, -10.0),
        (90.0, StartType.MODULO_SHORTEST, 10.0, 10.0),
        (710.0, StartType.MODULO_SHORTEST, 10.0, 730.0),
        (90.0, StartType.MODULO_POSITIVE, 10.0, 370.0),
        (90.0, StartType.MODULO_POSITIVE, 90.0, 90.0),
        (90.0, StartType.MODULO_NEGATIVE, 100.0, -260.0),
        (-710.0, StartType.MODULO_NEGATIVE, 0.0, -720.0),
        (90.0, StartType.MODULO, 10.0, 370.0),
        (90.0, StartType.MODULO, 370.0, 730.0),
        (90.0, StartType.MODULO, -100.0, -260.0),
    ],
)
def test_modulo_targets(
    make_rig: Any, start: float, kind: StartType, position: float, end: float
) -> None:
    rig = make_rig(unit_interpretation=4)
    commands.set_actual_position(rig.axis, 1, start)
    rig.run(1)
    assert rig.axis.set_position_modulo == pytest.approx(start % 360.0)
    assert commands.start(rig.axis, kind, position, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(end)
    assert rig.axis.set_modulo_turns * 360.0 + rig.axis.set_position_modulo == pytest.approx(end)


def test_the_tolerance_window_saves_a_turn(make_rig: Any) -> None:
    rig = make_rig(encoder_modulo_tolerance_window=1.0)
    commands.set_actual_position(rig.axis, 1, 100.5)
    commands.start(rig.axis, StartType.MODULO_POSITIVE, 100.0, V)
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(100.0)


def test_a_new_target_ahead_is_reached_without_stopping(rig: Any) -> None:
    commands.start(rig.axis, StartType.ABSOLUTE, 200.0, V)
    rig.seconds(0.8)
    assert commands.new_end_position(rig.axis, 1, 400.0) == 0
    samples = rig.trace(2500)
    assert samples[-1] == (400.0, 0.0, 0.0)
    slowest = min(v for p, v, _ in samples if 200.0 < p < 300.0)
    assert slowest == pytest.approx(V, rel=1e-9)
    assert rig.has(StateBit.NEW_TARGET_POSITION)
    assert_smooth(samples, V, A, J)


def test_a_new_target_behind_is_reached_through_rest(rig: Any) -> None:
    commands.start(rig.axis, StartType.ABSOLUTE, 200.0, V)
    rig.seconds(0.8)
    assert commands.new_end_position(rig.axis, 1, 20.0) == 0
    samples = rig.trace(2500)
    assert samples[-1] == (20.0, 0.0, 0.0)
    assert max(p for p, _, _ in samples) < 200.0
    assert_smooth(samples, V, A, J)
    turn = next(i for i, (_, v, _) in enumerate(samples) if v < 0.0)
    assert abs(samples[turn][2]) <= J * DT  # the acceleration passes zero with the velocity


def test_velocity_changes_at_the_switch_position(rig: Any) -> None:
    commands.start(rig.axis, StartType.ABSOLUTE, 600.0, V)
    rig.seconds(0.7)
    assert commands.new_end_position_and_velocity(rig.axis, 11, 1, 700.0, 50.0, 300.0) == 0
    samples = rig.trace(6000)
    assert samples[-1] == (700.0, 0.0, 0.0)
    assert min(v for p, v, _ in samples if 200.0 < p < 300.0) == pytest.approx(V)
    assert max(v for p, v, _ in samples if 400.0 < p < 700.0) == pytest.approx(50.0)
    assert_smooth(samples, V, A, J)


def test_a_buffered_command_starts_after_arrival(rig: Any) -> None:
    first, second = 100.0, 40.0
    commands.universal_start(rig.axis, StartType.ABSOLUTE, first, V)
    number = rig.axis.command_counter
    assert commands.universal_start(rig.axis, 1, second, V, buffer_mode=BufferMode.BUFFERED) == 0
    assert rig.axis.command_counter == number + 1
    rig.run(1)
    assert rig.has(StateBit.COMMAND_BUFFERED)
    assert rig.axis.set_command_number == number
    rig.until_rest()
    assert rig.axis.set_position == first
    assert rig.has(StateBit.HAS_JOB)
    rig.until(lambda axis: axis.set_command_number == number + 1, 1.0)
    rig.until_rest()
    assert rig.axis.set_position == second
    assert not rig.has(StateBit.COMMAND_BUFFERED)
    assert not rig.has(StateBit.HAS_JOB)


@pytest.mark.parametrize(
    ("mode", "first", "second", "border"),
    [
        (BufferMode.BLENDING_LOW, 200.0, 80.0, 80.0),
        (BufferMode.BLENDING_LOW, 80.0, 200.0, 80.0),
        (BufferMode.BLENDING_PREVIOUS, 200.0, 80.0, 200.0),
        (BufferMode.BLENDING_PREVIOUS, 80.0, 200.0, 80.0),
        (BufferMode.BLENDING_NEXT, 200.0, 80.0, 80.0),
        (BufferMode.BLENDING_NEXT, 80.0, 200.0, 200.0),
        (BufferMode.BLENDING_HIGH, 200.0, 80.0, 200.0),
        (BufferMode.BLENDING_HIGH, 80.0, 200.0, 200.0),
    ],
)
def test_blending_passes_the_border_at_its_velocity(
    rig: Any, mode: BufferMode, first: float, second: float, border: float
) -> None:
    commands.universal_start(rig.axis, 1, 300.0, first)
    rig.run(1)
    assert commands.universal_start(rig.axis, 1, 600.0, second, buffer_mode=mode) == 0
    samples = rig.trace(10_000)
    assert samples[-1] == (600.0, 0.0, 0.0)
    assert_smooth(samples, V, A, J)
    assert crossing_velocity(samples, 300.0) == pytest.approx(border, rel=1e-4)


def test_a_border_too_near_to_brake_from_is_passed_slowly(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 300.0, V)
    commands.universal_start(rig.axis, 1, 300.5, V, buffer_mode=BufferMode.BLENDING_PREVIOUS)
    samples = rig.trace(2000)
    assert samples[-1] == (300.5, 0.0, 0.0)
    assert max(p for p, _, _ in samples) == 300.5
    assert min(v for _, v, _ in samples) >= 0.0


SEGMENT, SEGMENTS = 40.0, 50


@pytest.mark.parametrize(
    ("mode", "border"),
    [
        (BufferMode.BLENDING_LOW, min),
        (BufferMode.BLENDING_PREVIOUS, lambda before, after: before),
        (BufferMode.BLENDING_NEXT, lambda before, after: after),
        (BufferMode.BLENDING_HIGH, max),
    ],
)
def test_a_path_of_fifty_segments_passes_each_target_at_its_velocity(
    rig: Any, mode: BufferMode, border: Callable[[float, float], float]
) -> None:
    """Commands fed as the buffer drains: each mode, velocities up and down, all limits kept."""
    axis = rig.axis
    a, j = 1200.0, 30_000.0
    velocities = [(60.0, 100.0, 80.0, 140.0, 120.0)[n % 5] for n in range(SEGMENTS)]
    assert commands.universal_start(axis, 2, SEGMENT, velocities[0], a, a, j) == 0
    fed = 1
    samples = [(0.0, 0.0, 0.0)]
    while axis.set_motion_phase:
        while fed < SEGMENTS and axis.buffer_count < 3:
            code = commands.universal_start(axis, 2, SEGMENT, velocities[fed], a, a, j, mode)
            assert code == 0, hex(code)
            fed += 1
        samples += rig.trace(1)[1:]
    assert samples[-1] == (pytest.approx(SEGMENT * SEGMENTS), 0.0, 0.0)
    assert_smooth(samples, max(velocities), a, j)
    for n in range(1, SEGMENTS):
        expected = border(velocities[n - 1], velocities[n])
        assert crossing_velocity(samples, n * SEGMENT) == pytest.approx(expected, rel=1e-4), n
    inside = [v for p, v, _ in samples if SEGMENT < p < (SEGMENTS - 1) * SEGMENT]
    assert min(inside) >= min(velocities) * (1.0 - 1e-9)


def test_short_segments_are_passed_as_fast_as_their_end_allows(rig: Any) -> None:
    """Segments too short to brake in: the eight that wait are what the axis brakes for."""
    axis = rig.axis
    a, j, way, count = 1000.0, 20_000.0, 0.5, 200
    commands.universal_start(axis, 2, way, V, a, a, j)
    fed, samples = 1, [(0.0, 0.0, 0.0)]
    while axis.set_motion_phase:
        while fed < count:
            code = commands.universal_start(axis, 2, way, V, a, a, j, BufferMode.BLENDING_LOW)
            if code:
                assert NcError.of(code) is NcError.COMMAND_BUFFER_FULL
                break
            fed += 1
        samples += rig.trace(1)[1:]
    assert samples[-1] == (pytest.approx(way * count), 0.0, 0.0)
    assert_smooth(samples, V, a, j)
    assert all(v > 0.0 for _, v, _ in samples[1:-1])
    # Each border is passed without acceleration: in the last eight segments the velocity falls by
    # a ramp each, and before them it is what these allow.
    allowed = [0.0]
    for _ in range(8):
        allowed.append(highest_velocity(way, allowed[-1], a, j))
    for n in range(30, count):
        expected = allowed[min(8, count - n)]
        assert crossing_velocity(samples, n * way) == pytest.approx(expected, rel=1e-3), n


def test_a_late_blend_passes_its_border_as_fast_as_it_still_can(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    rig.until(lambda axis: axis.set_acceleration < -150.0)
    mode = BufferMode.BLENDING_HIGH
    assert commands.universal_start(rig.axis, 1, 300.0, V, buffer_mode=mode) == 0
    samples = rig.trace(2500)
    assert samples[-1] == (300.0, 0.0, 0.0)
    assert_smooth(samples, V, A, J)
    slowest = min(v for p, v, _ in samples if p < 100.0)
    assert slowest < crossing_velocity(samples, 100.0) < V


def test_a_segment_end_velocity_leads_on_beyond_the_target(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 200.0, 150.0, segment_end_velocity=50.0)
    samples = rig.trace(1500)
    assert crossing_velocity(samples, 200.0) == pytest.approx(50.0, rel=1e-4)
    assert samples[-1][1] == 50.0
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert commands.universal_start(rig.axis, 1, 600.0, V, buffer_mode=BufferMode.BUFFERED) == 0
    samples += rig.trace(2500)[1:]
    assert samples[-1] == (600.0, 0.0, 0.0)
    assert_smooth(samples, V, A, J)
    assert min(v for p, v, _ in samples if 200.0 < p < 550.0) >= 50.0 * (1.0 - 1e-9)


@pytest.mark.parametrize("border", [200.0, 0.0])
def test_the_next_command_begins_at_the_blending_position(rig: Any, border: float) -> None:
    axis = rig.axis
    commands.set_actual_position(axis, 1, border - 200.0)
    commands.universal_start(axis, 1, border + 100.0, 100.0)
    number = axis.command_counter
    code = commands.universal_start(
        axis, 2, 100.0, V, buffer_mode=BufferMode.BLENDING_NEXT, blending_position=border
    )
    assert code == 0
    samples = rig.trace(0)
    while axis.set_command_number == number:
        samples += rig.trace(1)[1:]
    assert 0.0 <= axis.set_position - border <= V * DT
    samples += rig.trace(2000)[1:]
    assert samples[-1] == (border + 200.0, 0.0, 0.0)  # counted from the target
    assert crossing_velocity(samples, border) == pytest.approx(V, rel=1e-4)
    assert_smooth(samples, V, A, J)


def test_a_blending_position_that_comes_to_lie_at_0_is_still_one(rig: Any) -> None:
    axis = rig.axis
    commands.universal_start(axis, 1, 300.0, 100.0)
    number = axis.command_counter
    mode = BufferMode.BLENDING_NEXT
    commands.universal_start(axis, 1, 400.0, V, buffer_mode=mode, blending_position=200.0)
    rig.seconds(0.5)
    assert commands.set_actual_position_on_the_fly(axis, 2, 0, -200.0) == 0
    rig.until(lambda ax: ax.set_command_number != number)
    assert 0.0 <= axis.set_position <= V * DT


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5])
def test_a_lower_override_brakes_across_borders(rig: Any, share: float) -> None:
    axis = rig.axis
    a, j = 1000.0, 20_000.0
    commands.universal_start(axis, 2, 20.0, V, a, a, j)
    for _ in range(8):
        commands.universal_start(axis, 2, 5.0, V, a, a, j, BufferMode.BLENDING_LOW)
    samples = rig.trace(0)
    while axis.set_position < 22.0:
        samples += rig.trace(1)[1:]
    axis.velocity_override = round(share * 1e6)
    samples += rig.trace(400)[1:]
    slow = [v for _, v, _ in samples[-200:]]
    assert max(slow) <= share * V * (1.0 + 1e-9) + 1e-9
    axis.velocity_override = 1_000_000
    while axis.set_motion_phase:
        samples += rig.trace(1)[1:]
    assert_smooth(samples, V, a, j)
    assert samples[-1] == (pytest.approx(60.0), 0.0, 0.0)
    assert max(p for p, _, _ in samples) <= 60.0 + 1e-9


@pytest.mark.parametrize("override_type", list(OverrideType))
@pytest.mark.parametrize("moment", [0.004, 0.2, 0.45, 0.9, 1.6, 2.05, 2.3, 2.55])
def test_override_zero_in_any_phase_of_a_move(
    make_rig: Any, override_type: int, moment: float
) -> None:
    """It takes 2.6 s; only the last ramp is not interrupted."""
    rig = make_rig(override_type=override_type)
    axis = rig.axis
    assert commands.start(axis, 1, 400.0, V) == 0
    rig.seconds(moment)
    braking = moment >= 400.0 / V
    axis.velocity_override = 0
    trace = rig.trace(1000)
    assert axis.set_velocity == 0.0
    assert (axis.set_position == 400.0) == braking
    if not braking:
        assert axis.motion_state == MotionState.OVERRIDE_ZERO
        assert rig.has(StateBit.HAS_JOB)
        assert not rig.has(StateBit.NOT_MOVING)
    axis.velocity_override = 1_000_000
    trace += rig.trace(2000)
    assert_smooth(trace, V, A, J)
    assert (axis.set_position, axis.set_motion_phase) == (400.0, 0)


DROPPED: dict[str, float] = {
    "compensating": 0,
    "superposed.set_velocity": 0.0,
    "superposed.set_acceleration": 0.0,
    "set_command_state": CommandState.ABORTED,
    "set_motion_phase": MotionPhase.NONE,
    "buffer_count": 0,
    "switch.armed": 0,
    "loop.outward": 0,
    "profile.replan": 0,
    "border.time": -1.0,
    "job.timing": 0,
    "profile.count": 0,
    "profile.index": 0,
    "set_velocity": 0.0,
    "set_acceleration": 0.0,
    "set_jerk": 0.0,
    "external.velocity": 0.0,
    "external.acceleration": 0.0,
    "limits.reached": 0,
    "set_torque": 0.0,
    "set_torque_derivative": 0.0,
    "remaining_time": 0.0,
    "remaining_distance": 0.0,
    "homing_state": 0,
    "homing.latch": 0,
}
"""What an axis has of a job that was dropped."""


def busy(axis: Any, phase: MotionPhase) -> None:
    """Let an axis have something of each that a drop takes away."""
    for name in DROPPED:
        owner, _, field = name.rpartition(".")
        setattr(getattr(axis, owner) if owner else axis, field, 3)
    axis.set_motion_phase, axis.set_command_state = phase, CommandState.ACTIVE
    axis.set_position, axis.target_position = 5.0, 9.0
    axis.error_code = axis.output_cut = axis.delayed_error_code = 0
    axis.job.deceleration, axis.job.jerk = 100.0, 1000.0


def test_dropped_job_leaves_nothing_behind(rig: Any) -> None:
    axis = rig.axis
    busy(axis, MotionPhase.HOMING)
    drop_job(axis)
    for name, value in DROPPED.items():
        assert attrgetter(name)(axis) == value, name
    assert axis.target_position == 5.0
    axis.set_command_state = CommandState.DONE
    drop_job(axis)
    assert axis.set_command_state == CommandState.DONE


@pytest.mark.parametrize("phase", [MotionPhase.NONE, MotionPhase.ENDLESS])
@pytest.mark.parametrize("cut", [0, 1])
def test_error_opens_the_loop_or_brakes(rig: Any, phase: MotionPhase, cut: int) -> None:
    axis = rig.axis
    busy(axis, phase)
    axis.delayed_error_code, axis.features = 0x4550, 0
    fail(axis, 0x4550, cut)
    assert (axis.error_code, axis.output_cut, axis.delayed_error_code) == (0x4550, cut, 0)
    assert (axis.features & Feature.ERROR, axis.buffer_count) == (Feature.ERROR, 0)
    brakes = phase != MotionPhase.NONE and not cut
    assert axis.set_motion_phase == (MotionPhase.STOPPING if brakes else MotionPhase.NONE)
    if phase == MotionPhase.NONE and not cut:
        assert axis.set_velocity == 3.0
    fail(axis, 0x4551, cut)
    assert axis.error_code == 0x4550


@pytest.mark.parametrize(
    ("phase", "deceleration", "jerk", "begins"),
    [
        (MotionPhase.STOPPING, 1.0, 1.0, False),
        (MotionPhase.STOPPING, 1.0 - 1e-9, 1.0, True),
        (MotionPhase.STOPPING, 1.0, 1.0 - 1e-9, True),
        (MotionPhase.ENDLESS, 1.0, 1.0, True),
    ],
)
def test_fast_stop_replaces_only_a_weaker_one(
    rig: Any, phase: MotionPhase, deceleration: float, jerk: float, begins: bool
) -> None:
    """Shares of the strongest deceleration and jerk of the axis."""
    axis = rig.axis
    busy(axis, phase)
    axis.fast_axis_stop_deceleration, axis.fast_axis_stop_jerk = 8e4, 8e5
    strongest = fault_deceleration(axis), fault_jerk(axis)
    assert strongest == (8e4, 8e5)
    axis.job.deceleration, axis.job.jerk = deceleration * strongest[0], jerk * strongest[1]
    axis.profile.replan = 0
    stop_fast(axis)
    assert (axis.job.deceleration, axis.job.jerk) == strongest
    assert axis.set_motion_phase == MotionPhase.STOPPING
    assert axis.profile.replan == begins


@pytest.mark.parametrize(
    ("target", "position", "inside", "near", "expected"),
    [(0, 0, 0, 0, 1), (1, 0, 0, 1, 0), (1, 1, 1, 0, 1), (0, 1, 1, 0, 0), (0, 1, 0, 1, 1)],
)
def test_arrival_is_that_of_the_narrowest_window_that_is_on(
    rig: Any, target: int, position: int, inside: int, near: int, expected: int
) -> None:
    axis = rig.axis
    axis.target_position_monitoring_enable = target
    axis.position_range_monitoring_enable = position
    axis.in_target_position, axis.in_position_range = inside, near
    assert bool(arrived(axis)) == bool(expected)
