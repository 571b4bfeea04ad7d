"""Taps: captured frames of a router, stored once for all readers, and their encoding."""

import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import NamedTuple

from achse.ams import AmsAddress, Command, DecodeError, Frame, RouterError
from achse.codes import ReturnCode
from achse.router.router import Router

_HEAD = struct.Struct("<QBBI")
"""Time in Unix ns, direction, length of the peer's name, length of the AMS packet."""


class Captured(NamedTuple):
    """One AMS packet on its way."""

    time_ns: int
    """Unix time."""
    inwards: bool
    """True for a request, False for an answer or a notification."""
    peer: str
    """The client's end of the connection, or its AMS address inside one process."""
    packet: bytes
    """The AMS packet, without the AMS/TCP header."""

    @property
    def frame(self) -> Frame:
        """The packet decoded; raises DecodeError."""
        return Frame.decode(self.packet)


def encode_batch(captures: Iterable[Captured]) -> bytes:
    """Return the bytes of several captures, one behind the other."""
    parts: list[bytes] = []
    for time_ns, inwards, peer, packet in captures:
        name = peer.encode()[:255]
        parts += (_HEAD.pack(time_ns, inwards, len(name), len(packet)), name, packet)
    return b"".join(parts)


def decode_batch(data: bytes) -> Iterator[Captured]:
    """Yield the captures in `data`; raises DecodeError where they end in the middle."""
    position = 0
    while position < len(data):
        try:
            time_ns, inwards, name_length, length = _HEAD.unpack_from(data, position)
        except struct.error:
            raise DecodeError(f"a capture of {len(data)} bytes ends inside a header") from None
        start = position + _HEAD.size + name_length
        position = start + length
        if position > len(data):
            raise DecodeError(f"a capture lacks {position - len(data)} bytes")
        peer = data[start - name_length : start].decode("utf-8", "replace")
        yield Captured(time_ns, bool(inwards), peer, data[start:position])


class Taps:
    """The taps of `router`: one watcher and one store for all of them.

    Each frame is kept once, however many taps are open, until every tap has fetched it; of more
    than `limit` bytes the oldest are lost. At most `most` taps are open at a time. Requests for the
    AMS port `spared` and their answers, those of the readers, are left out. `clock` gives Unix ns.
    Without an open tap no frame is captured.
    """

    def __init__(
        self,
        router: Router,
        clock: Callable[[], int],
        *,
        spared: int | None = None,
        limit: int = 1 << 24,
        most: int = 32,
    ) -> None:
        self.limit = limit
        self.most = most
        self._router = router
        self._clock = clock
        self._spared = None if spared is None else spared.to_bytes(2, "little")
        self._open: dict[Tap, None] = {}
        self._captures: deque[Captured] = deque()
        self._first = 0
        """Number of the oldest that is kept; they count up from the first frame on."""
        self.size = 0
        """Bytes that are kept, as they travel."""

    def __len__(self) -> int:
        return len(self._open)

    def open(self) -> "Tap":
        """Return a tap that sees all frames from now on. Raises RouterError 0x508 if `most` are
        open."""
        if len(self._open) >= self.most:
            raise RouterError(ReturnCode.ROUTER_NO_MORE_QUEUES, f"{self.most} taps are open")
        tap = Tap(self, self._first + len(self._captures))
        self._open[tap] = None
        self._router.put_watcher(self._watch)
        return tap

    def close(self, tap: "Tap") -> None:
        """End a tap and drop its captures. Unknown is not an error."""
        self._open.pop(tap, None)
        if not self._open:
            self._router.put_watcher(None)
        self._forget_fetched()

    def take(self, tap: "Tap", size: int) -> list[Captured]:
        """See `Tap.take`."""
        if tap not in self._open:
            return []
        if tap.next < self._first:
            tap.lost_captures += self._first - tap.next
            tap.next = self._first
        captures: list[Captured] = []
        for capture in islice(self._captures, tap.next - self._first, None):
            size -= _size(capture)
            if size < 0:
                if captures:
                    break
                tap.lost_captures += 1
                tap.next += 1
                break
            captures.append(capture)
        tap.next += len(captures)
        self._forget_fetched()
        return captures

    def _forget_fetched(self) -> None:
        newest = self._first + len(self._captures)
        wanted = min((tap.next for tap in self._open), default=newest)
        while self._first < wanted:
            self._drop()

    def _drop(self) -> None:
        self.size -= _size(self._captures.popleft())
        self._first += 1

    def _watch(self, frame: Frame) -> None:
        outwards = bool(frame.flags & 1) or frame.command == Command.NOTIFICATION
        device, client = (frame.source, frame.target) if outwards else (frame.target, frame.source)
        if device[6:] == self._spared:
            return
        way = frame.via if outwards else frame.origin
        peer: str = getattr(way, "peer", "") or str(AmsAddress(client))
        capture = Captured(self._clock(), not outwards, peer, frame.encode())
        self._captures.append(capture)
        self.size += _size(capture)
        while self.size > self.limit:
            self._drop()


class Tap:
    """Reader of the frames that pass a router; `Taps.open` makes it."""

    def __init__(self, taps: Taps, begin: int) -> None:
        self._taps = taps
        self.next = begin
        """Number of the frame that it gets next."""
        self.lost_captures = 0
        """Captures that were dropped because the reader was late."""

    def take(self, size: int) -> list[Captured]:
        """Return the oldest captures, up to `size` bytes of them; one that never fits is lost."""
        return self._taps.take(self, size)

    def close(self) -> None:
        """End, and drop the captures that were not fetched."""
        self._taps.close(self)


def _size(capture: Captured) -> int:
    return _HEAD.size + len(capture.peer.encode()[:255]) + len(capture.packet)
