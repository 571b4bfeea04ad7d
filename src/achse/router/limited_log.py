"""Warnings that strangers can cause: so many a second, and how many were left out."""

import logging
from collections.abc import Callable, Hashable, Mapping

from achse.router.rate import Rates


class LimitedLog:
    """Warnings of `log`: one a second for each client (3 at once), 5 for all (20 at once).

    The next warning says how many were left out before it. `clock` returns ns.
    """

    def __init__(self, log: logging.Logger, clock: Callable[[], int]) -> None:
        self._log = log
        self._clock = clock
        self._rates = Rates(1, 5, at_once=3, all_at_once=20)
        self._left_out = 0

    def warning(
        self, client: Hashable, text: str, *details: object, extra: Mapping[str, str] | None = None
    ) -> None:
        """Log a warning that `client` caused, unless there were too many."""
        if not self._rates.take(client, self._clock()):
            self._left_out += 1
            return
        if self._left_out:
            text, details = f"{text} (%d more left out)", (*details, self._left_out)
            self._left_out = 0
        self._log.warning(text, *details, extra=extra)
