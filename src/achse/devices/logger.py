"""Logger (port 100) and event logger (port 110): what clients and PLC code report, in the log.

Source: 000 and 002 name the ports only; the layout of a message as the logger sends it to those who
subscribe, from recorded traffic.
"""

import logging
import struct
from collections import deque
from collections.abc import Callable
from enum import IntFlag
from typing import NamedTuple
from weakref import WeakSet

from achse.ams import AmsAddress, DeviceError, TransmissionMode
from achse.ams.commands import AddNotificationRequest
from achse.ams.filetime import from_unix_ns
from achse.codes import ReturnCode
from achse.server import Device, IndexGroup, RawGroup, ServiceTable
from achse.server.table import Reader

__all__ = ["EventLoggerDevice", "LogMessage", "LoggerDevice", "MessageType"]

log = logging.getLogger("achse.logger")

_MESSAGES = 1
"""Index group of the logger's messages."""

_EVERY_MESSAGE = 0xFFFF
"""Index offset under which a client subscribes to them."""

_HEADER = struct.Struct("<QII16sI")
_LONGEST = 4096
_KEPT = 1024
"""Messages kept for a subscriber between two cycles."""


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
        """A message from its bytes; None if they are none."""
        if len(data) < _HEADER.size:
            return None
        filetime, kind, port, sender, length = _HEADER.unpack_from(data)
        if length != len(data) - _HEADER.size or port > 0xFFFF:
            return None
        return cls(filetime, kind, port, _text(sender), _text(data[_HEADER.size :]))


def _text(data: bytes) -> str:
    text = data.partition(b"\0")[0].decode("cp1252", "replace")
    return "".join(sign if sign.isprintable() else " " for sign in text)


class LoggerDevice(Device):
    """The logger: messages that are written to it go to the log and to those who subscribed.

    A client writes to group 1: a whole message, or a text alone with the message type as offset.
    It subscribes to group 1, offset 65535 and gets every message, whatever mode it asks for.
    """

    def __init__(self, *, clock: Callable[[], int]) -> None:
        self._clock = clock
        self._tails: WeakSet[_Tail] = WeakSet()
        """One for each subscription; it goes with it."""
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
        super().__init__("TwinCAT Logger", (3, 1, 4024), [messages], clock=clock)

    def post(self, message: LogMessage) -> None:
        """Show a message and send it to everybody who subscribed."""
        level = _level(message.kind)
        log.log(level, "%s (port %d): %s", message.sender, message.port, message.text)
        data = message.encode()
        for tail in self._tails:
            tail.messages.append(data)

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
        tail = _Tail(length)
        self._tails.add(tail)
        return tail

    def add_notification(self, request: AddNotificationRequest, client: bytes) -> int:
        """Subscribe; messages come as they are written, so each is a change."""
        if request.index_group == _MESSAGES:
            mode = TransmissionMode.SERVER_ON_CHANGE
            request = request._replace(mode=mode, cycle_time=0, max_delay=0)
        return super().add_notification(request, client)


class _Tail:
    """What one subscription still has to be told; gives a message per sample."""

    def __init__(self, length: int) -> None:
        self.messages: deque[bytes] = deque(maxlen=_KEPT)
        self._length = length
        self._latest = b""

    def __call__(self) -> bytes:
        if self.messages:
            self._latest = self.messages.popleft()[: self._length]
        return self._latest


def _level(kind: int) -> int:
    if kind & MessageType.ERROR:
        return logging.ERROR
    return logging.WARNING if kind & MessageType.WARNING else logging.INFO


class EventLoggerDevice(Device):
    """The event logger takes whatever is written to it and shows it; there is nothing to read.

    No manual tells its services, so every group takes a Write.
    """

    def __init__(self, *, clock: Callable[[], int]) -> None:
        super().__init__("TwinCAT Event", (3, 1, 4024), clock=clock)
        self.services = _EveryGroup(self.services)


class _EveryGroup(ServiceTable):
    """Takes what no other group does."""

    def find(self, group: int) -> IndexGroup:
        return self.by_index.get(group) or _events(group)


def _events(group: int) -> RawGroup:
    def write(offset: int, data: bytes, client: bytes) -> None:
        sender = AmsAddress(client) if len(client) == 8 else "this station"
        log.info("event 0x%X:0x%X of %s: %s", group, offset, sender, _shown(data))

    return RawGroup(group, "event", write=write)


def _shown(data: bytes) -> str:
    text = data.removesuffix(b"\0")
    return _text(data) if text and b"\0" not in text else data[:64].hex(" ")
