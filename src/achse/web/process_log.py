"""The log of a station's own process for pages: the newest lines, and each as it comes."""

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

from achse.router.rate import Rates

_LOGGER = "achse"
_KEPT = 500
"""Lines that a page gets which is opened later."""

_PER_SECOND, _ALL_PER_SECOND = 100, 1000
"""Lines a second of one place in the program, and of all; more are left out, as on stderr."""

_LEVELS = ((logging.ERROR, "error"), (logging.WARNING, "warning"))

Receive = Callable[[list[dict[str, Any]]], None]


class ProcessLog(logging.Handler):
    """Keeps lines of `achse` from level info on, whatever level other handlers write.

    `attach` lets the loggers make them, `detach` undoes that: a station without pages pays nothing.
    """

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._lines: deque[dict[str, Any]] = deque(maxlen=_KEPT)
        self._rates = Rates(_PER_SECOND, _ALL_PER_SECOND)
        self._followers: dict[Receive, asyncio.AbstractEventLoop] = {}
        self._level_before: int | None = None

    def attach(self) -> None:
        """Keep lines from now on."""
        logger = logging.getLogger(_LOGGER)
        logger.addHandler(self)
        self._level_before = logger.level
        if logger.getEffectiveLevel() > logging.INFO:
            logger.setLevel(logging.INFO)

    def detach(self) -> None:
        """Keep no more lines. Without `attach` nothing happens."""
        if self._level_before is None:
            return
        logger = logging.getLogger(_LOGGER)
        logger.removeHandler(self)
        logger.setLevel(self._level_before)
        self._level_before = None
        self._lines.clear()

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a line and pass it to the loops that follow; called in any thread."""
        place = (record.pathname, record.lineno)
        if not self._rates.take(place, round(record.created * 1e9)):
            return
        line = {
            "time": record.created,
            "level": next((name for at, name in _LEVELS if record.levelno >= at), "info"),
            "source": record.name.removeprefix(f"{_LOGGER}."),
            "text": record.getMessage(),
        }
        self._lines.append(line)
        for receive, loop in list(self._followers.items()):
            with contextlib.suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(receive, [line])

    @contextlib.contextmanager
    def followed(self, receive: Receive) -> Iterator[None]:
        """Call `receive` with the lines that are kept, and with each new one in this loop."""
        with self.lock or contextlib.nullcontext():
            self._followers[receive] = asyncio.get_running_loop()
            earlier = list(self._lines)
        if earlier:
            receive(earlier)
        try:
            yield
        finally:
            self._followers.pop(receive, None)
