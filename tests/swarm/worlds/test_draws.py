"""Streams of random numbers by name."""

import pytest

from achse.swarm.worlds.draws import Stream


def test_stream_depends_on_seed_and_name_alone() -> None:
    first = [Stream(5, "axis", 1).random() for _ in range(2)]
    assert first[0] == first[1]
    others = [(5, "axis", 2), (6, "axis", 1), (5, "client", 1)]
    assert len({first[0], *(Stream(*each).random() for each in others)}) == 4


@pytest.mark.parametrize("seed", range(20))
def test_numbers_are_in_their_range(seed: int) -> None:
    draws = Stream(seed, "x")
    assert 0.01 <= draws.decades(-2.0, 1.0) <= 10.0
    value = draws.uniform(-1e6, 1e6)
    assert abs(draws.rounded(value) - value) <= 5e-4 * abs(value)
    assert not draws.chance(0.0)
    assert draws.chance(1.0)
