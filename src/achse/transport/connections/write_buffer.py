"""Write buffer of a connection, without a socket: gathered packets and delayed notifications."""

from collections import deque

_DELAY = 0.01
"""Delay of notifications behind the answer to an Add, s: pyads and others drop a sample that
arrives before they have stored its handle."""


class WriteBuffer:
    """Buffer of packets for a peer until `take` returns them. Times in seconds of any clock."""

    __slots__ = ("_chunks", "_until", "delayed_size", "gathered", "size")

    def __init__(self) -> None:
        self.size = 0
        """Bytes that are gathered: `take` returns them."""
        self.delayed_size = 0
        """Bytes of delayed packets: `release` gathers them."""
        self.gathered: list[bytes] = []
        """Packets in order; `put` adds one."""
        self._chunks: deque[tuple[float, bytes]] = deque()
        self._until = 0.0

    def put(self, packet: bytes) -> None:
        """Gather a packet."""
        self.gathered.append(packet)
        self.size += len(packet)

    def added(self, now: float) -> None:
        """Delay notifications from `now` on: the answer to an Add is gathered."""
        self._until = now + _DELAY

    def delay(self, packet: bytes, now: float) -> bool:
        """Delay a notification if an Add was answered a moment ago, or others are delayed."""
        if not self.delays(now):
            return False
        self._chunks.append((self._until, packet))
        self.delayed_size += len(packet)
        return True

    def delay_answer(self, packet: bytes) -> bool:
        """Delay the answer to a Delete behind delayed notifications, so that none comes after
        it."""
        if not self._chunks:
            return False
        self._chunks.append((self._chunks[-1][0], packet))
        self.delayed_size += len(packet)
        return True

    def delays(self, now: float) -> bool:
        """Return True if `delay` would delay a notification."""
        return bool(self._chunks) or now < self._until

    @property
    def due(self) -> float | None:
        """Time of the next call of `release`; None if no notification is delayed."""
        return self._chunks[0][0] if self._chunks else None

    def release(self, now: float) -> None:
        """Gather the notifications that have waited long enough, in order."""
        delayed = self._chunks
        while delayed and delayed[0][0] <= now:
            packet = delayed.popleft()[1]
            self.delayed_size -= len(packet)
            self.put(packet)

    def take(self) -> bytes:
        """Remove all gathered packets and return them as bytes."""
        gathered, self.size = self.gathered, 0
        if len(gathered) == 1:
            return gathered.pop()
        data = b"".join(gathered)
        gathered.clear()
        return data

    def clear(self) -> None:
        """Drop all packets."""
        self.gathered.clear()
        self._chunks.clear()
        self.size = self.delayed_size = 0
