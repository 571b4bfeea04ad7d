"""An event loop in a thread of its own: what the blocking form runs on."""

import asyncio
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

V = TypeVar("V")


class LoopThread:
    """An event loop in a thread; `run` waits for a coroutine there."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._turn, name="achse client", daemon=True)
        self._thread.start()

    def _turn(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()
        self._loop.run_until_complete(self._loop.shutdown_asyncgens())
        self._loop.close()

    @property
    def is_running(self) -> bool:
        """True until `stop`; False in a forked process."""
        return self._thread.is_alive()

    def run(self, job: Coroutine[Any, Any, V]) -> V:
        """Return the result of `job`; an interrupted wait (Ctrl-C) cancels it.

        RuntimeError after `stop`, and in a process that was forked: it has no such thread.
        """
        if self._loop.is_closed():
            job.close()
            raise RuntimeError("this client is closed")
        if not self.is_running:
            job.close()
            raise RuntimeError(
                "this client belongs to the process that made it: connect again after a fork,"
                " in each process of a pool"
            )
        future = asyncio.run_coroutine_threadsafe(job, self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise

    def stop(self) -> None:
        """End loop and thread. Again is not an error, nor is it in a forked process."""
        if self.is_running:
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join()
