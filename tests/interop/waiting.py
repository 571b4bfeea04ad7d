"""Waiting until something holds: no limit of its own, for a busy machine is no fault.

What never holds is ended by the guard of the run, whose traceback shows who waited for what.
"""

import asyncio
import time
from collections.abc import Callable, Iterator

__all__ = ["until", "until_async"]

FIRST_S, LAST_S, GROWTH = 0.002, 0.05, 1.3
"""Pauses between two looks: they grow, as each look costs the other side too. No result depends on
them."""


def pauses() -> Iterator[float]:
    """Yield the pauses of one wait."""
    pause = FIRST_S
    while True:
        yield pause
        pause = min(pause * GROWTH, LAST_S)


def until(condition: Callable[[], object]) -> None:
    """Return once the condition holds."""
    waiting = pauses()
    while not condition():
        time.sleep(next(waiting))


async def until_async(condition: Callable[[], object]) -> None:
    """Return once the condition holds, and let the loop run meanwhile."""
    waiting = pauses()
    while not condition():  # noqa: ASYNC110
        await asyncio.sleep(next(waiting))
