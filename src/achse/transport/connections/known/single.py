"""Known frames that come alone: written at once, by the shortest way.

A program that polls sends one request and waits. Its request, and the answer to it, are a portion
each of which the first 34 bytes are known, so all that could differ is compared here: nothing is
searched, and no turn of the loop is waited for. What does not fit goes the way of `requests` and
`answers`.

While many requests are under way on the connection of the target they are gathered for a turn
instead: one call of the system then writes those of many clients.
"""

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING

from achse.ams import Command, Flags
from achse.ams.frame import AMS_HEADER, TCP_HEADER
from achse.router.forwarding.latency import MEASURED
from achse.router.forwarding.pending import SMALL_REQUEST, PendingRequest
from achse.router.forwarding.resource_requests import RELEASING_WRITES, holds_nothing

if TYPE_CHECKING:
    from achse.router.forwarding.pending import PendingExchange
    from achse.transport.connections.known.requests import KnownWay
    from achse.transport.connections.peer import Peer

HEAD_SIZE = TCP_HEADER.size + AMS_HEADER.size - 4
"""Bytes of a frame before its invoke id."""

HEAD, REST = slice(HEAD_SIZE), slice(HEAD_SIZE, None)
"""Places of these bytes, and of those behind them."""

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

_REQUEST = int(Flags.ADS_COMMAND)

PassOn = Callable[[bytes], bool]
"""Passes on the frame that is all of the data; False if it has to be looked at."""


def single_request(near: "Peer", way: "KnownWay", head: bytes, length: int, command: int) -> PassOn:
    """Return the function that forwards requests of one head.

    What stays as long as `router.changes` and `exchange.live` do is bound here.
    """
    router, far = near.router, way.far
    changes, limited = router.changes, near.rights.limited
    exchange, uplink = way.exchange, way.uplink
    session, requests = exchange.session, exchange.requests
    source, load = session.source, session.load
    table, clients = way.forwarding.requests, router.client_figures
    figures = clients.figures(source)
    time, unpack = near.owner.loop.time, _ID_GROUP_AND_LENGTH.unpack_from
    is_read, is_write = command == _READ, command == _WRITE
    fixed = 12 if is_read else length - HEADERS_SIZE
    alone = PendingRequest(session, command, _REQUEST, None, 0, 0)
    out, write = far.write_buffer, far.direct_write

    def pass_on(data: bytes) -> bool:
        if (
            len(data) != length
            or router.changes != changes
            or not exchange.live
            or near.last_source != source
            or limited
            or far.unread
        ):
            return False
        invoke_id, group, weight = unpack(data, HEAD_SIZE)
        if is_read:
            weight += fixed
        elif is_write:
            if group in RELEASING_WRITES:
                return False
            weight = fixed
        elif holds_nothing(group, data, HEADERS_SIZE, length):
            weight += fixed
        else:
            return False
        now = time()
        if requests or load.count or table.different >= _FEW or out.size or weight > SMALL_REQUEST:
            few = table.different < _FEW
            if not table.enter(exchange, invoke_id, command, weight, int(now * 1e9)):
                return False
            if few:
                far.write(head + data[REST])
            else:
                far.put((head, data[REST]), length)
        else:
            requests[invoke_id] = alone
            alone.time = load.time = int(now * 1e9)
            alone.size = load.size = weight
            load.count = 1
            table.size += weight
            table.different += 1
            write(head + data[REST])
        if figures.forgotten:
            clients.count_requests(source)
        else:
            figures.requests += 1
        uplink.last_request = now
        return True

    return pass_on


def single_answer(
    far: "Peer",
    near: "Peer",
    exchange: "PendingExchange",
    head: bytes,
    length: int,
    notification: bool,
) -> PassOn:
    """Return the function that passes on answers or notifications of one head."""
    router, forwarding = far.router, far.forwarding
    assert forwarding is not None
    changes, table = router.changes, forwarding.requests
    session, requests, further = exchange.session, exchange.requests, exchange.further
    source, target, load = session.source, exchange.target, session.load
    unpack, get = _ID_AND_RESULT.unpack_from, requests.get
    out, write = near.write_buffer, near.direct_write

    def pass_on(data: bytes) -> bool:
        if (
            len(data) != length
            or router.changes != changes
            or not exchange.live
            or far.last_source != target
        ):
            return False
        if notification:
            forwarding.returned += 1
            near.write_notification(head + data[REST])
            return True
        invoke_id, result = unpack(data, HEAD_SIZE)
        request = get(invoke_id)
        if request is None or request.change is not None or further:
            return False
        del requests[invoke_id]
        table.different -= 1
        if load.count == 1 and not load.waiting:
            table.size -= load.size
            load.count = load.size = 0
        else:
            table.answered(request, 1, request.size)
        forwarding.returned = returned = forwarding.returned + 1
        if not returned % MEASURED:
            forwarding.measure(request)
        if not session.listed:
            forwarding.rest(session)
        if result:
            router.client_figures.count_error(source)
        if out.size or near.unread:
            near.write(head + data[REST])
        else:
            write(head + data[REST])
        return True

    return pass_on
