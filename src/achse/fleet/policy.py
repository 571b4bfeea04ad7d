"""Restart policy of the processes of a fleet: number of restarts, and pauses between them."""

_FIRST_PAUSE, _LONGEST_PAUSE = 0.1, 10.0
"""Seconds before a restart; each one within the window doubles the pause."""


class RestartPolicy:
    """Up to `most` restarts within `window_s` seconds, with longer and longer pauses."""

    def __init__(self, most: int, window_s: float) -> None:
        self._most = most
        self._window_s = window_s
        self._ended: list[float] = []
        self.restarts = 0
        """All of them, of whatever time."""

    def ended(self, now_s: float) -> float | None:
        """It has ended at this time; gives the pause before it is started again, s, or None."""
        self._ended = [at for at in self._ended if now_s - at < self._window_s]
        if len(self._ended) >= self._most:
            return None
        self._ended.append(now_s)
        self.restarts += 1
        return min(_FIRST_PAUSE * 2.0 ** (len(self._ended) - 1), _LONGEST_PAUSE)

    def forget(self) -> None:
        """Begin again: a person has ordered a restart."""
        self._ended.clear()
