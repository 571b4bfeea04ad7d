"""Handshakes under way on a secure listener: how many there may be, and whose turn it is.

A handshake takes milliseconds of arithmetic, and any client may begin one. They take a quarter of
the time at most, hosts in turns, a step at a time; what the others do goes on between two steps.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Protocol

SHARE = 0.25
"""Of the time, for all handshakes together."""

_AT_ONCE, _PER_HOST = 256, 32
"""Highest number of unauthenticated clients; a further one replaces the oldest."""


class ShakingClient(Protocol):
    """A client that is not authenticated yet."""

    host: str

    def shake(self, data: bytes) -> None:
        """Take what came from it."""
        ...

    def close(self) -> None:
        """End."""
        ...

    def give_way(self) -> bool:
        """End in favour of newer ones; return False if it is being decided just now."""
        ...


class Handshakes:
    """Handshakes under way; `later(seconds, function)` calls a function after so many seconds."""

    def __init__(
        self,
        later: Callable[[float, Callable[[], None]], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._later = later
        self._clock = clock
        self._under_way: dict[str, dict[ShakingClient, bytearray]] = {}
        """By host, the oldest first: what came from each and waits."""
        self._waiting: dict[str, deque[ShakingClient]] = {}
        """By host, the next host first: whose bytes wait."""
        self._free_at = 0.0
        self._due = False
        self.ended = 0
        """Number of handshakes that were closed to make room for others."""

    def __len__(self) -> int:
        return sum(map(len, self._under_way.values()))

    def __iter__(self) -> Iterator[ShakingClient]:
        return iter([each for mine in self._under_way.values() for each in mine])

    def __contains__(self, handshake: ShakingClient) -> bool:
        return handshake in self._under_way.get(handshake.host, ())

    def begin(self, handshake: ShakingClient) -> bool:
        """Add a handshake; return False if no other can make room for it."""
        mine = self._under_way.get(handshake.host, {})
        if len(mine) >= _PER_HOST:
            crowded = mine
        elif len(self) >= _AT_ONCE:
            crowded = max(self._under_way.values(), key=len)
        else:
            crowded = {}
        if crowded:
            oldest = next((each for each in list(crowded) if each.give_way()), None)
            if oldest is None:
                return False
            self.ended += 1
            self.end(oldest)
        self._under_way.setdefault(handshake.host, {})[handshake] = bytearray()
        return True

    def end(self, handshake: ShakingClient) -> bytes:
        """Remove an ended handshake; return its unprocessed bytes."""
        mine = self._under_way.get(handshake.host, {})
        rest = bytes(mine.pop(handshake, b""))
        if not mine:
            self._under_way.pop(handshake.host, None)
        return rest

    def put(self, handshake: ShakingClient, data: bytes) -> int:
        """Return bytes came from it: its turn is now, or it waits; how many of its bytes do."""
        mine = self._under_way.get(handshake.host, {})
        if handshake not in mine:
            return 0
        waits = bool(mine[handshake])
        mine[handshake] += data
        if not waits:
            self._waiting.setdefault(handshake.host, deque()).append(handshake)
            if not self._due:
                self._go_on()
        return len(mine.get(handshake, b""))

    def _go_on(self) -> None:
        """Take turns as long as there is time for it."""
        self._due = False
        while self._waiting:
            now = self._clock()
            if now < self._free_at:
                self._due = True
                self._later(self._free_at - now, self._go_on)
                return
            self._one()
            took = self._clock() - now
            self._free_at = now + took / SHARE

    def _one(self) -> None:
        host, queue = next(iter(self._waiting.items()))
        handshake = queue.popleft()
        del self._waiting[host]
        if queue:
            self._waiting[host] = queue  # behind the others
        mine = self._under_way.get(host, {})
        if handshake in mine:
            data, mine[handshake] = bytes(mine[handshake]), bytearray()
            handshake.shake(data)
