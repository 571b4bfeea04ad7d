"""Latency of forwarded requests: percentiles from counts, without the samples."""

from bisect import bisect_left

MEASURED = 16
"""The latency of one in so many answers is counted."""

_FIRST_NS = 1_024
"""Upper bound of the first bucket; each further one has a fourth more, up to minutes."""

_BOUNDS = [_FIRST_NS]
while _BOUNDS[-1] < 120_000_000_000:
    _BOUNDS.append(_BOUNDS[-1] * 5 // 4)


class Latencies:
    """Counts of latencies by buckets, each a fourth wider than the one below."""

    def __init__(self) -> None:
        self._counts = [0] * (len(_BOUNDS) + 1)
        self.count = 0

    def add(self, nanoseconds: int, count: int = 1) -> None:
        """Count a latency, that of `count` answers."""
        self._counts[bisect_left(_BOUNDS, nanoseconds)] += count
        self.count += count

    def within_ns(self, share: float) -> int:
        """Return the bound below which this share (0..1) of all latencies is; 0 without any."""
        due = share * self.count
        total = 0
        for bound, count in zip((*_BOUNDS, _BOUNDS[-1]), self._counts, strict=True):
            total += count
            if count and total >= due:
                return bound
        return 0
