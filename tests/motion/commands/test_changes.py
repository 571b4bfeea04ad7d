"""Changes of the running move: what they need and what they do."""

from math import sqrt
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit, commands

V = 200.0


def test_changes_need_a_running_move(rig: Any) -> None:
    rig.refuses(NcError.GROUP_BUSY, commands.new_end_position, 1, 50.0)
    rig.refuses(NcError.NO_MOTION, commands.new_dynamics, 1.0, 1.0, 1.0)


def test_switch_positions_lie_on_the_way(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.seconds(0.5)
    change = commands.new_end_position_and_velocity
    beside = NcError.ACTIVATION_POSITION_NOT_ON_WAY
    rig.refuses(beside, change, 10, 0, 0.0, 10.0, -5.0)
    rig.refuses(beside, change, 10, 0, 0.0, 10.0, 105.0)
    rig.refuses(NcError.JOB_START_TYPE, change, 9, 3, 0.0, 0.0, 90.0)
    rig.refuses(NcError.JOB_TYPE, change, 4, 1, 0.0, 0.0, 90.0)
    rig.refuses(NcError.JOB_START_TYPE, change, 1, 9, 0.0, 0.0, 90.0)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, change, 2, 0, 0.0, 0.0, 0.0)


def test_a_move_becomes_endless_and_positioned_again(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.run(100)
    assert commands.new_end_position(rig.axis, 3, 0.0) == 0
    rig.seconds(2.0)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert commands.new_end_position(rig.axis, 1, 1000.0) == 0
    rig.until_rest()
    assert rig.axis.set_position == 1000.0


def test_new_dynamics_act_on_the_running_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    assert commands.new_dynamics(rig.axis, 500.0, 100.0, 1000.0) == 0
    commands.stop(rig.axis)
    distance, time = commands.stop_information(rig.axis, 0.0, 0.0)
    assert time == pytest.approx(V / 100.0 + 100.0 / 1000.0)
    assert distance == pytest.approx(V * time / 2.0)


def test_new_dynamics_without_jerk_keep_that_of_the_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V, 1000.0, 1000.0, 4000.0)
    rig.seconds(1.0)
    assert commands.new_dynamics(rig.axis, 500.0, 100.0) == 0
    _, time = commands.stop_information(rig.axis, 0.0, 0.0)
    assert time == pytest.approx(V / 100.0 + 100.0 / 4000.0)


def test_a_frozen_override_is_that_of_now(rig: Any) -> None:
    commands.start(rig.axis, 1, 400.0, V)
    rig.seconds(1.0)
    rig.axis.velocity_override = 400_000
    assert commands.freeze_override(rig.axis) == 0
    rig.until(lambda axis: axis.set_velocity == pytest.approx(0.4 * V))
    rig.seconds(0.5)
    assert rig.axis.set_velocity == pytest.approx(0.4 * V)
    rig.axis.velocity_override = 1_000_000
    rig.until(lambda axis: axis.set_velocity == pytest.approx(V))
    rig.until_rest()
    assert rig.axis.set_position == 400.0


def test_a_frozen_override_does_not_disturb_braking(rig: Any) -> None:
    commands.start(rig.axis, 1, 400.0, V)
    rig.until(lambda axis: axis.set_acceleration < 0.0)
    rig.run(20)
    rig.axis.velocity_override = 100_000
    commands.freeze_override(rig.axis)
    rig.until_rest()
    assert rig.axis.set_position == pytest.approx(400.0, abs=1e-9)
    assert commands.freeze_override(rig.axis) == 0


A, J = 1000.0, 5000.0
FULL_RAMP = V / A + A / J


def ramp(change: float) -> float:
    return 2.0 * sqrt(change / J) if change * J <= A * A else change / A + A / J


@pytest.mark.parametrize(
    ("kind", "position", "target"),
    [(1, 700.0, 700.0), (2, 300.0, None), (5, 10.0, 370.0), (5, 800.0, 1160.0)],
)
def test_a_new_end_position_ahead_is_reached_in_one_go(
    rig: Any, kind: int, position: float, target: float | None
) -> None:
    commands.universal_start(rig.axis, 1, 320.0, V, A, A, J)
    rig.seconds(1.0)
    here = rig.axis.set_position
    assert here == pytest.approx(V * (1.0 - 0.5 * FULL_RAMP))
    goal = here + position if target is None else target
    assert commands.new_end_position(rig.axis, kind, position) == 0
    rig.run(1)
    assert rig.has(StateBit.NEW_TARGET_POSITION)
    assert rig.axis.target_position == goal
    time = (goal - here) / V + 0.5 * FULL_RAMP
    assert abs(rig.until_rest() + 1 - time / rig.dt) < 1.001
    assert rig.axis.set_position == goal


