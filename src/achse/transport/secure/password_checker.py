"""Passwords are checked one after the other: each takes its time, in a thread, not in the loop.

A password that was wrong once is not checked again: senders with an old password, which repeat it
for ever, cost one check.
"""

import asyncio
import hashlib
import logging
import os
import time
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, Generic, NamedTuple, TypeVar

from achse.transport.secure.password_queue import PasswordQueue

log = logging.getLogger("achse.router")

T = TypeVar("T")

_LONGEST_WAIT = 60.0
"""Seconds after which the queue is looked at again, though nothing came."""

_KNOWN_WRONG = 4096
"""Wrong names and passwords that are remembered, as keyed hashes; the oldest are forgotten."""


class _Wish(NamedTuple, Generic[T]):
    user: str
    password: str
    request: T


class PasswordChecker(Generic[T]):
    """Requests wait for the check of their password; see `PasswordQueue` for whose is next.

    `check(user, password)` runs in a thread and always answers the same; `decide(request, host,
    right)` is awaited in the loop then. A fault of one request is logged and ends nothing. A
    password that is known to be wrong is decided at once, and does not count as a guess.
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
        self._tasks: set[asyncio.Task[None]] = set()
        self._checking = False
        self._key = os.urandom(32)
        self._wrong: OrderedDict[bytes, None] = OrderedDict()

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, host: str, user: str, password: str, request: T) -> bool:
        """Let a request wait; False if there is no room, and it is forgotten."""
        wish = _Wish(user, password, request)
        if self._is_wrong(wish):
            self._start(self._finish(request, host, False))
            return True
        if not self._waiting.put(host, wish):
            return False
        if not self._checking:
            self._checking = True
            self._start(self._check_each())
        self._came.set()
        return True

    async def close(self) -> None:
        """Check no more."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._checking = False

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _digest(self, wish: _Wish[T]) -> bytes:
        text = f"{wish.user.casefold()}\0{wish.password}".encode(errors="surrogatepass")
        return hashlib.blake2b(text, key=self._key, digest_size=16).digest()

    def _is_wrong(self, wish: _Wish[T]) -> bool:
        return bool(self._wrong) and self._digest(wish) in self._wrong

    async def _check_each(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            request = self._waiting.take()
            if request is None:
                self._came.clear()
                pause = min(self._waiting.pause(), _LONGEST_WAIT)
                try:
                    async with asyncio.timeout(pause if len(self._waiting) else None):
                        await self._came.wait()
                except TimeoutError:
                    pass
                continue
            host, wish = request
            try:
                right = await loop.run_in_executor(None, self._check, wish.user, wish.password)
            except Exception:
                _log_fault(host)
                continue
            self._waiting.checked(host, right=right)
            await self._finish(wish.request, host, right)
            if not right:
                self._remember(wish)
                for other, same in self._waiting.remove(self._is_wrong):
                    await self._finish(same.request, other, False)

    def _remember(self, wish: _Wish[T]) -> None:
        self._wrong[self._digest(wish)] = None
        if len(self._wrong) > _KNOWN_WRONG:
            self._wrong.popitem(last=False)

    async def _finish(self, request: T, host: str, right: bool) -> None:
        try:
            await self._decide(request, host, right)
        except Exception:
            _log_fault(host)


def _log_fault(host: str) -> None:
    log.exception("a request of %s with a password broke", host)
