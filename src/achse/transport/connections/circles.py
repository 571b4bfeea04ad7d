"""The log line of requests that go in circles, once in a while."""

import logging

from achse.ams import AmsAddress, Frame

log = logging.getLogger("achse.tcp")

_AGAIN_NS = 10_000_000_000
"""Time until the next line of one connection."""


class CircleWarning:
    """The warning of one connection that two routers send each other the same request."""

    def __init__(self) -> None:
        self._next_ns = 0

    def report(self, request: Frame, peer: str, now_ns: int) -> None:
        """Warn of a request that came by way of `peer`, unless that was done lately."""
        if now_ns < self._next_ns:
            return
        self._next_ns = now_ns + _AGAIN_NS
        log.warning(
            "requests of %s to %s go in circles by way of %s: look at the routes",
            *(AmsAddress(request.source), AmsAddress(request.target), peer),
            extra=request.sender,
        )