@pytest.mark.parametrize(
    ("kind", "goal", "after"), [(9, 900.0, V), (10, 600.0, 80.0), (11, 900.0, 80.0)]
)
def test_changes_at_the_switch_position(rig: Any, kind: int, goal: float, after: float) -> None:
    """From 300 mm on the velocity falls to 80 mm/s, the target becomes 900 mm, or both."""
    commands.universal_start(rig.axis, 1, 600.0, V, A, A, J)
    rig.seconds(1.0)
    here = rig.axis.set_position
    code = commands.new_end_position_and_velocity(rig.axis, kind, 1, 900.0, 80.0, 300.0)
    assert code == 0
    rig.run(5)
    assert rig.axis.target_position == 600.0
    assert not rig.has(StateBit.NEW_TARGET_POSITION)
    slowing = ramp(V - after) if after < V else 0.0
    cruise = goal - 300.0 - 0.5 * (V + after) * slowing - 0.5 * after * ramp(after)
    time = (300.0 - here) / V + slowing + cruise / after + ramp(after)
    # The change waits for the end of the cycle that passes the position.
    assert abs(rig.until_rest() + 5 - time / rig.dt) <= 1.0 + V / after
    assert rig.has(StateBit.NEW_TARGET_POSITION)
    assert rig.axis.set_position == goal


def test_new_dynamics_shape_the_rest_of_the_move(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 600.0, V, A, A, J)
    rig.seconds(1.0)
    here = rig.axis.set_position
    assert commands.new_dynamics(rig.axis, 2000.0, 250.0, 50_000.0) == 0
    braking = V / 250.0 + 250.0 / 50_000.0
    time = (600.0 - here) / V + 0.5 * braking
    strongest = 0.0
    cycles = 0
    while rig.axis.set_motion_phase:
        rig.run(1)
        cycles += 1
        strongest = min(strongest, rig.axis.set_acceleration)
    assert strongest == pytest.approx(-250.0)
    assert abs(cycles - time / rig.dt) < 1.001
    assert rig.axis.set_position == 600.0


@pytest.mark.parametrize("endless", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("after", "override"), [(60.0, 1.0), (350.0, 1.0), (60.0, 0.5)])
def test_a_velocity_is_reached_at_a_position(
    rig: Any, after: float, override: float, sign: float, endless: bool
) -> None:
    """Type 14: the change begins earlier by the way of its ramp (004 §5.2)."""
    rig.axis.velocity_override = round(override * 1_000_000)
    kind = (3 if sign > 0 else 4) if endless else 1
    commands.start(rig.axis, kind, sign * 2000.0, V, 1000.0, 800.0, 9000.0)
    rig.seconds(1.0)
    place = rig.axis.set_position + sign * 300.0
    change = commands.new_end_position_and_velocity
    assert change(rig.axis, 14, 1, 0.0, after, place) == 0
    seen = []
    while (rig.axis.set_position - place) * sign < 0.0:
        rig.run(1)
        seen.append(abs(rig.axis.set_velocity))
    goal = after * override
    # The change waits for the end of the cycle that passes the place where it begins.
    assert seen[-1] == pytest.approx(goal, rel=0.05)
    assert seen[len(seen) // 4] == pytest.approx(V * override)
    rig.run(5)
    assert abs(rig.axis.set_velocity) == pytest.approx(goal)


def test_a_velocity_without_room_for_its_ramp_changes_at_once(rig: Any) -> None:
    commands.start(rig.axis, 1, 2000.0, V, 100.0, 100.0, 900.0)
    rig.seconds(4.0)
    place = rig.axis.set_position + 1.0
    change = commands.new_end_position_and_velocity
    assert change(rig.axis, 14, 1, 0.0, 60.0, place) == 0
    rig.run(2)
    assert rig.axis.set_acceleration < 0.0
    rig.refuses(NcError.ACTIVATION_POSITION_NOT_ON_WAY, change, 14, 1, 0.0, 60.0, place - 500.0)
