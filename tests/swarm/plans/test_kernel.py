"""Chains in one call: as many moves as asked, until the first that is wrong."""

from typing import Any

import pytest

from achse.swarm.plans import kernel
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
