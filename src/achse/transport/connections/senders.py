"""Senders of one connection."""

from collections.abc import Iterator

MOST_SENDERS = 1024
"""More source addresses than this on one connection are not one client; the oldest is forgotten."""


class Senders:
    """The senders of a connection by their AMS addresses, in the order in which they came."""

    def __init__(self) -> None:
        self._addresses: dict[bytes, None] = {}

    def __bool__(self) -> bool:
        return bool(self._addresses)

    def __contains__(self, source: object) -> bool:
        return source in self._addresses

    def __iter__(self) -> Iterator[bytes]:
        return iter(self._addresses)

    def add(self, source: bytes) -> bytes | None:
        """`source` sends; the sender that is forgotten for it, if there are many."""
        self._addresses[source] = None
        if len(self._addresses) <= MOST_SENDERS:
            return None
        oldest = next(iter(self._addresses))
        del self._addresses[oldest]
        return oldest

    def clear(self) -> None:
        """Forget all: the connection has ended."""
        self._addresses.clear()
