"""The order of a cycle: every master before those that follow it."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.motion.order import CouplingRing, CycleOrder


def above(links: dict[int, tuple[int, ...]], row: int) -> set[int]:
    """All that a row follows, by way of others."""
    results: set[int] = set()
    waiting = [row]
    while waiting:
        for each in links[waiting.pop()]:
            if each not in results:
                results.add(each)
                waiting.append(each)
    return results


def test_without_couplings_it_is_that_of_the_rows() -> None:
    assert list(CycleOrder(4).rows) == [0, 1, 2, 3]


def test_the_memory_stays_where_it_is() -> None:
    order = CycleOrder(3)
    before = order.arguments
    order.arrange({0: [2]})
    assert order.arguments == before
    assert list(order.rows) == [1, 2, 0]
    order.arrange({})
    assert list(order.rows) == [0, 1, 2]


@given(st.lists(st.tuples(st.integers(0, 9), st.sets(st.integers(0, 9), max_size=4)), max_size=30))
def test_masters_come_first_and_rings_are_refused(steps: list[tuple[int, set[int]]]) -> None:
    order = CycleOrder(10)
    links: dict[int, tuple[int, ...]] = dict.fromkeys(range(10), ())
    for row, masters in steps:
        wanted = links | {row: tuple(masters)}
        before = list(order.rows)
        if any(row == master or row in above(wanted, master) for master in masters):
            with pytest.raises(CouplingRing) as caught:
                order.arrange(wanted)
            ring = caught.value.rows
            assert ring[0] == ring[-1]
            assert all(a in wanted[b] for a, b in pairwise(ring))
            assert list(order.rows) == before
            continue
        links = wanted
        order.arrange(links)
        turns = list(order.rows)
        assert sorted(turns) == list(range(10))
        for follower in range(10):
            assert all(turns.index(each) < turns.index(follower) for each in links[follower])


def test_the_error_names_the_ring() -> None:
    with pytest.raises(CouplingRing, match="rows"):
        CycleOrder(3).arrange({0: [1], 1: [0]})
