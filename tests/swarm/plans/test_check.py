"""Check of a plan: what planted faults of the planner break, and what a walk comes to."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import AxisParameters, Nc
from achse.motion.setpoints import planning
from achse.motion.setpoints.planning import TO_CONSTANT_VELOCITY
from achse.swarm.plans.check import PLAN, lose, walk
from achse.swarm.plans.player import PlanPlayer

CHAINS = 400


def _too_fast(patch: pytest.MonkeyPatch) -> None:
    plan = planning._plan_to_target
    patch.setattr(planning, "_plan_to_target", lambda ax, v, end: plan(ax, 1.001 * v, end))


def _arguments(name: str, number: int, factor: float) -> Callable[[pytest.MonkeyPatch], None]:
    def plant(patch: pytest.MonkeyPatch) -> None:
        original = getattr(planning, name)

        def changed(*times: float) -> int:
            values = list(times)
            values[number] *= factor
            return int(original(*values))

        patch.setattr(planning, name, changed)

    return plant


def _way_in_last_segment(patch: pytest.MonkeyPatch) -> None:
    original: Any = vars(planning)["plan_to_position"]

    def changed(times: Any, jerks: Any, *limits: float) -> int:
        count = int(original(times, jerks, *limits))
        if count > 0:
            times[count - 1] *= 1.0 + 1e-5
        return count

    patch.setattr(planning, "plan_to_position", changed)


def _limit_ignored(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(planning, "passes", lambda ax, first, count, p, v, a: 0)
    patch.setattr(planning, "_find_limit", lambda ax: 0)


PLANTED = {
    "velocity": (_too_fast, {"velocity"}),
    "acceleration": (_arguments("plan_to_position", 8, 1.001), {"acceleration"}),
    "deceleration": (_arguments("plan_to_position", 9, 1.001), {"acceleration"}),
    "jerk": (_arguments("plan_to_position", 10, 1.001), {"jerk"}),
    "stop": (_arguments("plan_to_velocity", 6, 1.001), {"acceleration", "jerk"}),
    "target": (_arguments("plan_to_position", 5, 1.0 + 1e-7), {"target"}),
    "time": (_way_in_last_segment, {"target", "end"}),
    "limit": (_limit_ignored, {"limit"}),
}
"""Planted faults of the planner, with the invariants that may name them."""


@pytest.mark.parametrize("name", PLANTED)
def test_planted_fault_of_the_planner_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plant, invariants = PLANTED[name]
    plant(monkeypatch)
    violation = PlanPlayer(compiled=False).play(1, 0, CHAINS, 50)
    assert violation is not None
    assert violation.invariant in invariants
    assert violation.what.startswith("chain ")


def test_walk_goes_on_at_the_last_velocity() -> None:
    axis: Any = Nc(2_000_000, [AxisParameters(1)], compiled=False).axis(1)
    profile, plan = axis.profile, PLAN.plain()
    plan.p0, profile.count, profile.end, profile.end_velocity = 5.0, 2, TO_CONSTANT_VELOCITY, 4.0
    profile.time[0], profile.jerk[0], profile.time[1], profile.jerk[1] = 1.0, 4.0, 1.0, -4.0
    walk(plan, axis, 1.0)
    assert (plan.p, plan.v, plan.a, plan.running) == pytest.approx((5.0 + 4.0 / 6.0, 2.0, 4.0, 4.0))
    walk(plan, axis, 3.0)
    assert (plan.p, plan.v, plan.a) == pytest.approx((13.0, 4.0, 0.0))


def test_lost_plan_keeps_the_jerk_that_is_to_come() -> None:
    axis: Any = Nc(2_000_000, [AxisParameters(1)], compiled=False).axis(1)
    profile, plan = axis.profile, PLAN.plain()
    profile.count, profile.index = 3, 1
    profile.jerk[0], profile.jerk[1], profile.jerk[2] = 7.0, 0.0, -3.0
    lose(plan, axis)
    assert (plan.known, plan.running) == (0, 3.0)
