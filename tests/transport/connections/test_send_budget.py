"""One sum over all that is kept: it holds, and the largest goes first."""

from hypothesis import given
from hypothesis import strategies as st

from achse.transport.connections.send_budget import SendBudget


class Keeps:
    """Keeps so many bytes, until it is cut."""

    def __init__(self) -> None:
        self.buffered_bytes = 0
        self.cuts = 0

    def cut(self, reason: str, *details: object) -> None:
        self.cuts += 1
        self.buffered_bytes = 0


def test_the_largest_goes_until_an_eighth_is_free() -> None:
    budget = SendBudget(800)
    keepers = [Keeps() for _ in range(4)]
    for keeper, size in zip(keepers, (100, 400, 200, 100), strict=True):
        keeper.buffered_bytes = size
        budget.count(keeper, size)
    assert budget.total == 800
    keepers[0].buffered_bytes = 101
    budget.count(keepers[0], 101)
    assert [keeper.cuts for keeper in keepers] == [0, 1, 0, 0]
    assert budget.total == 401


def test_silently_drained_buffers_are_polled_before_any_client_is_dropped() -> None:
    budget = SendBudget(100)
    first, second = Keeps(), Keeps()
    first.buffered_bytes = 90
    budget.count(first, 90)
    first.buffered_bytes = 10
    second.buffered_bytes = 50
    budget.count(second, 50)
    assert (first.cuts, second.cuts, budget.total) == (0, 0, 60)


@given(
    st.integers(1, 10_000),
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 3000), st.booleans()), max_size=200),
)
def test_however_sizes_change_the_sum_holds(limit: int, steps: list[tuple[int, int, bool]]) -> None:
    """Growth is told, shrinking sometimes."""
    budget = SendBudget(limit)
    keepers = [Keeps() for _ in range(10)]
    for number, size, message in steps:
        keeper = keepers[number]
        grows = size > keeper.buffered_bytes
        keeper.buffered_bytes = size
        if grows or message:
            budget.count(keeper, size)
        total = sum(keeper.buffered_bytes for keeper in keepers)
        assert total <= budget.total or any(keeper.cuts for keeper in keepers)
        assert total <= limit
        assert budget.total <= limit
