"""Bytes that all connections buffer for their peers: one running sum, one limit."""

from typing import Protocol

DEFAULT_SEND_BUDGET = 256 * 1024 * 1024
"""Bytes; four times the longest packet."""


class SendBuffer(Protocol):
    """Buffer of bytes that wait for a peer."""

    @property
    def buffered_bytes(self) -> int:
        """Bytes that wait now."""
        ...

    def cut(self, reason: str, *details: object) -> None:
        """Drop the buffer and its connection: it takes too much memory."""
        ...


class SendBudget:
    """Bytes that wait for peers, in the buffers of all connections.

    Each connection reports its new size by `count`; a smaller size may be reported late. Beyond
    `limit` the largest buffers are cut until an eighth of the limit is free, so that the next look
    at all buffers is far off.
    """

    def __init__(self, limit: int = DEFAULT_SEND_BUDGET) -> None:
        self.limit = limit
        self.total = 0
        """The sum, or more."""
        self._sizes: dict[SendBuffer, int] = {}

    def count(self, buffer: SendBuffer, size: int) -> None:
        """Count a buffer with its new size in bytes."""
        before = self._sizes.pop(buffer, 0)
        if size:
            self._sizes[buffer] = size
        self.total += size - before
        if self.total > self.limit:
            self._cut_largest()

    def _cut_largest(self) -> None:
        """Measure all buffers, and cut the largest if the sum is beyond the limit."""
        self._sizes = {buffer: size for buffer in self._sizes if (size := buffer.buffered_bytes)}
        self.total = sum(self._sizes.values())
        enough = self.limit - self.limit // 8
        for buffer in sorted(self._sizes, key=self._sizes.__getitem__, reverse=True):
            if self.total <= enough:
                return
            buffer.cut("all connections together hold too much, and it the most")
            self.total -= self._sizes.pop(buffer, 0)
