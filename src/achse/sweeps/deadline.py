"""A time that a run may take; then it is ended, wherever in Python it is."""

import contextlib
import ctypes
import os
import threading
from collections.abc import Iterator

_AGAIN = 0.2
"""Seconds between attempts to end a run: code may swallow one."""

_GRACE = 2.0
"""Seconds that a run has to end; one that waits in the operating system does not hear of it."""

_GONE = 75
"""Exit code of a worker that has ended itself."""


class RunTooLong(BaseException):
    """Raised in a run that takes too long; not an Exception, which scenarios catch."""


@contextlib.contextmanager
def within(seconds: float | None, *, own_process: bool = False) -> Iterator[None]:
    """Limit the block inside to `seconds` by raising RunTooLong in it; None sets no limit.

    A run that does not end by the exception takes its process with it, if it has its `own_process`.
    """
    if seconds is None:
        yield
        return
    watch = _Watch(seconds, own_process)
    try:
        try:
            yield
        finally:
            watch.end()
    except BaseException:
        watch.end()
        if watch.fired:  # whatever became of it
            raise RunTooLong from None
        raise
    if watch.fired:
        raise RunTooLong


class _Watch:
    """Interrupts the thread that made it, again and again until `end`."""

    def __init__(self, seconds: float, own_process: bool) -> None:
        self.fired = False
        self._thread = threading.get_ident()
        self._own_process = own_process
        self._ended = threading.Event()
        self._turn = threading.Lock()
        self._timer = threading.Thread(target=self._run, args=(seconds,), daemon=True)
        self._timer.start()

    def _run(self, seconds: float) -> None:
        if self._ended.wait(seconds):
            return
        remaining = _GRACE
        while not self._ended.wait(_AGAIN if self.fired else 0.0):
            with self._turn:
                if self._ended.is_set():
                    return
                self.fired = True
                self._raise()
            remaining -= _AGAIN
            if remaining <= 0 and self._own_process:
                os._exit(_GONE)

    def end(self) -> None:
        """End the deadline; an exception that is not delivered yet is dropped."""
        while True:
            try:
                with self._turn:
                    self._ended.set()
                break
            except RunTooLong:
                continue
        if not self.fired:
            return
        # To set None in place of what is pending would leave Python's flag for it set for ever:
        # a process that is traced or profiled would then hang. Only raising takes the flag back.
        with contextlib.suppress(RunTooLong):
            self._raise()
            while True:
                pass

    def _raise(self) -> None:
        """Raise RunTooLong in the watched thread, in place of one that has not come up yet."""
        ctypes.pythonapi.PyThreadState_SetAsyncExc(
            ctypes.c_ulong(self._thread), ctypes.py_object(RunTooLong)
        )
