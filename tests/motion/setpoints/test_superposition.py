"""Section compensation: traces against the trapezoid's equations, beside every kind of motion."""

import random
from itertools import pairwise
from math import isfinite, sqrt
from typing import Any

import pytest

from achse.motion import AxisParameters, MotionPhase, Nc, StateBit, commands
from achse.motion.commands import Compensation

V = 100.0
"""Main velocity and process velocity."""

A, D = 400.0, 200.0
"""Additional acceleration and deceleration."""

C = 1.0 / A + 1.0 / D


def cruising(make_rig: Any, **values: float) -> Any:
    """A rig whose axis travels endlessly at V."""
    rig = make_rig(**values)
    assert commands.universal_start(rig.axis, 3, 0.0, V) == 0
    rig.until(lambda axis: axis.set_velocity == V)
    return rig


def start(rig: Any, kind: int, increase: float, distance: float, length: float) -> Compensation:
    code, done = commands.start_superposition(
        rig.axis, Compensation(kind, A, D, increase, V, distance, length)
    )
    assert code == 0
    assert rig.axis.compensating == 1
    return done


def watch(rig: Any) -> tuple[int, list[float]]:
    """Cycles until the compensation has ended, and the set velocities until then."""
    velocities = []
    cycles = 0
    while rig.axis.compensating:
        rig.run(1)
        cycles += 1
        if rig.axis.compensating:
            assert rig.has(StateBit.COMPENSATING)
            assert rig.has(StateBit.HAS_JOB)
        velocities.append(rig.axis.set_velocity)
    assert not rig.has(StateBit.COMPENSATING)
    return cycles, velocities


def top_over(time: float, distance: float) -> float:
    """Top of the trapezoid that covers `distance` in `time`: v T - v² C / 2 = s."""
    return (time - sqrt(time * time - 2.0 * C * distance)) / C


@pytest.mark.parametrize("distance", [20.0, -20.0])
@pytest.mark.parametrize(("kind", "own"), [(1, 0.0), (2, 1.0)])
def test_velocity_reduction_uses_the_whole_way(
    make_rig: Any, kind: int, own: float, distance: float
) -> None:
    rig = cruising(make_rig)
    begin = rig.axis.set_position
    length = 200.0
    time = (length - own * distance) / V
    done = start(rig, kind, 80.0, distance, length)
    top = top_over(time, abs(distance))
    assert done.warning == 0
    assert done.velocity_increase == pytest.approx(top)
    assert (done.distance, done.length) == (distance, pytest.approx(length))
    cycles, velocities = watch(rig)
    assert cycles * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.set_position - begin == pytest.approx(V * cycles * rig.dt + distance)
    peak = max(velocities) if distance > 0.0 else min(velocities)
    assert peak == pytest.approx(V + top if distance > 0.0 else V - top)
    assert rig.axis.set_velocity == V


@pytest.mark.parametrize(("kind", "own"), [(3, 0.0), (4, 1.0)])
@pytest.mark.parametrize(("increase", "distance"), [(30.0, 20.0), (80.0, 5.0), (30.0, -20.0)])
def test_length_reduction_uses_the_velocity(
    make_rig: Any, kind: int, own: float, increase: float, distance: float
) -> None:
    """Trapezoid with the full increase, or the triangle where it is not reached."""
    rig = cruising(make_rig)
    begin = rig.axis.set_position
    top = min(increase, sqrt(2.0 * abs(distance) / C))
    time = abs(distance) / top + 0.5 * top * C
    done = start(rig, kind, increase, distance, 400.0)
    assert done.warning == 0
    assert done.velocity_increase == pytest.approx(top)
    assert done.length == pytest.approx(V * time + own * distance)
    cycles, _ = watch(rig)
    assert cycles * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.set_position - begin == pytest.approx(V * cycles * rig.dt + distance)


