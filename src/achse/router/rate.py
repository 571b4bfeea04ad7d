"""Rates: so many per second and some at once, for answers and log lines that clients cause."""

from collections.abc import Hashable

_SECOND = 1_000_000_000


class Rate:
    """Lets `per_second` through, and `at_once` after a pause (twice as many). Times in ns."""

    def __init__(self, per_second: int, at_once: int | None = None) -> None:
        self._full = (2 * per_second if at_once is None else at_once) * _SECOND
        self._per_second = per_second
        self._tokens = self._full
        self._since: int | None = None

    def take(self, now: int) -> bool:
        """Consume one permit at `now`, ns; False if none is left."""
        if self._since is not None and now > self._since:
            self._tokens = min(self._full, self._tokens + (now - self._since) * self._per_second)
        self._since = now
        if self._tokens < _SECOND:
            return False
        self._tokens -= _SECOND
        return True


class Rates:
    """One rate for each key, and one for all keys together.

    At most `most` keys are remembered; the one not seen for longest is forgotten, and begins again.
    """

    def __init__(
        self,
        per_second: int,
        all_per_second: int,
        *,
        at_once: int | None = None,
        all_at_once: int | None = None,
        most: int = 4096,
    ) -> None:
        self._per_second = per_second
        self._at_once = at_once
        self._all = Rate(all_per_second, all_at_once)
        self._most = most
        self._each: dict[Hashable, Rate] = {}

    def take(self, key: Hashable, now: int) -> bool:
        """Consume one permit of `key` at `now`, ns; False if none is left."""
        rate = self._each.pop(key, None) or Rate(self._per_second, self._at_once)
        self._each[key] = rate
        if len(self._each) > self._most:
            del self._each[next(iter(self._each))]
        return rate.take(now) and self._all.take(now)
