"""The outgoing half of a connection, without a socket: what is gathered, and what is held back."""

from collections import deque

_HOLD = 0.01
"""Seconds that notifications wait behind the answer to an Add: pyads and others drop a sample that
comes before they have noted its handle."""


class Outbox:
    """Packets for a peer, until somebody takes them to send. Times in seconds of any clock."""

    __slots__ = ("_chunks", "_until", "gathered", "held_size", "size")

    def __init__(self) -> None:
        self.size = 0
        """Bytes that are gathered: `take` gives them."""
        self.held_size = 0
        """Bytes that are held back: `release` gathers them."""
        self.gathered: list[bytes] = []
        """Packets in order; `put` adds one."""
        self._chunks: deque[tuple[float, bytes]] = deque()
        self._until = 0.0

    def put(self, packet: bytes) -> None:
        """Gather a packet."""
        self.gathered.append(packet)
        self.size += len(packet)

    def added(self, now: float) -> None:
        """The answer to an Add is gathered: notifications wait a moment from `now` on."""
        self._until = now + _HOLD

    def hold(self, packet: bytes, now: float) -> bool:
        """Keep a notification back if an Add was answered a moment ago, or others are kept."""
        if not self.holds(now):
            return False
        self._chunks.append((self._until, packet))
        self.held_size += len(packet)
        return True

    def hold_answer(self, packet: bytes) -> bool:
        """Keep the answer to a Delete behind the notifications that are kept back, if any are: none
        comes after it."""
        if not self._chunks:
            return False
        self._chunks.append((self._chunks[-1][0], packet))
        self.held_size += len(packet)
        return True

    def holds(self, now: float) -> bool:
        """Return True if `hold` would keep a notification back."""
        return bool(self._chunks) or now < self._until

    @property
    def due(self) -> float | None:
        """Time of the next call of `release`; None if no notification is held back."""
        return self._chunks[0][0] if self._chunks else None

    def release(self, now: float) -> None:
        """Gather the notifications that have waited long enough, in order."""
        held = self._chunks
        while held and held[0][0] <= now:
            packet = held.popleft()[1]
            self.held_size -= len(packet)
            self.put(packet)

    def take(self) -> bytes:
        """All that is gathered, as bytes to send."""
        gathered, self.size = self.gathered, 0
        if len(gathered) == 1:
            return gathered.pop()
        data = b"".join(gathered)
        gathered.clear()
        return data

    def clear(self) -> None:
        """Forget all: the peer is gone."""
        self.gathered.clear()
        self._chunks.clear()
        self.size = self.held_size = 0
