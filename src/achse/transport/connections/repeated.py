"""Reads that a client sends again and again: answered without taking the frame apart.

A client that polls sends the same bytes each time but for the invoke id. Where the way of such a
request is known, its answer is a head that is known too, the invoke id, and the value as it is now.
Whatever could change the way (`Router.changes`), and every refusal, leads back to the frame.

Source: 000 §3.2, the headers of AMS/TCP; the request and the answer of Read.
"""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from achse.ams import Command, Flags
from achse.ams.commands import READ, RESULT_LENGTH
from achse.ams.frame import AMS_HEADER, TCP_HEADER
from achse.router import Router

_HEADERS = TCP_HEADER.size + AMS_HEADER.size
_BEFORE = _HEADERS - 4
"""Bytes before the invoke id."""

REQUEST_SIZE = _HEADERS + READ.size
"""Bytes of a Read on the wire."""

_MOST = 256
"""Different requests of one connection that are noted; then it begins again."""

_LONGEST = 1024
"""Bytes of a value; to copy a longer one takes longer than to find it."""


class _Readable(Protocol):
    """An index group of a device."""

    def read(self, group: int, offset: int, length: int, client: bytes, /) -> bytes: ...


class _Way(NamedTuple):
    """Destination of a repeated request, and the start of its answer."""

    changes: int
    groups: Mapping[int, _Readable]
    group: int
    offset: int
    length: int
    target: bytes
    source: bytes
    heads: dict[int, tuple[bytes, bytes]]
    """By length of the value: what comes before the invoke id, and what comes behind it."""

    def head(self, length: int) -> tuple[bytes, bytes]:
        """Make one more of `heads`."""
        size = RESULT_LENGTH.size + length
        header = AMS_HEADER.pack(
            self.source,
            self.target,
            Command.READ,
            Flags.ADS_COMMAND | Flags.RESPONSE,
            size,
            0,
            0,
        )
        before = TCP_HEADER.pack(0, AMS_HEADER.size + size) + header[:-4]
        self.heads[length] = before, RESULT_LENGTH.pack(0, length)
        return self.heads[length]


class RepeatedReads:
    """The reads that one connection sends again and again."""

    def __init__(self, router: Router) -> None:
        self._router = router
        self._noted: dict[bytes, _Way | None] = {}

    def answer(self, data: bytes, source: bytes) -> tuple[bytes, int]:
        """Return the answers to the requests that `data` begins with, and how many bytes these are.

        Requests count that `source` has sent before; the rest is for others to take apart.
        """
        answers: list[bytes] = []
        noted, changes = self._noted, self._router.changes
        position, end = 0, len(data)
        while end - position >= REQUEST_SIZE:
            invoke_id = position + _BEFORE
            key = data[position:invoke_id] + data[position + _HEADERS : position + REQUEST_SIZE]
            way = noted.get(key)
            if way is None or way.changes != changes or way.source != source:
                self._note(key, source)
                break
            try:
                value = way.groups[way.group].read(way.group, way.offset, way.length, source)
            except Exception:  # decoding raises it again, and reports it
                break
            length = len(value)
            before, behind = way.heads.get(length) or way.head(length)
            answers += (before, data[invoke_id : invoke_id + 4], behind, value)
            position += REQUEST_SIZE
        return b"".join(answers), position

    def clear(self) -> None:
        """Drop all: the peer is disconnected."""
        self._noted.clear()

    def _note(self, key: bytes, source: bytes) -> None:
        """Remember a request; at the second time, where it leads."""
        noted = self._noted
        if len(noted) >= _MOST:
            noted.clear()
        first = key not in noted
        noted[key] = None if first else self._way(key, source)

    def _way(self, key: bytes, source: bytes) -> _Way | None:
        """Return the destination of a request that reads a local device; None for any other."""
        command, size = TCP_HEADER.unpack_from(key)
        if command or size != AMS_HEADER.size + READ.size:
            return None
        header = key[TCP_HEADER.size : _BEFORE] + bytes(4)
        target, sender, ads, flags, size, _, _ = AMS_HEADER.unpack(header)
        if ads != Command.READ or flags != Flags.ADS_COMMAND or size != READ.size:
            return None
        group, offset, length = READ.unpack_from(key, _BEFORE)
        groups = self._router.groups_at(target)
        if groups is None or sender != source or length > _LONGEST:
            return None
        return _Way(self._router.changes, groups, group, offset, length, target, source, {})
