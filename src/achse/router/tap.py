"""A tap: what passes a router, kept for somebody who fetches it, and the bytes it travels as."""

import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from achse.ams import AmsAddress, Command, DecodeError, Frame
from achse.router.router import Router

__all__ = ["Captured", "Tap", "decode_batch", "encode_batch"]

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
    """The bytes of several captures, one behind the other."""
    parts: list[bytes] = []
    for time_ns, inwards, peer, packet in captures:
        name = peer.encode()[:255]
        parts += (_HEAD.pack(time_ns, inwards, len(name), len(packet)), name, packet)
    return b"".join(parts)


def decode_batch(data: bytes) -> Iterator[Captured]:
    """The captures in `data`; raises DecodeError where they end in the middle."""
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


class Tap:
    """Keeps every frame that passes `router`, up to `limit` bytes; the oldest are lost then.

    Requests for the AMS port `spared` and their answers are left out: those who fetch. `clock`
    gives Unix ns. Nothing is in the way of the frames before `open` and after `close`.
    """

    def __init__(
        self,
        router: Router,
        clock: Callable[[], int],
        *,
        spared: int | None = None,
        limit: int = 1 << 24,
    ) -> None:
        self._router = router
        self._clock = clock
        self._spared = None if spared is None else spared.to_bytes(2, "little")
        self._limit = limit
        self._kept: deque[Captured] = deque()
        self._size = 0
        self.lost = 0
        """Captures that were dropped because nobody fetched them."""

    def open(self) -> None:
        """Begin."""
        self._router.add_gate(self._gate, outermost=True)

    def close(self) -> None:
        """End; what was not fetched is gone."""
        self._router.remove_gate(self._gate)
        self._kept.clear()
        self._size = 0

    def take(self, size: int) -> list[Captured]:
        """The oldest captures, up to `size` bytes of them; one that never fits is lost."""
        taken: list[Captured] = []
        left = size
        while self._kept and (left >= _size(self._kept[0]) or not taken):
            capture = self._kept.popleft()
            self._size -= _size(capture)
            left -= _size(capture)
            if left < 0:
                self.lost += 1
                break
            taken.append(capture)
        return taken

    def _gate(self, frame: Frame, onward: Callable[[Frame], bool]) -> bool:
        outwards = bool(frame.flags & 1) or frame.command == Command.NOTIFICATION
        device, client = (frame.source, frame.target) if outwards else (frame.target, frame.source)
        if device[6:] != self._spared:
            way = frame.via if outwards else frame.origin
            peer: str = getattr(way, "peer", "") or str(AmsAddress(client))
            self._keep(Captured(self._clock(), not outwards, peer, frame.encode()))
        return onward(frame)

    def _keep(self, capture: Captured) -> None:
        self._kept.append(capture)
        self._size += _size(capture)
        while self._size > self._limit:
            self._size -= _size(self._kept.popleft())
            self.lost += 1


def _size(capture: Captured) -> int:
    return _HEAD.size + len(capture.peer.encode()[:255]) + len(capture.packet)
