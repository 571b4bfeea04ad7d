"""A thread that runs a cycle and can halt it in the middle: control goes to and fro."""

import threading
from collections.abc import Callable

from achse.native.backend.thread_stack import start_with_stack

_STACK = 64 << 20
"""Bytes for calls inside each other."""


class Carrier:
    """Runs one piece of work at a time; the thread that starts it waits meanwhile.

    `run` and `resume` come back when the work has ended (True), or waits in `hold` (False).
    `failure` is what ended it, None if nothing did.
    """

    def __init__(self) -> None:
        self._go = threading.Semaphore(0)
        self._back = threading.Semaphore(0)
        self._work: Callable[[], object] | None = None
        self._ended = True
        self.failure: BaseException | None = None
        self._thread = threading.Thread(target=self._serve, name="achse debug", daemon=True)
        start_with_stack(self._thread, _STACK)

    def _serve(self) -> None:
        while True:
            self._go.acquire()
            work = self._work
            if work is None:
                return
            try:
                work()
            except BaseException as failure:
                self.failure = failure
            self._ended = True
            self._back.release()

    def run(self, work: Callable[[], object]) -> bool:
        """Begin some work."""
        self._work, self.failure, self._ended = work, None, False
        return self.resume()

    def resume(self) -> bool:
        """Resume the halted work."""
        self._go.release()
        self._back.acquire()
        return self._ended

    def hold(self) -> None:
        """Halt until `resume`; called inside the work."""
        self._back.release()
        self._go.acquire()

    def close(self) -> None:
        """End the thread; no work may be halted."""
        self._work = None
        self._go.release()
        self._thread.join()
