"""Chains of commands: what is drawn is allowed, and covers what axes are told."""

from collections import Counter
from typing import Any

from achse.codes.axis import BufferMode
from achse.codes.nc.choices import MotionPhase
from achse.motion import AxisParameters, Nc
from achse.motion.setpoints.dynamics import fastest
from achse.swarm.plans.chain import command, draw_axis, expect
from achse.swarm.plans.check import PLAN
from achse.swarm.plans.numbers import DRAWS, begin_draws

AXES = 300


def axis_of(chain: int) -> tuple[Any, Any]:
    axis: Any = Nc(2_000_000, [AxisParameters(1)], compiled=False).axis(1)
    draws = DRAWS.plain()
    begin_draws(draws, 1, 2, chain)
    draw_axis(axis, draws)
    return axis, draws


def test_drawn_state_can_be_had_within_the_limits() -> None:
    axis, draws = axis_of(0)
    moving = 0
    for chain in range(AXES):
        begin_draws(draws, 1, 2, chain)
        draw_axis(axis, draws)
        v, a, jerk = axis.set.velocity, axis.set.acceleration, axis.default_jerk
        moving += v != 0.0
        swing = a * a / (2.0 * jerk)
        if a * v > 0.0:
            assert abs(v) + swing <= fastest(axis) * (1.0 + 1e-9)
        else:
            assert swing <= abs(v) * (1.0 + 1e-9)
        assert axis.limits.low <= axis.set.position <= axis.limits.high
    assert AXES / 3 < moving < AXES


def test_commands_of_each_kind_are_drawn() -> None:
    seen: Counter[object] = Counter()
    plan = PLAN.plain()
    axis, draws = axis_of(0)
    for chain in range(AXES):
        begin_draws(draws, 1, 2, chain)
        draw_axis(axis, draws)
        for _ in range(6):
            axis.profile.replan = 0
            command(axis, draws, plan)
            expect(axis, plan)
            assert plan.highest <= plan.fastest
            seen[MotionPhase(axis.set_motion_phase)] += 1
            seen["waits"] += axis.buffer.count > 0
            seen["limits"] += axis.limits.active
            seen["override"] += axis.velocity_override < 1_000_000
            seen["target"] += plan.has_target
            seen.update(BufferMode(axis.waiting[0].mode) for _ in range(axis.buffer.count > 0))
    for kind in (
        *(MotionPhase.POSITIONING, MotionPhase.ENDLESS, MotionPhase.STOPPING),
        *("waits", "limits", "override", "target", *BufferMode),
    ):
        assert seen[kind] > 0 or kind is BufferMode.ABORTING, kind
