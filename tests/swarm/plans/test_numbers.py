"""Random numbers of a kernel: evenly distributed, apart for each chain, equal in both forms."""

from typing import Any

import pytest

from achse.swarm.plans.numbers import DRAWS, begin_draws, chance, decades, draw, one_of, uniform

COUNT = 4000


def stream(low: int = 1, high: int = 0, chain: int = 0) -> Any:
    draws = DRAWS.plain()
    begin_draws(draws, low, high, chain)
    return draws


def test_numbers_are_evenly_distributed() -> None:
    draws = stream()
    bins = [0] * 16
    for _ in range(COUNT):
        bins[int(16 * draw(draws))] += 1
    expected = COUNT / 16
    assert sum((each - expected) ** 2 / expected for each in bins) < 45.0  # p < 1e-4


def test_each_seed_and_chain_has_numbers_of_its_own() -> None:
    parts = [(low, high, chain) for low in range(8) for high in range(8) for chain in range(8)]
    first = {tuple(draw(each) for _ in range(2)) for each in (stream(*p) for p in parts)}
    assert len(first) == len(parts)
    assert draw(stream(3, 4, 5)) == draw(stream(3, 4, 5))


def test_neighbours_do_not_resemble_each_other() -> None:
    pairs = [(draw(stream(chain=n)), draw(stream(chain=n + 1))) for n in range(COUNT)]
    mean = sum((a - 0.5) * (b - 0.5) for a, b in pairs) / COUNT
    assert abs(mean) < 5.0 / 12.0 / COUNT**0.5


def test_derived_numbers_stay_in_their_ranges() -> None:
    draws = stream()
    for _ in range(200):
        assert 2.0 <= uniform(draws, 2.0, 5.0) < 5.0
        assert 0.1 <= decades(draws, -1.0, 2.0) < 100.0
        assert one_of(draws, 3) in (0, 1, 2)
    share = sum(chance(draws, 0.25) for _ in range(COUNT)) / COUNT
    assert share == pytest.approx(0.25, abs=0.04)
