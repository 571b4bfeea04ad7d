"""One sum over all that is kept: it holds, and the largest goes first."""

from hypothesis import given
from hypothesis import strategies as st

from achse.transport.connections.held import Held


class Keeps:
    """Keeps so many bytes, until it is cut."""

    def __init__(self) -> None:
        self.held = 0
        self.cuts = 0

    def cut(self, reason: str, *details: object) -> None:
        self.cuts += 1
        self.held = 0


def test_the_largest_goes_until_an_eighth_is_free() -> None:
    held = Held(800)
    keepers = [Keeps() for _ in range(4)]
    for keeper, size in zip(keepers, (100, 400, 200, 100), strict=True):
        keeper.held = size
        held.count(keeper, size)
    assert held.total == 800
    keepers[0].held = 101
    held.count(keepers[0], 101)
    assert [keeper.cuts for keeper in keepers] == [0, 1, 0, 0]
    assert held.total == 401


def test_what_drained_without_a_word_is_asked_for_before_anybody_goes() -> None:
    held = Held(100)
    first, second = Keeps(), Keeps()
    first.held = 90
    held.count(first, 90)
    first.held = 10
    second.held = 50
    held.count(second, 50)
    assert (first.cuts, second.cuts, held.total) == (0, 0, 60)


@given(
    st.integers(1, 10_000),
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 3000), st.booleans()), max_size=200),
)
def test_however_sizes_change_the_sum_holds(limit: int, steps: list[tuple[int, int, bool]]) -> None:
    """Growth is told, shrinking sometimes."""
    held = Held(limit)
    keepers = [Keeps() for _ in range(10)]
    for number, size, told in steps:
        keeper = keepers[number]
        grows = size > keeper.held
        keeper.held = size
        if grows or told:
            held.count(keeper, size)
        total = sum(keeper.held for keeper in keepers)
        assert total <= held.total or any(keeper.cuts for keeper in keepers)
        assert total <= limit
        assert held.total <= limit
