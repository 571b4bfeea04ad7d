"""Logger (port 100) and event logger (port 110): what clients and PLC code report, in the log.

Source: 000 and 002 name the ports only; the layout of a message as the logger sends it to clients
that subscribe, from recorded traffic.
"""

import logging
import struct
from collections.abc import Callable, Iterable
from enum import IntFlag
from typing import NamedTuple

from achse.ams import AmsAddress, DeviceError, Frame, TransmissionMode
from achse.ams.commands import AddNotificationRequest
from achse.ams.filetime import from_unix_ns
from achse.ams.text import terminated_text
from achse.codes import ReturnCode
from achse.router.rate import Rates
from achse.server import ClientLimits, Device, IndexGroup, RawGroup, ServiceTable
from achse.server.table import Reader

log = logging.getLogger("achse.logger")

_MESSAGES = 1
"""Index group of the logger's messages."""

_EVERY_MESSAGE = 0xFFFF
"""Index offset under which a client subscribes to them."""

_HEADER = struct.Struct("<QII16sI")
_LONGEST = 4096
_BUFFERED = 1024
"""Messages buffered for subscribers; one that is further behind misses the oldest."""


class MessageType(IntFlag):
    """Kinds of messages."""

    HINT = 0x01
    WARNING = 0x02
    ERROR = 0x04
    LOG = 0x10
    MESSAGE_BOX = 0x20
    RESOURCE = 0x40
    STRING = 0x80


class LogMessage(NamedTuple):
    """One message: FILETIME, type, AMS port and name of the sender, text."""

    filetime: int
    kind: int
    port: int
    sender: str
    text: str

    def encode(self) -> bytes:
        """As subscribers get it; the text ends with NUL."""
        text = self.text.encode("cp1252", "replace") + b"\0"
        sender = self.sender.encode("cp1252", "replace")[:15]
        return _HEADER.pack(self.filetime, self.kind, self.port, sender, len(text)) + text

    @classmethod
    def decode(cls, data: bytes) -> "LogMessage | None":
        """Return a message from its bytes; None if they are none."""
        if len(data) < _HEADER.size:
            return None
        filetime, kind, port, sender, length = _HEADER.unpack_from(data)
        if length != len(data) - _HEADER.size or port > 0xFFFF:
            return None
        return cls(filetime, kind, port, _text(sender), _text(data[_HEADER.size :]))


def _text(data: bytes) -> str:
    return "".join(sign if sign.isprintable() else " " for sign in terminated_text(data))


class _Chronicler(Device):
    """A device that shows in the log what clients write, so many lines a second at most.

    The limits are for each host (client, where the host is not known) and for all together; how
    many lines were left out is logged once a second.
    """

    def __init__(
        self,
        name: str,
        groups: Iterable[IndexGroup] = (),
        *,
        clock: Callable[[], int],
    ) -> None:
        self._clock = clock
        self._writer: object = b""
        self._left_out = 0
        super().__init__(name, (3, 1, 4024), groups, clock=clock)
        self._rates = _rates(self.limits)

    def limit(self, limits: ClientLimits) -> None:
        """Keep to other limits from now on."""
        super().limit(limits)
        self._rates = _rates(limits)

    def deliver(self, frame: Frame) -> bool:
        """Answer a request; lines count for the host that it comes from."""
        self._writer = getattr(frame.origin, "peer_host", "") or frame.source
        try:
            return super().deliver(frame)
        finally:
            self._writer = b""

    def show(self, level: int, text: str, *details: object) -> None:
        """Write a line, unless there were too many."""
        if self._rates.take(self._writer, self._clock()):
            log.log(level, text, *details)
        else:
            self._left_out += 1

    def sweep(self, now_ns: int) -> None:
        """Log how many messages were left out; called about once a second."""
        super().sweep(now_ns)
        if self._left_out:
            log.warning(
                "%s: %d messages were left out, too many a second came", self.name, self._left_out
            )
            self._left_out = 0


def _rates(limits: ClientLimits) -> Rates:
    return Rates(limits.log_lines, limits.all_log_lines)


