"""Waiting until something holds: no limit of its own, for a busy machine is no fault.

A wait fails at once when a process that it may depend on has ended. What never holds otherwise is
ended by the guard of the run, whose traceback shows who waited for what.
"""

import asyncio
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["needed", "until", "until_async"]

FIRST_S, LAST_S, GROWTH = 0.002, 0.05, 1.3
"""Pauses between two looks: they grow, as each look costs the other side too. No result depends on
them."""


PROCESSES: list[subprocess.Popen[Any]] = []
"""Processes whose end fails each wait."""

IN_VAIN: list[str] = []
"""Reasons why what is waited for will not come: they fail each wait."""


@contextmanager
def needed(process: subprocess.Popen[Any]) -> Iterator[None]:
    """Let waits fail when the process ends."""
    PROCESSES.append(process)
    try:
        yield
    finally:
        PROCESSES.remove(process)


def pauses() -> Iterator[float]:
    """Yield the pauses of one wait; raises AssertionError if it waits in vain."""
    pause = FIRST_S
    while True:
        yield pause
        assert not IN_VAIN, f"waiting in vain: {', '.join(IN_VAIN)}"
        for process in PROCESSES:
            code = process.poll()
            assert code is None, f"waiting in vain: {process.args!r} ended with {code}"
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
