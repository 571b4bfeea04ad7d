"""Who sends by one connection, and how much each sender asked for."""

from collections.abc import Iterator

__all__ = ["MOST_SENDERS", "SenderFigures", "Senders"]

MOST_SENDERS = 1024
"""More source addresses than this on one connection are not one client; the oldest is forgotten."""


class SenderFigures:
    """The figures of one AMS address."""

    __slots__ = ("errors", "requests")

    def __init__(self) -> None:
        self.requests = 0
        """Requests that came from there."""
        self.errors = 0
        """Answers to it with an error in the AMS header or as their result, denied ones too."""


class Senders:
    """The senders of a connection by their AMS addresses, in the order in which they came."""

    def __init__(self) -> None:
        self._known: dict[bytes, SenderFigures] = {}
        self.speaking = SenderFigures()
        """The sender of what came last: what it asks is counted there."""

    def __bool__(self) -> bool:
        return bool(self._known)

    def __contains__(self, source: object) -> bool:
        return source in self._known

    def __iter__(self) -> Iterator[bytes]:
        return iter(self._known)

    def __getitem__(self, source: bytes) -> SenderFigures:
        return self._known[source]

    def turn_to(self, source: bytes) -> bytes | None:
        """From now on `source` speaks; the sender that is forgotten for it, if there are many."""
        known = self._known.get(source)
        if known is None:
            known = self._known[source] = SenderFigures()
        self.speaking = known
        if len(self._known) <= MOST_SENDERS:
            return None
        oldest = next(iter(self._known))
        del self._known[oldest]
        return oldest

    def refused(self, source: bytes) -> None:
        """`source` got an error for an answer. Unknown is not an error."""
        known = self._known.get(source)
        if known is not None:
            known.errors += 1

    def clear(self) -> None:
        """Forget all: the connection has ended."""
        self._known.clear()
