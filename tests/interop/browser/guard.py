"""A limit for each test, in CPU seconds of browser and stations: one that waits in vain fails.

Waits for a page have no limit, as a busy machine is no fault. While a test waits, a page that is
seen draws and a station goes on, so a wait that never ends reaches the limit within minutes. Then
the browser is killed, and playwright ends the wait with an error that says what it waited for.
"""

import contextlib
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread

from tests.interop.waiting import IN_VAIN
from tests.process_times import cpu_seconds_of, processes_below

__all__ = ["BrowserGuard"]

LIMIT_S = 40.0
"""CPU seconds of a test: five times those of the dearest."""

LOOK_S = 1.0
"""Pause between two looks. No result depends on it."""


class BrowserGuard:
    """Kills the browser of a test that uses more than its CPU seconds."""

    def __init__(self, limit_s: float = LIMIT_S, look_s: float = LOOK_S) -> None:
        self.limit_s = limit_s
        self.is_exceeded = False
        """True if the test that ended last was over the limit."""
        self._look_s = look_s
        self._stations: set[int] = set()

    @contextmanager
    def counting(self, station: int) -> Iterator[None]:
        """Let the process of a station count: it may be forked by a server of all workers."""
        self._stations.add(station)
        try:
            yield
        finally:
            self._stations.discard(station)

    def used_s(self) -> float:
        """Return the CPU time of this process, of those below it, and of stations, s."""
        own = os.getpid()
        return sum(map(cpu_seconds_of, {own, *processes_below(own), *self._stations}))

    @contextmanager
    def limit(self) -> Iterator[None]:
        """Raise AssertionError if what runs within uses more than the limit."""
        reason = f"the test has used {self.limit_s:g} s of CPU"
        self.is_exceeded = False
        last = self.used_s() + self.limit_s
        ended = Event()

        def watch() -> None:
            while not ended.wait(self._look_s):
                if self.used_s() > last:
                    if not self.is_exceeded:
                        self.is_exceeded = True
                        IN_VAIN.append(reason)
                    kill_browser()  # one that starts just now at the next look

        watcher = Thread(target=watch, daemon=True)
        watcher.start()
        try:
            yield
        except Exception as failure:
            if not self.is_exceeded:
                raise
            raise AssertionError(f"{reason}; it waited for this: {cause_of(failure)}") from failure
        finally:
            ended.set()
            watcher.join()
            IN_VAIN.clear()
        assert not self.is_exceeded, reason


def kill_browser() -> None:
    """Kill the Chromium that this process has started: all waits for its pages end."""
    for process in list(processes_below(os.getpid())):
        with contextlib.suppress(OSError):
            words = Path("/proc", str(process), "cmdline").read_bytes().split(b"\0")
            is_part = any(word.startswith(b"--type=") for word in words)
            if b"--remote-debugging-pipe" in words and not is_part:
                os.kill(process, signal.SIGKILL)


def cause_of(failure: BaseException) -> BaseException:
    """Return the exception that others followed from: what a test met first."""
    while failure.__context__ is not None:
        failure = failure.__context__
    return failure
