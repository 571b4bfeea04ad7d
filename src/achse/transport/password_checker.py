"""Passwords are checked one after the other: each takes its time, in a thread, not in the loop."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import Generic, NamedTuple, TypeVar

from achse.transport.password_queue import PasswordQueue

__all__ = ["PasswordChecker"]

log = logging.getLogger("achse.router")

T = TypeVar("T")

_LONGEST_WAIT = 60.0
"""Seconds after which the queue is looked at again, though nothing came."""


class _Wish(NamedTuple, Generic[T]):
    user: str
    password: str
    request: T


class PasswordChecker(Generic[T]):
    """Requests wait for the check of their password; see `PasswordQueue` for whose is next.

    `check(user, password)` runs in a thread; `decide(request, host, right)` is awaited in the loop
    then. A fault of one request is logged and ends nothing.
    """

    def __init__(
        self,
        check: Callable[[str, str], bool],
        decide: Callable[[T, str, bool], Awaitable[None]],
    ) -> None:
        self._check = check
        self._decide = decide
        self._waiting: PasswordQueue[_Wish[T]] = PasswordQueue(time.monotonic)
        self._came = asyncio.Event()
        self._running: asyncio.Task[None] | None = None

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, host: str, user: str, password: str, request: T) -> bool:
        """Let a request wait; False if there is no room, and it is forgotten."""
        if not self._waiting.put(host, _Wish(user, password, request)):
            return False
        if self._running is None:
            self._running = asyncio.get_running_loop().create_task(self._check_each())
        self._came.set()
        return True

    async def close(self) -> None:
        """Check no more."""
        running, self._running = self._running, None
        if running is not None:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    async def _check_each(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            taken = self._waiting.take()
            if taken is None:
                self._came.clear()
                pause = min(self._waiting.pause(), _LONGEST_WAIT)
                try:
                    async with asyncio.timeout(pause if len(self._waiting) else None):
                        await self._came.wait()
                except TimeoutError:
                    pass
                continue
            host, (user, password, request) = taken
            try:
                right = await loop.run_in_executor(None, self._check, user, password)
                self._waiting.checked(host, right=right)
                await self._decide(request, host, right)
            except Exception:
                log.exception("a request of %s with a password broke", host)
