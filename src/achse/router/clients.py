"""Clients of a router over all connections, with the number of their requests and errors."""

import heapq
from collections.abc import Iterator

MOST_CLIENTS = 4096
"""Addresses that are counted; for one more the one that came first is forgotten."""

LISTED_CLIENTS = 200
"""Clients that figures list: those with the most requests."""


class ClientFigures:
    """The figures of one AMS address."""

    __slots__ = ("errors", "forgotten", "requests")

    def __init__(self) -> None:
        self.requests = 0
        """Requests that came from there."""
        self.errors = 0
        """Answers to it with an error in the AMS header or as their result, denied ones too."""
        self.forgotten = False
        """True once they count no more."""


class Clients:
    """The clients of a router by their AMS addresses, in the order in which they came."""

    def __init__(self) -> None:
        self.by_source: dict[bytes, ClientFigures] = {}
        """Figures by address."""

    def __len__(self) -> int:
        return len(self.by_source)

    def __iter__(self) -> Iterator[bytes]:
        return iter(self.by_source)

    def __contains__(self, source: object) -> bool:
        return source in self.by_source

    def get(self, source: bytes) -> ClientFigures | None:
        """Return the figures of a client; None if it is unknown."""
        return self.by_source.get(source)

    def __getitem__(self, source: bytes) -> ClientFigures:
        return self.by_source[source]

    def busiest(self, most: int = LISTED_CLIENTS) -> list[bytes]:
        """Return the clients with the most requests, those first."""
        return heapq.nlargest(most, self.by_source, key=lambda each: self.by_source[each].requests)

    def figures(self, source: bytes) -> ClientFigures:
        """Return the figures to which requests of `source` are added."""
        known = self.by_source.get(source)
        if known is None:
            known = self.by_source[source] = ClientFigures()
            if len(self.by_source) > MOST_CLIENTS:
                self.forget(next(iter(self.by_source)))
        return known

    def count_requests(self, source: bytes, count: int = 1) -> None:
        """Add `count` requests of `source`."""
        self.figures(source).requests += count

    def count_error(self, source: bytes) -> None:
        """Add one error answer to `source`, if it is known."""
        known = self.by_source.get(source)
        if known is not None:
            known.errors += 1

    def forget(self, source: bytes) -> None:
        """Remove the figures of `source`, if it is known."""
        known = self.by_source.pop(source, None)
        if known is not None:
            known.forgotten = True
