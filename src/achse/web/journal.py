"""The log of a target: messages of its logger, of a station in this process all lines."""

import asyncio
import struct
from typing import Any

from achse.ams.filetime import to_datetime
from achse.ams.text import terminated_text
from achse.codes.ports import LOGGER_PORT
from achse.web.arguments import Arguments
from achse.web.process_log import ProcessLog
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import WatchedTarget

_MESSAGES, _EVERY_MESSAGE = 1, 0xFFFF
_HEADER = struct.Struct("<QII16sI")
_LONGEST = 4096
_LEVELS = ((0x04, "error"), (0x02, "warning"), (0x01, "info"))


class JournalHandlers:
    """Follows the logger of a target, or the log of its process, which has those messages too."""

    def __init__(self, watched: WatchedTarget, process_log: ProcessLog | None = None) -> None:
        self._logger = watched.device(LOGGER_PORT)
        self._process_log = process_log

    async def watch(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `log`: messages from now on; of this process the newest 500 before, too."""
        if self._process_log is not None:
            with self._process_log.followed(subscription.show_lines):
                await asyncio.Event().wait()
        async with self._logger.subscribe_as(
            _MESSAGES, _EVERY_MESSAGE, _LONGEST, cycle_time=0.0
        ) as samples:
            async for sample in samples:
                message = message_of(bytes(sample.value))
                if message is not None:
                    subscription.show_lines([message])


def message_of(data: bytes) -> dict[str, Any] | None:
    """Return a message of the logger as a line; None if the bytes are not one."""
    if len(data) < _HEADER.size:
        return None
    filetime, kind, port, sender, length = _HEADER.unpack_from(data)
    text = data[_HEADER.size : _HEADER.size + length]
    if not filetime:
        return None  # nothing was logged yet
    try:
        time = to_datetime(filetime).timestamp()
    except (OverflowError, ValueError, OSError):
        time = None
    return {
        "time": time,
        "level": next((name for bit, name in _LEVELS if kind & bit), "info"),
        "source": terminated_text(sender) or f"port {port}",
        "port": port,
        "text": terminated_text(text),
    }
