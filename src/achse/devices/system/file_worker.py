"""File services beside the loop: one thread does the disk accesses of clients, a client at a time.

A folder of many files, a large file or a slow disk may take seconds. The loop hands the work over
and answers when it is done; clients take turns, and requests of one client are done in their order.
"""

import asyncio
import threading
from collections import OrderedDict, deque
from collections.abc import Callable
from contextlib import suppress

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server.deferred import Answer, Deferred, Result

_PER_CLIENT = 64
"""Requests of one client that may wait."""

_ALL_CLIENTS = 1024
"""The same of all clients: addresses cost nothing."""

_RESULT_BYTES = 64 * 1024 * 1024
"""Results that the loop has not taken; beyond, the thread waits for it."""

_BYTES = 64 * 1024 * 1024
"""Data of requests that may wait, all together; a single larger one goes if none does."""

_PATIENCE = 1.0
"""Seconds that `stop` waits for what is being done: a disk may hang."""


def _no_client(_: Result) -> None:
    """Drop the result: the client is gone."""


class FileWorker:
    """The thread, from construction to `stop`; to be used in the thread of `loop` only."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._waiting: OrderedDict[bytes, deque[tuple[int, Result, Answer]]] = OrderedDict()
        self._bytes = 0
        self._count = 0
        """Requests that wait."""
        self._result_bytes = 0
        self._changed = threading.Condition()
        self._stopped = False
        self._thread = threading.Thread(target=self._work, name="file services", daemon=True)
        self._thread.start()

    def later(self, client: bytes, size: int, job: Result) -> Deferred:
        """Return the answer to a request with `size` bytes of data: that of `job`, later.

        Raises DeviceError 0x708 if too much waits already.
        """
        with self._changed:
            waiting = len(self._waiting.get(client, ()))
            too_many = waiting >= _PER_CLIENT or self._count >= _ALL_CLIENTS
            if too_many or (self._bytes and self._bytes + size > _BYTES):
                raise DeviceError(
                    ReturnCode.BUSY,
                    f"{waiting} file requests of the client wait, {self._count} of all",
                )
        return Deferred(lambda answer: self._put(client, size, job, answer))

    def end_client(self, client: bytes, job: Callable[[], None]) -> None:
        """Forget what a client still wants, and do `job` after what is being done."""
        with self._changed:
            for size, _, _ in self._waiting.pop(client, ()):
                self._bytes -= size
                self._count -= 1
        self.do(client, job)

    def do(self, client: bytes, job: Callable[[], None]) -> None:
        """Do `job` in turn."""

        def done() -> bytes:
            job()
            return b""

        self._put(client, 0, done, _no_client)

    def stop(self) -> None:
        """Forget all that waits and end the thread."""
        with self._changed:
            self._stopped = True
            self._waiting.clear()
            self._count = 0
            self._changed.notify()
        self._thread.join(_PATIENCE)

    def _put(self, client: bytes, size: int, job: Result, answer: Answer) -> None:
        with self._changed:
            self._waiting.setdefault(client, deque()).append((size, job, answer))
            self._bytes += size
            self._count += 1
            self._changed.notify()

    def _take(self) -> tuple[int, Result, Answer] | None:
        """Return the next job: the oldest of the client that has waited longest for its turn."""
        with self._changed:
            self._changed.wait_for(
                lambda: self._stopped or (self._waiting and self._result_bytes < _RESULT_BYTES)
            )
            if self._stopped:
                return None
            client, jobs = self._waiting.popitem(last=False)
            taken = jobs.popleft()
            self._count -= 1
            if jobs:
                self._waiting[client] = jobs
            return taken

    def _work(self) -> None:
        while (taken := self._take()) is not None:
            size, job, answer = taken
            result, length = _done(job)
            has_client = answer is not _no_client
            with self._changed:
                self._bytes -= size
                self._result_bytes += length if has_client else 0
            if has_client:
                with suppress(RuntimeError):  # the loop has ended
                    self._loop.call_soon_threadsafe(self._give, answer, result, length)

    def _give(self, answer: Answer, result: Result, length: int) -> None:
        """Pass on a result of so many bytes; called in the loop."""
        with self._changed:
            self._result_bytes -= length
            self._changed.notify()
        answer(result)


def _done(job: Result) -> tuple[Result, int]:
    """Do a job; what then gives its value, or raises what went wrong, and the bytes of it."""
    try:
        value = job()
    except Exception as failure:
        refusal = failure

        def fail() -> bytes:
            raise refusal

        return fail, 0
    return (lambda: value), len(value)
