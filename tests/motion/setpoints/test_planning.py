"""Planning from any state: changes at awkward moments neither jump nor turn the axis."""

import random
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from achse.motion import AxisParameters, BufferMode, Nc, StartType, commands

V = 200.0


@pytest.mark.parametrize("kind", [StartType.ABSOLUTE, StartType.ENDLESS_POSITIVE, StartType.HALT])
def test_a_command_with_less_jerk_does_not_turn_a_braking_axis(rig: Any, kind: int) -> None:
    """Released with the new jerk, 3000 mm/s² would take 90 mm/s, more than is left."""
    strong, weak = 100_000.0, 50_000.0
    commands.universal_start(rig.axis, 1, 300.0, V, 3000.0, 3000.0, strong)
    rig.until(lambda axis: axis.set_velocity < 50.0 and axis.set_position > 200.0)
    assert rig.axis.set_acceleration == pytest.approx(-3000.0)
    rig.until(lambda axis: axis.set_velocity < 20.0 or axis.set_acceleration > -3000.0)
    here = rig.axis.set_position
    v, a = rig.axis.set_velocity, rig.axis.set_acceleration
    assert a * a / (2.0 * weak) > v
    assert commands.universal_start(rig.axis, kind, 500.0, V, 3000.0, 3000.0, weak) == 0
    samples = rig.trace(2500)
    assert min(speed for _, speed, _ in samples) >= 0.0
    steps = pairwise(samples)
    assert all(abs(b - a) <= strong * rig.dt * (1.0 + 1e-6) for (_, _, a), (_, _, b) in steps)
    end = samples[-1][0]
    if kind == StartType.ABSOLUTE:
        assert end == 500.0
    elif kind == StartType.HALT:
        assert here <= end <= 300.0 + 1e-9
    else:
        assert samples[-1][1] == V


@pytest.mark.usefixtures("checked_kernels")
def test_no_override_turns_a_chain_of_blended_moves_or_leads_it_too_far(
    many: Callable[[int], int],
) -> None:
    """Ways, velocities and dynamics over decades; the override changes at any moment, also to 0."""
    for seed in range(many(20)):
        _blend(seed)


def _blend(seed: int) -> None:
    dice = random.Random(seed)
    presets = {
        "control_dword": 7,
        "velocity_override": 1_000_000,
        "override_type": dice.randrange(1, 5),
        "controller_following_error_position_monitoring_enable": 0,
    }
    nc = Nc(2_000_000, [AxisParameters(1, values=presets)], compiled=True)
    axis = nc.axis(1)
    nc.cycle()
    ways = [10.0 ** dice.uniform(-1.0, 2.0) for _ in range(dice.randrange(2, 10))]
    for n, way in enumerate(ways):
        velocity = 10.0 ** dice.uniform(0.0, 3.0)
        strength = [10.0 ** dice.uniform(1.5, 4.0) for _ in range(2)]
        mode = dice.randrange(18, 22) if n else 0
        jerk = 10.0 ** dice.uniform(3.0, 5.5)
        first, last = strength
        code = commands.universal_start(axis, 2, way, velocity, first, last, jerk, mode)
        assert code == 0, hex(code)
    often = dice.choice([0.001, 0.01, 0.05])
    cycles = 0
    before = 0.0
    while axis.set_motion_phase or axis.buffer_count:
        cycles += 1
        assert cycles < 200_000
        if cycles > 3000:
            axis.velocity_override = 1_000_000
        elif dice.random() < often:
            axis.velocity_override = dice.choice([0, 1000, 100_000, 500_000, 1_000_000])
        nc.cycle()
        assert axis.set_position >= before
        before = axis.set_position
    assert before == pytest.approx(sum(ways), rel=1e-12)


