"""Blocks close what they enter, once, whether they end or fail."""

import pytest

from achse.client.session.closing import ClosedByBlock


class Counted(ClosedByBlock):
    """Number of closes."""

    closes = 0

    async def close(self) -> None:
        self.closes += 1


async def test_block_that_ends_closes() -> None:
    async with Counted() as entered:
        assert entered.closes == 0
    assert entered.closes == 1


async def test_block_that_fails_closes_and_passes_the_error_on() -> None:
    entered = Counted()
    with pytest.raises(KeyError):
        async with entered:
            raise KeyError
    assert entered.closes == 1