class LoggerDevice(_Chronicler):
    """The logger: messages that are written to it go to the log and to subscribers.

    A client writes to group 1: a whole message, or a text alone with the message type as offset.
    It subscribes to group 1, offset 65535 and gets every message, whatever mode it requests, with
    what is left out of the log.
    """

    def __init__(self, *, clock: Callable[[], int], name: str = "TwinCAT Logger") -> None:
        self._messages: list[bytes] = [b""] * _BUFFERED
        """The newest, each at its number modulo `_BUFFERED`; all subscriptions read the same."""
        self._posted = 0
        messages = RawGroup(
            _MESSAGES,
            "log message",
            write=self._write,
            watch=self._watch,
            last_offset=_EVERY_MESSAGE,
            request="message, or text with the message type as offset",
            response="message",
            description="Subscribe at offset 65535.",
        )
        super().__init__(name, [messages], clock=clock)

    def post(self, message: LogMessage, *, shown: bool = False) -> None:
        """Show a message and send it to all subscribers; `shown`: the log has it."""
        if not shown:
            level = _level(message.kind)
            self.show(level, "%s (port %d): %s", message.sender, message.port, message.text)
        self._messages[self._posted % _BUFFERED] = message.encode()
        self._posted += 1

    def _write(self, offset: int, data: bytes, client: bytes) -> None:
        if len(data) > _LONGEST:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a message of {len(data)} bytes")
        message = LogMessage.decode(data)
        if message is None:
            port = AmsAddress(client).port if len(client) == 8 else 0
            kind = offset & 0xFF or int(MessageType.LOG)
            message = LogMessage(from_unix_ns(self._clock()), kind, port, "ADS", _text(data))
        self.post(message)

    def _watch(self, offset: int, length: int, client: bytes) -> Reader:
        if offset != _EVERY_MESSAGE:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"messages are at {_EVERY_MESSAGE}")
        following = self._posted
        latest = b""

        def next_message() -> bytes:
            nonlocal following, latest
            if following < self._posted:
                following = max(following, self._posted - _BUFFERED)
                latest = self._messages[following % _BUFFERED][:length]
                following += 1
            return latest

        return next_message

    def add_notification(self, request: AddNotificationRequest, client: bytes) -> int:
        """Subscribe; messages come as they are written, so each is a change."""
        if request.index_group == _MESSAGES:
            mode = TransmissionMode.SERVER_ON_CHANGE
            request = request._replace(mode=mode, cycle_time=0, max_delay=0)
        return super().add_notification(request, client)


def _level(kind: int) -> int:
    if kind & MessageType.ERROR:
        return logging.ERROR
    return logging.WARNING if kind & MessageType.WARNING else logging.INFO


class EventLoggerDevice(LoggerDevice):
    """The event logger takes whatever is written to it and shows it; there is nothing to read.

    No manual describes its services, so every group takes a Write. Events of PLC programs come as
    messages in group 1, and subscribers there get them as from the logger.
    """

    def __init__(self, *, clock: Callable[[], int]) -> None:
        super().__init__(clock=clock, name="TwinCAT Event")
        self.services = _EveryGroup(self.services, self._event)

    def _event(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        sender = AmsAddress(client) if len(client) == 8 else "this station"
        self.show(logging.INFO, "event 0x%X:0x%X of %s: %s", group, offset, sender, _Shown(data))


class _EveryGroup(ServiceTable):
    """Takes what no other group does."""

    def __init__(
        self, groups: Iterable[IndexGroup], take: Callable[[int, int, bytes, bytes], None]
    ) -> None:
        super().__init__(groups)
        self._take = take

    def find(self, group: int) -> IndexGroup:
        return self.by_index.get(group) or RawGroup(
            group,
            "event",
            write=lambda offset, data, client: self._take(group, offset, data, client),
        )


class _Shown(bytes):
    """The data of an event: a text, or the first bytes as numbers."""

    def __str__(self) -> str:
        text = self.removesuffix(b"\0")[:_LONGEST]
        return _text(text) if text and b"\0" not in text else self[:64].hex(" ")
