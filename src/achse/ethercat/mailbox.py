"""Mailbox: messages between master and slave, by protocol, with counters and repeats.

The header is 6 bytes: length, station address, channel and priority, type and counter.

Source: 001 §2.6; ETG.1000.4 §6.7 for the SyncManagers in mailbox mode.
"""

import struct
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from enum import IntEnum
from typing import NamedTuple

_HEADER = struct.Struct("<HHBB")
HEADER_SIZE = _HEADER.size
_ERROR_REPLY = struct.Struct("<HH")
_ERROR_TYPE = 1


class MailboxProtocol(IntEnum):
    """Type of a message."""

    ERROR = 0
    AOE = 1
    EOE = 2
    COE = 3
    FOE = 4
    SOE = 5
    VOE = 15


class MailboxError(IntEnum):
    """Detail of an error reply."""

    SYNTAX = 1
    UNSUPPORTED_PROTOCOL = 2
    INVALID_CHANNEL = 3
    SERVICE_NOT_SUPPORTED = 4
    INVALID_HEADER = 5
    SIZE_TOO_SHORT = 6
    NO_MEMORY = 7
    INVALID_SIZE = 8
    SERVICE_IN_WORK = 9


class Message(NamedTuple):
    """One mailbox message; `counter` runs 1..7, 0 is not counted."""

    protocol: int
    data: bytes
    counter: int = 0
    station: int = 0
    channel: int = 0
    priority: int = 0

    def encode(self) -> bytes:
        """Header and data, not padded."""
        return (
            _HEADER.pack(
                len(self.data),
                self.station,
                self.channel | self.priority << 6,
                self.protocol | self.counter << 4,
            )
            + self.data
        )

    @classmethod
    def decode(cls, buffer: bytes) -> "Message | MailboxError":
        """Return the message in a mailbox's buffer, or what is wrong with it."""
        if len(buffer) < 6:
            return MailboxError.SIZE_TOO_SHORT
        length, station, channel, kind = _HEADER.unpack_from(buffer)
        if length > len(buffer) - 6:
            return MailboxError.INVALID_SIZE
        if kind & 0x80:
            return MailboxError.INVALID_HEADER
        return cls(
            kind & 0x0F, buffer[6 : 6 + length], kind >> 4, station, channel & 0x3F, channel >> 6
        )


class MailboxServer:
    """The slave's end: takes messages, answers them by protocol, keeps answers until they are read.

    `services` maps a protocol to what answers it: data → data of the replies, or the detail of an
    error. A service raises nothing; an unknown protocol and a broken message get an error reply.
    """

    def __init__(self, services: Mapping[int, Callable[[bytes], Iterable[bytes] | int]]) -> None:
        self._services = dict(services)
        self.only: frozenset[int] | None = None
        """The protocols spoken at the moment; None: all."""
        self._waiting: deque[bytes] = deque()
        self.reset()

    def reset(self) -> None:
        """Forget what waits and which counters were used."""
        self._waiting.clear()
        self._last_received = 0
        self._counter = 0
        self.last: bytes | None = None
        """The message given out last, for a repeat."""

    def receive(self, buffer: bytes) -> None:
        """Take the message in `buffer`; the answers wait to be `given`."""
        message = Message.decode(buffer)
        if isinstance(message, MailboxError):
            self.refuse(message)
            return
        if message.counter and message.counter == self._last_received:
            return  # the master sent it again because it missed that it had arrived
        self._last_received = message.counter
        if message.protocol == MailboxProtocol.ERROR:
            return  # the master complains; an answer could go on forever
        service = self._services.get(message.protocol)
        if service is None or (self.only is not None and message.protocol not in self.only):
            self.refuse(MailboxError.UNSUPPORTED_PROTOCOL)
            return
        replies = service(message.data)
        if isinstance(replies, int):
            self.refuse(replies)
            return
        for data in replies:
            self.send(message.protocol, data)

    def send(self, protocol: int, data: bytes) -> None:
        """Let a message to the master wait its turn."""
        self._counter = self._counter % 7 + 1
        self._waiting.append(Message(protocol, data, self._counter).encode())

    def refuse(self, error: int) -> None:
        """Answer with a mailbox error."""
        self.send(MailboxProtocol.ERROR, _ERROR_REPLY.pack(_ERROR_TYPE, error))

    @property
    def waiting(self) -> bool:
        """True if messages wait to be sent."""
        return bool(self._waiting)

    def fetch(self) -> bytes | None:
        """Return the next message to the master."""
        if not self._waiting:
            return None
        self.last = self._waiting.popleft()
        return self.last
