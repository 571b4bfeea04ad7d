"""Chains in one call: as many moves as asked, until the first that is wrong."""

from typing import Any

import pytest

from achse.codes.axis import StartType
from achse.motion.setpoints.jobs import set_request
from achse.motion.setpoints.setpoint import begin_job
from achse.swarm.plans import kernel
from achse.swarm.plans.check import SET_POINT
from achse.swarm.plans.player import PlanPlayer


def test_set_point_beside_its_plan_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def late(ax: Any, dt: float) -> None:
        generate(ax, 0.999 * dt)

    generate: Any = vars(kernel)["generate"]
    monkeypatch.setattr(kernel, "generate", late)
    violation = PlanPlayer(compiled=False).play(1, 0, 400, 50)
    assert violation is not None
    assert violation.invariant == "set-point"


def test_run_counts_moves_and_goes_on_behind_its_chains() -> None:
    whole, parts = PlanPlayer(), PlanPlayer()
    assert whole.play(3, 0, 8, 20) is None
    for first in (0, 5):
        assert parts.play(3, first, 5 if first == 0 else 3, 20) is None
    assert parts.digest() == whole.digest()
    assert whole.record.moves == parts.record.moves > 100


def _out_and_around(distance: float) -> int:
    """Play a loop movement that takes months to its far end; return its verdict."""
    played = PlanPlayer(compiled=False)
    ax, run = played.nc.axis(1), played.record
    ax.max_velocity = ax.drive.reference_velocity = 10.0
    ax.velocity_override, ax.loop_enable, ax.loop_distance = 1_000_000, 1, distance
    set_request(ax.job, 1, StartType.ABSOLUTE, 10.0, 1.2e-6, 2700.0, 240.0, 1e30, 0.0)
    begin_job(ax)
    return kernel._play_move(run, ax)


def test_time_that_rounding_leads_into_the_next_plan_is_no_wrong_set_point(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The ramps of the loop take less than the last place of its months."""
    monkeypatch.setattr(kernel, "_time", lambda run, ax: 1e30)
    generate: Any = vars(kernel)["generate"]
    for n in range(100):
        assert _out_and_around(10.0 + 0.1 * n) == 0
    monkeypatch.setattr(kernel, "generate", lambda ax, dt: generate(ax, dt * (1.0 - 1e-13)))
    assert _out_and_around(10.0) == SET_POINT
