"""Known frames that come alone: written at once, by the shortest way.

A program that polls sends one request and waits. Its request, and the answer to it, are a portion
each of which the first 34 bytes are known, so all that could differ is compared here: nothing is
searched, and no turn of the loop is waited for. What does not fit goes the way of `requests` and
`answers`.

While many requests are under way on the connection of the target they are gathered for a turn
instead: one call of the system then writes those of many clients.
"""

import struct
from typing import TYPE_CHECKING

from achse.ams import Command
from achse.ams.frame import AMS_HEADER, TCP_HEADER
from achse.router.forwarding.ledger import RELEASING_WRITES, holds_nothing

if TYPE_CHECKING:
    from achse.router.forwarding.pending import PendingExchange
    from achse.transport.connections.known.requests import KnownWay
    from achse.transport.connections.peer import Peer

__all__ = [
    "HEADERS_SIZE",
    "HEAD_SIZE",
    "MOST_HEADS",
    "PORTION",
    "SMALL_PORTION",
    "SingleAnswer",
    "SingleRequest",
]

HEAD_SIZE = TCP_HEADER.size + AMS_HEADER.size - 4
"""Bytes of a frame before its invoke id."""

HEADERS_SIZE = TCP_HEADER.size + AMS_HEADER.size

MOST_HEADS = 1024
"""Different heads of one connection that are noted; then it begins again."""

PORTION = 1 << 14
"""Bytes that are forwarded before others have their turn."""

SMALL_PORTION = 1 << 13
"""Bytes that are forwarded without a look at the time; what they became is written at once."""

_FEW = 4
"""Requests under way up to which one more is written at once."""

_ID_GROUP_AND_LENGTH = struct.Struct("<II4xI")
_ID_AND_RESULT = struct.Struct("<II")

_READ, _WRITE = int(Command.READ), int(Command.WRITE)


class SingleRequest:
    """Requests of one head."""

    __slots__ = (
        "_changes", "_clients", "_command", "_exchange", "_far", "_head", "_length", "_near",
        "_router", "_source", "_table", "_time", "_uplink", "_weight",
    )  # fmt: skip

    def __init__(
        self, near: "Peer", way: "KnownWay", head: bytes, length: int, command: int
    ) -> None:
        self._near, self._far = near, way.far
        self._router = near.router
        self._changes = near.router.changes
        self._exchange = way.exchange
        self._source = way.exchange.session.source
        self._uplink = way.uplink
        self._clients = near.router.asking
        self._table = way.forwarding.requests
        self._time = near.owner.loop.time
        self._head = head
        self._length = length
        self._command = command
        self._weight = 12 if command == _READ else length - HEADERS_SIZE

    def pass_on(self, data: bytes) -> bool:
        """Forward the request that is all of `data`; False if it has to be looked at."""
        near, far, command = self._near, self._far, self._command
        if (
            len(data) != self._length
            or self._router.changes != self._changes
            or not self._exchange.live
            or near.last_source != self._source
            or near.lies
            or near.rights.limited
            or not far.connected
            or (far.unread and far.congested)
        ):
            return False
        invoke_id, group, weight = _ID_GROUP_AND_LENGTH.unpack_from(data, HEAD_SIZE)
        if command == _WRITE:
            if group in RELEASING_WRITES:
                return False
            weight = self._weight
        elif command == _READ or holds_nothing(group, data, HEADERS_SIZE, self._length):
            weight += self._weight
        else:
            return False
        table = self._table
        now = self._time()
        few = table.different < _FEW
        if not table.enter(self._exchange, invoke_id, command, weight, int(now * 1e9)):
            return False
        figures = self._clients.known.get(self._source)
        if figures is None:
            self._clients.asked(self._source)
        else:
            figures.requests += 1
        self._uplink.last_request = now
        if few:
            far.write(self._head + data[HEAD_SIZE:])
        else:
            far.put((self._head, data[HEAD_SIZE:]), self._length)
        return True


class SingleAnswer:
    """Answers or notifications of one head."""

    __slots__ = (
        "_changes", "_exchange", "_far", "_forwarding", "_head", "_length", "_near",
        "_notification", "_router", "_source", "_table", "_target",
    )  # fmt: skip

    def __init__(
        self,
        far: "Peer",
        near: "Peer",
        exchange: "PendingExchange",
        head: bytes,
        length: int,
        notification: bool,
    ) -> None:
        assert far.forwarding is not None
        self._far, self._near = far, near
        self._router = far.router
        self._changes = far.router.changes
        self._forwarding = far.forwarding
        self._table = far.forwarding.requests
        self._exchange = exchange
        self._source, self._target = exchange.session.source, exchange.target
        self._head = head
        self._length = length
        self._notification = notification

    def pass_on(self, data: bytes) -> bool:
        """Pass on the frame that is all of `data`; False if it has to be looked at."""
        far, near, exchange = self._far, self._near, self._exchange
        if (
            len(data) != self._length
            or self._router.changes != self._changes
            or not exchange.live
            or far.last_source != self._target
            or far.lies
            or not near.connected
        ):
            return False
        if self._notification:
            self._forwarding.returned += 1
            near.write_notification(self._head + data[HEAD_SIZE:])
            return True
        invoke_id, result = _ID_AND_RESULT.unpack_from(data, HEAD_SIZE)
        request = self._table.settle(exchange, invoke_id)
        if request is None:
            return False
        self._forwarding.returned_one(request)
        if result:
            self._router.asking.refused(self._source)
        near.write(self._head + data[HEAD_SIZE:])
        return True
