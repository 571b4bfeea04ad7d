"""Plans without cycles: they hold, are equal in both kernels, and show planted faults."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.swarm.plans import player
from achse.swarm.plans.player import PlanPlayer, play_chain, play_plans


def test_drawn_plans_keep_the_invariants(many: Callable[[int], int]) -> None:
    played = PlanPlayer()
    assert played.play(7, 0, many(2000), 50) is None
    assert played.record.moves > many(2000) * 40


def test_chains_of_a_large_seed_differ() -> None:
    digests = set()
    for seed in (5, 5 + (1 << 32), 6):
        played = PlanPlayer()
        assert played.play(seed, 0, 5, 20) is None
        digests.add(played.digest())
    assert len(digests) == 3


def test_both_kernels_have_equal_digests() -> None:
    digests = []
    for compiled in (None, False):
        played = PlanPlayer(compiled=compiled)
        assert played.play(11, 0, 12, 40) is None
        digests.append(played.digest())
    assert digests[0] == digests[1]


def test_difference_between_kernels_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    play = PlanPlayer.play

    def other(self: PlanPlayer, seed: int, *settings: int) -> Any:
        return play(self, seed + (not self.nc.compiled), *settings)

    monkeypatch.setattr(PlanPlayer, "play", other)
    monkeypatch.setattr(player, "CHAINS_OF_A_SEED", 10)
    outcome = play_plans(0, compiled=True)
    assert outcome.violation is not None
    assert outcome.violation.invariant == "equal-digest"


def test_seed_is_summed_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(player, "CHAINS_OF_A_SEED", 100)
    outcome = play_plans(3)
    assert outcome.violation is None
    assert outcome.moves > 40
    assert outcome.digest == play_plans(3).digest != play_plans(4).digest


def test_chain_is_played_alone() -> None:
    assert play_chain(1, 86_892) is None
    assert play_chain(1, 315_189) is None
    assert play_chain(1, 1046) is None
    assert play_chain(1, 268) is None


@pytest.mark.parametrize(
    ("seed", "chain"),
    [
        (1000118, 2340), (1000137, 7881), (1000143, 4457),
        (1000155, 124), (1000170, 10848), (1000172, 12900), (1000934, 5941),
    ],
)  # fmt: skip
def test_chain_that_a_campaign_found_holds(seed: int, chain: int) -> None:
    assert play_chain(seed, chain, compiled=False) is None
