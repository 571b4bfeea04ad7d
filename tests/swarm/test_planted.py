"""The swarm finds faults that are planted: some of `tests.swarm.planted`, in worlds that show them.

`python -m tests.swarm.planted` plants all of them, and says how long each takes to be found.
"""

import pytest

from tests.swarm.planted import PLANTED, search

FOUND = [
    ("halt_that_accelerates", 1002),
]
"""Faults, and a short world that shows each."""


@pytest.mark.parametrize(("name", "seed"), FOUND)
def test_planted_fault_is_found(name: str, seed: int) -> None:
    found, outcome, _ = search(PLANTED[name], range(seed, seed + 1))
    assert found == seed
    assert outcome.violation is not None
