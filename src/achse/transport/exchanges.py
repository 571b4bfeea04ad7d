"""Exchanges: requests that were passed on to the far end of a connection, and who asked.

Clients may share one AMS address (two processes behind one host do): what comes back goes to the
one who asked. AMS has no hop count; what is unanswered tells that a request goes in circles.
"""

from collections import deque

from achse.ams import Endpoint, Frame
from achse.codes import ReturnCode

__all__ = ["Exchanges"]

_REMEMBERED = 1 << 14
"""Requests that may be unanswered, and clients that were answered; the oldest is forgotten."""

_ROUNDS = 2
"""The same request came from the same side this often, unanswered: the next one is a circle. Two
clients behind one router may share an address and send equal requests at a time."""

_ASKERS = 16
"""The same for one that comes from any side: clients with one address on that many connections."""

_ROUND_NS = 1_000_000_000
"""A client that asks the same again after this time has given up waiting; a circle is faster."""


class Exchanges:
    """What one peer was asked, and has answered, on behalf of others."""

    def __init__(self) -> None:
        self._asked: dict[tuple[bytes, bytes, int], deque[tuple[Endpoint, int]]] = {}
        self._answered: dict[tuple[bytes, bytes], Endpoint] = {}

    def ask(
        self, asker: Endpoint, request: Frame, now: int, *, circles: bool = True
    ) -> ReturnCode | None:
        """Remember who asks, at `now` (ns). What refuses the request, None if it may go.

        0x7 if it goes in circles, 0x502 if so many are unanswered that this could not be told;
        neither where it cannot circle.
        """
        key = (request.source, request.target, request.invoke_id)
        askers = self._asked.get(key)
        if askers is None:
            if len(self._asked) >= _REMEMBERED:
                oldest, waiting = next(iter(self._asked.items()))
                if circles and now - waiting[0][1] < _ROUND_NS:
                    return ReturnCode.ROUTER_MAILBOX_FULL
                del self._asked[oldest]
            self._asked[key] = deque(((asker, now),), _REMEMBERED)
            return None
        lately = [each for each, time in askers if now - time < _ROUND_NS] if circles else []
        if len(lately) >= _ASKERS or lately.count(asker) >= _ROUNDS:
            return ReturnCode.TARGET_MACHINE_NOT_FOUND
        askers.append((asker, now))
        return None

    def take(self, response: Frame) -> Endpoint | None:
        """Who wants this response, or else who was ever answered by that server."""
        exchange = (response.target, response.source)
        key = (*exchange, response.invoke_id)
        askers = self._asked.get(key)
        if askers is None:
            return self._answered.get(exchange)
        asker, _ = askers.popleft()
        if not askers:
            del self._asked[key]
        if not response.error:
            self._answered.pop(exchange, None)
            self._answered[exchange] = asker
            if len(self._answered) > _REMEMBERED:
                del self._answered[next(iter(self._answered))]
        return asker

    def answered(self, frame: Frame) -> Endpoint | None:
        """Who was answered by the sender of this notification."""
        return self._answered.get((frame.target, frame.source))

    def clear(self) -> None:
        """Forget all: the peer is gone."""
        self._asked.clear()
        self._answered.clear()
