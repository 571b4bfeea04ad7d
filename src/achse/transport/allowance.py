"""How many answers a host gets: an amount at once, and so many a second after that."""

from collections import OrderedDict
from collections.abc import Callable

__all__ = ["Allowance"]

_REMEMBERED = 4096
"""Hosts; the one that was not heard for the longest time is forgotten."""


class Allowance:
    """An amount for each host: `at_once`, refilled by `per_second`; `now()` is in seconds."""

    def __init__(self, now: Callable[[], float], *, at_once: float, per_second: float) -> None:
        self._now = now
        self._at_once = at_once
        self._per_second = per_second
        self._left: OrderedDict[str, tuple[float, float]] = OrderedDict()
        """Host: what was left, and when."""

    def take(self, host: str) -> bool:
        """Take 1 of what is left for a host; False if nothing is."""
        now = self._now()
        left, since = self._left.get(host, (self._at_once, now))
        left = min(left + (now - since) * self._per_second, self._at_once)
        enough = left >= 1
        self._left[host] = (left - enough, now)
        self._left.move_to_end(host)
        if len(self._left) > _REMEMBERED:
            self._left.popitem(last=False)
        return enough
