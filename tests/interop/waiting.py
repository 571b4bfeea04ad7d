"""Waiting until something holds: no limit of its own, for a busy machine is no fault.

What never holds is ended by the guard of the run, whose traceback shows who waited for what.
"""

import asyncio
import time
from collections.abc import Callable

__all__ = ["until", "until_async"]

PAUSE_S = 0.002
"""Between two looks, so that the other side has the processor; no result depends on it."""


def until(condition: Callable[[], object]) -> None:
    """Return once the condition holds."""
    while not condition():
        time.sleep(PAUSE_S)


async def until_async(condition: Callable[[], object]) -> None:
    """Return once the condition holds, and let the loop run meanwhile."""
    while not condition():  # noqa: ASYNC110
        await asyncio.sleep(PAUSE_S)
