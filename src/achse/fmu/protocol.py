"""Messages between the shim in the importer and the process of the station.

Both sides run on one computer: numbers have its byte order, which is little-endian on all platforms
that have a shim. Each message begins with its kind and the bytes that follow. The shim sends one
request and reads log lines until the reply comes. Saved states have channels of their own: their
descriptors travel with the reply.
"""

import socket
import struct
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

VERSION = 1

ROW = struct.Struct("<4B3I")
"""Row of the variable table: type, settable, source, 0, values, offset, bytes."""

_HEADER = struct.Struct("<II")
_LONGEST = 1 << 30


class Request(IntEnum):
    """Requests of the shim."""

    OPEN = 0
    """u32 version, path of the resources, instantiation token; the reply is the variable table:
    u32 rows, bytes of inputs, bytes of the image; the rows; the image."""
    STEP = 1
    """u64 station time to go to (ns), inputs if they have changed; the reply is the image."""
    REFRESH = 2
    """u64 variable to compute (or none of them), inputs if they have changed; the reply is the
    image."""
    SAVE = 3
    """double time of the importer since the start (s); the reply brings a channel."""
    RESTORE = 4
    """At the channel of a state: the reply brings the channel of a process that goes on from there,
    the time since the start, and the image."""
    PACK = 5
    """At the channel of a state: the reply is the state as bytes."""
    UNPACK = 6
    """A state as bytes; the reply brings a channel."""


class ValueSource(IntEnum):
    """Source of a value in the shim."""

    IMAGE = 0
    REQUEST = 1
    """It is computed when it is read."""
    TIME = 2
    """The importer's time."""


class Reply(IntEnum):
    """Messages of the station's process."""

    DONE = 0
    FAILED = 1
    """A text for the importer's log."""
    LOG = 2
    """A status (u8) and a line of the station's log, before the reply."""


class UnitMessage(NamedTuple):
    """A request as it came."""

    kind: int
    content: bytes


class TooLongError(ValueError):
    """A message longer than 1 GiB."""


def receive(channel: socket.socket) -> UnitMessage | None:
    """Return the next message; None at the end of the channel. Raises TooLongError."""
    head = _exactly(channel, _HEADER.size)
    if head is None:
        return None
    kind, size = _HEADER.unpack(head)
    if size > _LONGEST:
        raise TooLongError(f"message of {size} bytes: expected at most {_LONGEST}")
    content = _exactly(channel, size)
    return None if content is None else UnitMessage(kind, content)


def _exactly(channel: socket.socket, size: int) -> bytes | None:
    data = channel.recv(size) if size else b""
    if len(data) == size:
        return data
    parts = [data]
    missing = size - len(data)
    while data and missing:
        data = channel.recv(min(missing, 1 << 20))
        parts.append(data)
        missing -= len(data)
    return None if missing else b"".join(parts)


def send(
    channel: socket.socket, kind: Reply, content: bytes = b"", descriptors: Sequence[int] = ()
) -> None:
    """Send a message, with descriptors. Raises OSError."""
    data = _HEADER.pack(kind, len(content)) + content
    if descriptors:
        sent = socket.send_fds(channel, [data], descriptors)
        data = data[sent:]
    if data:
        channel.sendall(data)