@pytest.mark.parametrize(("kind", "own"), [(5, 0.0), (6, 1.0)])
@pytest.mark.parametrize(
    ("increase", "distance"), [(80.0, 20.0), (80.0, -20.0), (15.0, 20.0), (15.0, -20.0)]
)
def test_acceleration_reduction_uses_the_whole_way(
    make_rig: Any, kind: int, own: float, increase: float, distance: float
) -> None:
    """A triangle over the whole way, or the flattest ramps to the full increase."""
    rig = cruising(make_rig)
    begin = rig.axis.set_position
    length = 200.0
    time = (length - own * distance) / V
    done = start(rig, kind, increase, distance, length)
    top = min(increase, 2.0 * abs(distance) / time)
    ramps = 2.0 * (time - abs(distance) / top)  # v T - v (ramps) / 2 = s
    assert done.warning == 0
    assert done.velocity_increase == pytest.approx(top)
    assert (done.distance, done.length) == (distance, pytest.approx(length))
    acceleration, deceleration = done.acceleration_increase, done.deceleration_increase
    assert top / acceleration + top / deceleration == pytest.approx(ramps)
    assert acceleration / deceleration == pytest.approx(A / D)
    cycles, velocities = watch(rig)
    assert cycles * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.set_position - begin == pytest.approx(V * cycles * rig.dt + distance)
    peak = max(velocities) - V if distance > 0.0 else V - min(velocities)
    assert top - acceleration * rig.dt <= peak <= top * (1.0 + 1e-9)
    steepest = max(abs(w - v) for v, w in pairwise(velocities[:-1]))
    assert steepest <= max(acceleration, deceleration) * rig.dt * (1.0 + 1e-6)


