"""The outcome of a world: figures that begin at nothing, and a violation as one line."""

from achse.swarm.outcome import BrokenInvariant, WorldOutcome


def test_outcome_begins_without_figures_and_shares_none() -> None:
    first, second = WorldOutcome(), WorldOutcome()
    first.excuses["abrupt_cycle"] += 1
    assert (second.moves, second.violation, second.excuses["abrupt_cycle"]) == (0, None, 0)


def test_violation_is_its_invariant_and_what_happened() -> None:
    assert str(BrokenInvariant("rest", "axis X moved")) == "rest: axis X moved"
