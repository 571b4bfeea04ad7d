"""The swarm finds faults that are planted: some of `tests.swarm.planted`, in worlds that show them.

`python -m tests.swarm.planted` plants all of them, and says how long each takes to be found.
"""

import pytest

from tests.swarm.planted import PLANTED, search

FOUND = [
    ("halt_that_accelerates", 2004),
    ("move_too_fast", 2031),
    ("gear_with_another_ratio", 2031),
    ("saw_with_any_gear", 3118),
    ("cam_exchange_that_jumps", 2001),
    ("jerk_too_strong", 1000),
    ("notification_lost", 1000),
    ("notification_twice", 1000),
    ("answer_lost", 1000),
    ("answer_twice", 1000),
    ("answer_to_another", 1000),
    ("ports_kept_by_the_router", 1000),
    ("leak_after_a_restart", 1000),
    ("saved_before_it_is_written", 1000),
    ("saved_in_place", 1000),
]
"""Faults, and a world that shows each within a second."""


@pytest.mark.parametrize(("name", "seed"), FOUND)
def test_planted_fault_is_found(name: str, seed: int) -> None:
    found_seed, outcome, _ = search(PLANTED[name], range(seed, seed + 1))
    assert found_seed == seed
    assert outcome.violation is not None
