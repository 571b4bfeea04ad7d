"""Clocks that a test moves: for devices, and for asyncio."""

import asyncio
import selectors
from typing import Any


class ManualClock:
    """A clock in Unix nanoseconds, stopped until `advance`: `Device(…, clock=ManualClock())`."""

    def __init__(self, now_ns: int = 1_767_225_600_000_000_000) -> None:
        self.now_ns = now_ns

    def __call__(self) -> int:
        return self.now_ns

    def advance(self, seconds: float) -> int:
        """Let time pass; the new time in ns."""
        if seconds < 0:
            raise ValueError(f"time goes forward, got {seconds} s")
        self.now_ns += round(seconds * 1e9)
        return self.now_ns


class _Jumping(selectors.DefaultSelector):
    """Instead of waiting for time to pass, moves the clock."""

    now = 0.0

    def select(self, timeout: float | None = None) -> list[Any]:
        ready = super().select(0)
        if not ready:
            if timeout is None:
                raise RuntimeError("everything waits and nothing is due: a deadlock")
            self.now += max(timeout, 0)
        return ready


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop in which an hour takes no time: `asyncio.Runner(loop_factory=VirtualTimeLoop)`.

    It jumps to the next timer as soon as nothing else is ready. For code without sockets and
    threads; a coroutine that waits forever raises RuntimeError.
    """

    def __init__(self) -> None:
        self._jumping = _Jumping()
        super().__init__(self._jumping)

    def time(self) -> float:
        """Seconds since the loop was made."""
        return self._jumping.now