@pytest.mark.parametrize("away", [0.01, 1.0, 40.0])
def test_a_blended_move_back_passes_its_border_as_fast_as_from_the_turn(
    make_rig: Any, away: float
) -> None:
    """Two equal jerks in 2 √(v / j) at v / 2 on average: the way is v √(v / j)."""
    jerk = 10_000.0
    rig = make_rig(default_acceleration=1e5, default_deceleration=1e5, default_jerk=jerk)
    axis = rig.axis
    commands.universal_start(axis, StartType.ENDLESS_POSITIVE, 0.0, away)
    rig.until(lambda axis: axis.set_velocity == away)
    border = axis.set_position - 1.0
    commands.universal_start(axis, StartType.ABSOLUTE, border, V)
    commands.universal_start(
        axis, StartType.RELATIVE, -100.0, V, buffer_mode=BufferMode.BLENDING_NEXT
    )
    rig.until(lambda axis: axis.set_command_number == axis.command_counter, 2.0)
    way = 1.0 + away * (away / jerk) ** 0.5  # from the turn
    fastest = (jerk * way * way) ** (1.0 / 3.0)
    assert -axis.set_velocity == pytest.approx(fastest, rel=0.05)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_change_on_a_blended_border_does_not_turn_the_axis(rig: Any, sign: float) -> None:
    """Found by `achse swarm --plans`: too fast exactly there, it was led back."""
    axis, ramps = rig.axis, (V, 3000.0, 3000.0, 50_000.0)
    commands.universal_start(axis, StartType.ABSOLUTE, sign * 100.0, *ramps)
    blending = BufferMode.BLENDING_NEXT
    assert commands.universal_start(axis, 1, sign * 300.0, *ramps, blending) == 0
    rig.until(lambda axis: sign * axis.set_position > 100.0 - 2.0 * V * rig.dt)
    axis.set_position, axis.velocity_override = sign * 100.0, 900_000
    samples = rig.trace(1500)
    assert min(sign * speed for _, speed, _ in samples) >= 0.0
    assert max(sign * speed for _, speed, _ in samples) <= V * (1.0 + 1e-9)
    assert samples[-1][0] == sign * 300.0


def test_change_beyond_the_target_does_not_end_a_loop(rig: Any) -> None:
    """Found by `achse swarm --plans`: on the way around its target, the next command began."""
    axis, ramps = rig.axis, (V, 3000.0, 3000.0, 50_000.0)
    axis.loop_enable, axis.loop_distance = 1, 20.0
    commands.universal_start(axis, StartType.ABSOLUTE, 100.0, *ramps)
    number = axis.set_command_number
    assert commands.universal_start(axis, 1, 300.0, *ramps, BufferMode.BLENDING_NEXT) == 0
    rig.until(lambda axis: axis.set_position > 105.0)
    axis.velocity_override = 900_000
    rig.until(lambda axis: axis.set_velocity < 0.0)
    assert axis.set_command_number == number
    rig.until(lambda axis: axis.set_command_number != number)
    assert axis.set_position == pytest.approx(100.0, abs=V * rig.dt)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_override_0_does_not_creep_on_as_a_ramp_of_the_command_before_would(
    rig: Any, sign: float
) -> None:
    """Found by `achse swarm --plans`: it looked as if it braked, by another deceleration."""
    axis = rig.axis
    commands.universal_start(axis, StartType.ABSOLUTE, sign * 300.0, V, 3000.0, 1000.0, 50_000.0)
    rig.until(lambda axis: axis.set_acceleration * sign < 0.0)
    axis.velocity_override = 0
    commands.universal_start(axis, StartType.ABSOLUTE, sign * 300.0, V, 3000.0, 3000.0, 50_000.0)
    position, velocity, _ = rig.trace(500)[-1]
    assert velocity == 0.0
    assert sign * position < 295.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_override_scales_the_velocity_of_the_way_and_not_of_a_pause_before_it(
    make_rig: Any, sign: float
) -> None:
    """Found by `achse swarm --plans`: what follows a stop before a soft limit crept for months."""
    rig = make_rig(
        encoder_soft_limit_max=100.0, encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-100.0, encoder_soft_limit_min_enable=1, override_type=3,
    )  # fmt: skip
    axis, kinds = rig.axis, (StartType.ENDLESS_POSITIVE, StartType.ENDLESS_NEGATIVE)
    commands.universal_start(axis, kinds[sign < 0.0], 0.0, 50.0)
    rig.until(lambda axis: sign * axis.set_position > 90.0)
    commands.universal_start(axis, StartType.ABSOLUTE, -sign * 90.0, V, 3000.0, 500.0 / 25.0, 5e4)
    rig.until(lambda axis: sign * axis.set_velocity <= 0.0)
    axis.velocity_override = 500_000
    highest = max(-sign * speed for _, speed, _ in rig.trace(1000))
    assert highest > 0.5 * 50.0
