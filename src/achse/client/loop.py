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

    def run(self, job: Coroutine[Any, Any, V]) -> V:
        """Return the result of `job`; an interrupted wait (Ctrl-C) cancels it."""
        if self._loop.is_closed():
            job.close()
            raise RuntimeError("this client is closed")
        future = asyncio.run_coroutine_threadsafe(job, self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise

    def stop(self) -> None:
        """End loop and thread. Again is not an error."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join()