def test_the_trapezoid_has_its_ramps(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    trace = rig.trace(700)
    assert max(a for _, _, a in trace) == pytest.approx(A)
    assert min(a for _, _, a in trace) == pytest.approx(-D)
    for (p, v, _), (q, w, _) in pairwise(trace):
        assert abs(q - p - 0.5 * (v + w) * rig.dt) <= 0.5 * A * rig.dt**2
        assert -D * rig.dt - 1e-9 <= w - v <= A * rig.dt + 1e-9


@pytest.mark.parametrize("kind", [1, 2, 3, 4, 5, 6])
def test_a_way_too_short_is_covered_in_part(make_rig: Any, kind: int) -> None:
    rig = cruising(make_rig)
    begin = rig.axis.set_position
    time = 0.5
    distance = 30.0
    length = V * time + (distance if kind in (2, 4, 6) else 0.0)
    done = start(rig, kind, 40.0, distance, length)
    part = 40.0 * time - 0.5 * C * 40.0**2
    assert done.warning == 0x4243
    assert done.velocity_increase == 40.0
    assert done.distance == pytest.approx(part)
    cycles, _ = watch(rig)
    assert cycles * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.set_position - begin == pytest.approx(V * cycles * rig.dt + part)


def test_a_triangle_is_the_most_that_fits(make_rig: Any) -> None:
    rig = cruising(make_rig)
    done = start(rig, 1, 500.0, 90.0, 20.0)
    top = 0.2 / C
    assert done.warning == 0x4243
    assert done.velocity_increase == pytest.approx(top)
    assert done.distance == pytest.approx(0.5 * top * 0.2)


def test_the_target_moves_along(rig: Any) -> None:
    assert commands.start(rig.axis, 1, 500.0, V) == 0
    rig.seconds(1.0)
    start(rig, 3, 50.0, 7.0, 300.0)
    moved = rig.until_rest()
    assert rig.axis.set_position == pytest.approx(507.0, abs=1e-9)
    assert rig.axis.target_position == pytest.approx(507.0, abs=1e-9)
    rig.seconds(1.0)
    assert rig.has(StateBit.IN_TARGET_POSITION)
    # the main motion took its own time: s / v + v / a + a / j
    a, j = rig.axis.default_acceleration, rig.axis.default_jerk
    time = 500.0 / V + (2.0 * sqrt(V / j) if V * j < a * a else V / a + a / j)
    assert (moved + 500) * rig.dt == pytest.approx(time, abs=2 * rig.dt)


def test_backwards_a_gain_leads_further_back(make_rig: Any) -> None:
    rig = make_rig()
    assert commands.start(rig.axis, 1, -500.0, V) == 0
    rig.seconds(1.0)
    start(rig, 1, 50.0, 7.0, 300.0)
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(-507.0, abs=1e-9)


def test_the_override_slows_the_compensation_too(make_rig: Any) -> None:
    rig = cruising(make_rig)
    rig.axis.velocity_override = 500_000
    rig.until(lambda axis: axis.set_velocity == 0.5 * V)
    begin = rig.axis.set_position
    start(rig, 3, 30.0, 20.0, 400.0)
    cycles, velocities = watch(rig)
    time = 20.0 / 30.0 + 0.5 * 30.0 * C
    assert cycles * rig.dt == pytest.approx(2.0 * time, abs=1.01 * rig.dt)
    assert max(velocities) == pytest.approx(0.5 * (V + 30.0))
    assert rig.axis.set_position - begin == pytest.approx(0.5 * V * cycles * rig.dt + 20.0)


def test_at_override_zero_it_waits(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    rig.seconds(0.3)
    rig.axis.velocity_override = 0
    rig.until(lambda axis: axis.set_velocity == 0.0)
    stands = rig.axis.set_position
    rig.seconds(1.0)
    assert rig.has(StateBit.COMPENSATING)
    assert (rig.axis.set_position, rig.axis.set_velocity) == (stands, 0.0)
    rig.axis.velocity_override = 1_000_000
    watch(rig)
    assert rig.axis.superposed.position == pytest.approx(20.0)


def test_it_ends_where_the_main_motion_does(rig: Any) -> None:
    assert commands.start(rig.axis, 1, 200.0, V) == 0
    rig.seconds(0.5)
    before = rig.axis.set_position
    start(rig, 1, 50.0, 40.0, 1000.0)
    rig.until_rest()
    assert not rig.has(StateBit.COMPENSATING)
    # a share of the trapezoid: its ramp A t² / 2 up to `top`, then straight on
    top, time = top_over(10.0, 40.0), (200.0 - before) / V
    assert rig.axis.set_position == pytest.approx(200.0 + top * (time - 0.5 * top / A))


def test_it_does_not_survive_a_reversal(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 1, 50.0, 40.0, 1000.0)
    rig.seconds(0.5)
    assert commands.new_end_position(rig.axis, 1, rig.axis.set_position - 100.0) == 0
    trace = rig.trace(1500)
    assert rig.axis.compensating == 0
    jumps = [abs(b[1] - a[1]) for a, b in pairwise(trace)]
    assert max(jumps) <= (rig.axis.default_deceleration * 1.1 + A) * rig.dt


@pytest.mark.parametrize("moment", [0.05, 0.4, 0.75])
def test_a_stop_of_the_compensation_brakes_with_its_own_deceleration(
    make_rig: Any, moment: float
) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    rig.seconds(moment)
    speed = rig.axis.set_velocity - V
    begin, covered = rig.axis.set_position, rig.axis.superposed.position
    assert commands.stop_superposition(rig.axis) == 0
    assert commands.stop_superposition(rig.axis) == 0x4258
    cycles, velocities = watch(rig)
    assert cycles * rig.dt == pytest.approx(speed / D, abs=1.01 * rig.dt)
    assert max(velocities) <= V + speed
    way = 0.5 * speed * speed / D
    assert rig.axis.set_position - begin == pytest.approx(V * cycles * rig.dt + way)
    assert rig.axis.superposed.position == pytest.approx(covered + way)
    assert rig.axis.set_velocity == V
    assert commands.stop_superposition(rig.axis) == 0x4246


def test_a_stop_of_the_axis_takes_the_whole_velocity_along(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    rig.seconds(0.4)
    assert rig.axis.set_velocity == pytest.approx(V + 30.0)
    way, time = commands.stop_information(rig.axis, 0.0, 0.0)
    begin = rig.axis.set_position
    assert commands.stop(rig.axis) == 0
    assert rig.until_rest() * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.set_position == pytest.approx(begin + way)
    assert not rig.has(StateBit.COMPENSATING)


def test_a_new_start_takes_over_both_motions(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    rig.seconds(0.4)
    velocity = rig.axis.set_velocity
    assert commands.universal_start(rig.axis, 1, 1000.0, V) == 0
    rig.run(1)
    assert rig.axis.compensating == 0
    assert rig.axis.set_velocity == pytest.approx(velocity, abs=1.0)
    rig.until_rest()
    assert rig.axis.set_position == 1000.0


def test_a_lost_enable_brakes_both(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    rig.seconds(0.4)
    rig.axis.control_dword = 0
    _, time = commands.stop_information(rig.axis, 0.0, 0.0)
    assert rig.until_rest() * rig.dt == pytest.approx(time, abs=1.01 * rig.dt)
    assert rig.axis.error_code == 0x4260
    assert not rig.has(StateBit.COMPENSATING)


def test_a_following_error_drops_it(make_rig: Any) -> None:
    rig = cruising(make_rig)
    start(rig, 3, 30.0, 20.0, 400.0)
    rig.axis.simulation_blocked = 1
    rig.until(lambda axis: axis.error_code == 0x4550)
    rig.run(1)
    assert (rig.axis.set_velocity, rig.axis.compensating) == (0.0, 0)


def test_soft_limits_hold_for_the_sum(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=505.0)
    assert commands.start(rig.axis, 1, 500.0, V) == 0
    rig.seconds(1.0)
    compensation = Compensation(3, A, D, 30.0, V, 7.0, 300.0)
    assert commands.start_superposition(rig.axis, compensation)[0] == 0x4461
    endless = cruising(make_rig, encoder_soft_limit_max_enable=1, encoder_soft_limit_max=100.0)
    start(endless, 3, 30.0, 60.0, 400.0)
    endless.until(lambda axis: axis.error_code == 0x4463)
    assert endless.axis.set_position <= 100.0 + (V + 30.0) * endless.dt
    endless.until_rest()


def test_buffered_moves_go_on_below_it(rig: Any) -> None:
    assert commands.universal_start(rig.axis, 2, 200.0, V) == 0
    assert commands.universal_start(rig.axis, 2, 200.0, V, buffer_mode=19) == 0
    rig.seconds(1.0)
    start(rig, 1, 30.0, 20.0, 250.0)
    rig.until(lambda axis: axis.set_motion_phase == 0 and axis.buffer_count == 0)
    assert rig.axis.set_position == pytest.approx(420.0, abs=1e-9)


def test_targets_that_wait_move_along(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 200.0, V)
    commands.universal_start(rig.axis, 1, 500.0, V, 0.0, 0.0, 0.0, 19)
    commands.universal_start(rig.axis, 2, -10.0, V, 0.0, 0.0, 0.0, 1)
    rig.seconds(1.0)
    start(rig, 1, 80.0, 20.0, 200.0)  # ends beyond the first target
    rig.until(lambda axis: axis.set_command_number == 2)
    assert rig.axis.compensating == 1
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(520.0)
    rig.until(lambda axis: axis.buffer_count == 0 and axis.set_motion_phase == 0)
    assert rig.axis.set_position == pytest.approx(510.0)


def test_both_targets_of_a_reversing_operation_move_along(rig: Any) -> None:
    axis = rig.axis
    assert commands.start_reversing(axis, 1, 400.0, 0.0, V, 0.2) == 0
    rig.until(lambda ax: ax.set.velocity == V)
    start(rig, 3, 30.0, 20.0, 200.0)
    rig.until(lambda ax: ax.set_motion_phase == MotionPhase.REVERSING)
    assert axis.compensating == 0
    assert axis.set_position == pytest.approx(420.0)
    refused, _ = commands.start_superposition(axis, Compensation(1, A, D, 30.0, V, 5.0, 100.0))
    assert refused == 0x4245  # it rests
    rig.until(lambda ax: ax.set.velocity == -V)
    start(rig, 3, 30.0, -5.0, 200.0)
    rig.until(lambda ax: ax.set_motion_phase == MotionPhase.REVERSING)
    assert axis.set_position == pytest.approx(25.0)
    rig.until(lambda ax: ax.set.velocity == V)
    rig.until(lambda ax: ax.set_motion_phase == MotionPhase.REVERSING)
    assert axis.set_position == pytest.approx(425.0)


def test_a_compensation_keeps_both_targets_of_a_reversing_operation_within_the_limits(
    make_rig: Any,
) -> None:
    rig = make_rig(encoder_soft_limit_min_enable=1, encoder_soft_limit_min=-10.0)
    assert commands.start_reversing(rig.axis, 1, 400.0, 0.0, V, 0.2) == 0
    rig.until(lambda ax: ax.set.velocity == V)
    compensation = Compensation(3, A, D, 30.0, V, -20.0, 200.0)
    assert commands.start_superposition(rig.axis, compensation)[0] == 0x4460
    start(rig, 3, 30.0, -5.0, 200.0)


def test_both_kernels_agree(make_rig: Any) -> None:
    digests = []
    for compiled in (False, True):
        rig = cruising(make_rig, compiled=compiled)
        start(rig, 1, 30.0, 20.0, 400.0)
        commands.start_phasing(rig.axis, 1, 0, 0, 30.0, 50.0)
        rig.seconds(0.5)
        rig.axis.velocity_override = 300_000
        rig.seconds(1.0)
        commands.stop_superposition(rig.axis)
        rig.seconds(1.0)
        digests.append(rig.nc.digest())
    assert digests[0] == digests[1]


def test_a_faster_main_motion_leaves_less_room(make_rig: Any) -> None:
    """The velocity never exceeds the axis maximum; the distance is covered all the same."""
    rig = cruising(make_rig, max_velocity=200.0)
    begin = rig.axis.set_position
    assert commands.new_end_position_and_velocity(rig.axis, 2, 0, 0.0, 50.0, 0.0) == 0
    rig.seconds(1.0)
    start(rig, 1, 50.0, 40.0, 400.0)
    assert commands.new_end_position_and_velocity(rig.axis, 2, 0, 0.0, 190.0, 0.0) == 0
    trace = rig.trace(3000)
    assert rig.axis.compensating == 0
    assert rig.axis.superposed.position == pytest.approx(40.0)
    assert max(v for _, v, _ in trace) == pytest.approx(200.0)
    for (p, v, _), (q, w, _) in pairwise(trace):
        assert max(v, w) <= 200.0 + 1e-9
        assert abs(q - p - 0.5 * (v + w) * rig.dt) <= 0.01
    assert begin < rig.axis.set_position


@pytest.mark.usefixtures("checked_kernels")
@pytest.mark.parametrize("seed", range(4))
def test_random_compensations(make_rig: Any, seed: int) -> None:
    """Beside overrides, new targets, stops: no step, no velocity above the maximum, an end."""
    dice = random.Random(seed)
    rig = make_rig(compiled=True, max_velocity=300.0)
    axis = rig.axis
    steepest = 2 * axis.default_deceleration + 4 * 2000.0
    for _ in range(120):
        act = dice.randrange(8)
        if act == 0:
            axis.velocity_override = dice.choice([0, 100_000, 600_000, 1_000_000])
        elif act == 1:
            commands.stop(axis)
        elif act == 2:
            commands.stop_superposition(axis)
        elif act == 3:
            commands.new_end_position(axis, 1, dice.uniform(-1000.0, 1000.0))
        elif act == 4:
            mode = dice.choice([0, 0, 1, 19])
            target, v = dice.uniform(-1000.0, 1000.0), dice.uniform(10.0, 300.0)
            commands.universal_start(axis, 1, target, v, buffer_mode=mode)
        else:
            compensation = Compensation(
                dice.randint(1, 6), 0.0, dice.choice([0.0, 2000.0]), dice.uniform(1.0, 200.0),
                dice.uniform(20.0, 300.0), dice.uniform(-100.0, 100.0), dice.uniform(1.0, 600.0),
            )  # fmt: skip
            commands.start_superposition(axis, compensation)
        trace = rig.trace(dice.randrange(400))
        for (p, v, _), (q, w, a) in pairwise(trace):
            assert isfinite(q)
            assert isfinite(a)
            assert abs(w) <= 300.0 * (1.0 + 1e-9)
            assert abs(w - v) <= steepest * rig.dt * 16.0
            assert abs(q - p) <= 300.0 * rig.dt * (1.0 + 1e-3)
    axis.velocity_override = 1_000_000
    rig.until(lambda ax: ax.set_motion_phase == 0 and ax.buffer.count == 0, 120.0)
    assert axis.compensating == 0
    assert (axis.set_velocity, axis.set_acceleration, axis.error_code) == (0.0, 0.0, 0)


@pytest.mark.parametrize("limit", ["max_velocity", "drive_reference_velocity"])
def test_a_limit_lowered_meanwhile_counts_from_the_next_command_on(
    make_rig: Any, limit: str
) -> None:
    rig = cruising(make_rig, controller_following_error_position_monitoring_enable=0)
    start(rig, 3, 50.0, 40.0, 400.0)
    rig.until(lambda axis: axis.set_velocity == pytest.approx(V + 50.0))
    setattr(rig.axis, limit, 1.1 * V)
    steps = [abs(v1 - v0) for (_, v0, _), (_, v1, _) in pairwise(rig.trace(1000))]
    assert max(steps) <= D * (1.0 + 50.0 / V) ** 2 * rig.dt


def test_a_main_motion_far_beyond_the_process_velocity_does_not_hurry_it(make_rig: Any) -> None:
    """At V its clock would go ten times as fast, and its accelerations be a hundred times A and D:
    it goes as fast as A and D come to those of the axis.
    """
    rig = cruising(make_rig, max_acceleration=4.0 * A, max_deceleration=9.0 * D)
    compensation = Compensation(1, A, D, 20.0, 0.1 * V, 5.0, 5.0)
    assert commands.start_superposition(rig.axis, compensation)[0] == 0
    _, velocities = watch(rig)
    steps = [after - before for before, after in pairwise([V, *velocities])]
    assert max(steps) == pytest.approx(4.0 * A * rig.nc.cycle_seconds)
    assert min(steps) == pytest.approx(-4.0 * D * rig.nc.cycle_seconds)


@pytest.mark.parametrize("moment", range(30))
@pytest.mark.parametrize("share", [-0.1, -0.5, -0.9])
def test_a_stop_in_the_last_ramp_with_a_slowing_compensation_keeps_the_jerk(
    make_rig: Any, moment: int, share: float
) -> None:
    """What stays of the deceleration of both is what the jerk of the axis takes away before rest.

    Only the cycle in which the compensation ends may bend: its acceleration has steps.
    """
    jerk = 2000.0
    rig = make_rig(default_jerk=jerk)
    assert commands.universal_start(rig.axis, 2, 60.0, V) == 0
    rig.until(lambda axis: axis.set_acceleration < 0.0)
    rig.until(lambda axis: axis.set_velocity < (0.05 + 0.02 * moment) * V)
    length = 0.9 * rig.axis.remaining_distance
    compensation = Compensation(1, 10.0 * A, 10.0 * A, V, V, share * length, length)
    assert commands.start_superposition(rig.axis, compensation)[0] == 0
    rig.run(3)
    rig.axis.control_dword = 1
    rig.run(1)
    trace = [rig.axis.set_acceleration]
    while rig.axis.set_velocity != 0.0:
        rig.run(1)
        trace.append(rig.axis.set_acceleration)
        assert rig.axis.set_velocity >= -1e-9
    assert max(abs(b - a) for a, b in pairwise(trace)) <= jerk * 0.002 * (1.0 + 1e-6)


@pytest.mark.parametrize("seed", range(10))
def test_compensation_of_a_slave_goes_on_within_the_room_that_is_left(seed: int) -> None:
    """World of motion 7100617: rounding took its whole way for a cycle, not its velocity."""
    dice = random.Random(seed)
    speed, more = dice.uniform(50.0, 500.0), dice.uniform(5.0, 100.0)
    presets = {
        "control_dword": 7, "velocity_override": 1_000_000, "max_velocity": speed + more,
        "controller_following_error_position_monitoring_enable": 0,
        "allow_slave_motion_commands": 1,
    }  # fmt: skip
    nc = Nc(2_000_000, [AxisParameters(n, values=presets) for n in (1, 2)], compiled=seed % 2 > 0)
    nc.cycle(3)
    master, slave = nc
    assert commands.couple(slave, 1, 1, 0, 0, 1.0) == 0
    assert commands.universal_start(master, 3, 0.0, 0.5 * speed) == 0
    nc.cycle(1500)
    compensation = Compensation(
        dice.randrange(1, 5),
        1e4,
        1e4,
        dice.uniform(0.6, 1.5) * more,
        0.5 * speed,
        more,
        2.0 * speed,
    )
    code, _ = commands.start_superposition(slave, compensation)
    assert code in (0, 0x4243)
    assert commands.new_end_position_and_velocity(master, 2, 1, 0.0, speed, 0.0) == 0
    p, v, ways = slave.set_position, slave.set_velocity, 0
    while slave.record.compensating:
        nc.cycle()
        assert abs(slave.set_velocity) <= (speed + more) * (1.0 + 1e-9)
        way = slave.set_position - p
        assert abs(way - 0.001 * (v + slave.set_velocity)) <= 1e-6 * speed + 0.002**2 * 2e4
        p, v, ways = slave.set_position, slave.set_velocity, ways + 1
    assert ways > 50
