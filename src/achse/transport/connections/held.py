"""Bytes that all connections buffer for their peers: one running sum, one limit."""

from typing import Protocol

DEFAULT_MAX_HELD = 256 * 1024 * 1024
"""Bytes; four times the longest packet."""


class Holder(Protocol):
    """Something that keeps bytes for a peer."""

    @property
    def held(self) -> int:
        """Bytes that it keeps now."""
        ...

    def cut(self, reason: str, *details: object) -> None:
        """Keep nothing more: it takes too much room."""
        ...


class Held:
    """Bytes that are kept for peers, by all connections together.

    Each connection tells by `count` when what it keeps has changed; that it has become less may
    come late. Beyond `limit` those with the most are cut off until an eighth of it is free, so that
    the next look at all of them is a long way off.
    """

    def __init__(self, limit: int = DEFAULT_MAX_HELD) -> None:
        self.limit = limit
        self.total = 0
        """The sum, or more."""
        self._of: dict[Holder, int] = {}

    def count(self, holder: Holder, size: int) -> None:
        """`holder` keeps `size` bytes now."""
        before = self._of.pop(holder, 0)
        if size:
            self._of[holder] = size
        self.total += size - before
        if self.total > self.limit:
            self._look()

    def _look(self) -> None:
        """Ask all of them, and cut off the largest if it is too much."""
        self._of = {holder: size for holder in self._of if (size := holder.held)}
        self.total = sum(self._of.values())
        enough = self.limit - self.limit // 8
        for holder in sorted(self._of, key=self._of.__getitem__, reverse=True):
            if self.total <= enough:
                return
            holder.cut("all connections together hold too much, and it the most")
            self.total -= self._of.pop(holder, 0)
