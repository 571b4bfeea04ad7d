"""One seed as a scenario of a sweep."""

from achse.swarm.scenario import TWICE_EVERY, play_seed, run, world_of
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.draws import SEEDS

SHORT = next(
    seed for seed in range(1, 400) if len(draw_world(seed).acts) < 40 and seed % TWICE_EVERY
)


def test_figures_are_those_of_the_seed() -> None:
    row = run(first=SHORT - 3, project="", invariants="", seed=3)
    outcome = play_seed(SHORT)
    assert row["world"] == str(SHORT)
    assert row["digest"] == outcome.digest
    assert (row["invariant"], row["requests"]) == ("", outcome.requests)


def test_seeds_begin_again_behind_the_last() -> None:
    assert world_of(SEEDS - 1).seed == SEEDS - 1
    row = run(first=SEEDS - 1, project="", invariants="", seed=1 + SHORT)
    assert row["world"] == str(SHORT)
