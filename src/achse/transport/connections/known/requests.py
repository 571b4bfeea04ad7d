"""Requests of known clients to known targets: forwarded without decoding.

The first 34 bytes of a request, up to its invoke id, are the same for all requests of one client to
one target with the same command and length. The alias of the client is entered there once.
Requests of one length that follow each other in a portion are taken apart together. Whatever may
change what a client holds at a target, needs a right, or has to be refused is left for decoding.

Source: 000 §3.2, the headers of AMS/TCP; requests of Read, Write and ReadWrite.
"""

import struct
from functools import lru_cache
from itertools import takewhile
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from achse.ams import Command, Flags
from achse.ams.commands import READ, READ_WRITE
from achse.router.forwarding.pending import PendingExchange, PendingRequest
from achse.router.forwarding.resource_requests import (
    CHANGING,
    RELEASING_WRITES,
    holds_nothing,
    is_always_decoded,
)
from achse.transport.connections.known.heads import KnownHeads
from achse.transport.connections.known.single import (
    HEAD_SIZE,
    HEADERS_SIZE,
    PORTION,
    SMALL_PORTION,
    PassOn,
    single_request,
)  # fmt: skip

if TYPE_CHECKING:
    from achse.router.forwarding import Forwarding
    from achse.transport.connections.peer import Peer

RUN = 4
"""Frames of one head that are worth to be taken apart together."""

_MOST_IN_PORTION = PORTION // HEADERS_SIZE + 1

_READ, _WRITE = int(Command.READ), int(Command.WRITE)

_SMALLEST = {
    _READ: READ.size,
    _WRITE: READ.size,
    int(Command.READ_WRITE): READ_WRITE.size,
}
"""Bytes of data that a request has at least."""

_REQUEST = int(Flags.ADS_COMMAND)

_ID_AND_LENGTH = struct.Struct("<I8xI")
_ID_AND_GROUP = struct.Struct("<II")
_ID_GROUP_AND_LENGTH = struct.Struct("<II4xI")


class _Uplink(Protocol):
    """The way along a route."""

    def way_for_known(self, client: "Peer") -> "Peer | None":
        """Return the far end of its connection if any request of `client` may go there now."""
        ...

    last_request: float
    """Time at which a request has gone by this way, s."""


class KnownWay(NamedTuple):
    """Destination of the requests of one client to one target."""

    exchange: PendingExchange
    uplink: _Uplink
    far: "Peer"
    forwarding: "Forwarding"


_Records = dict[int, PendingRequest]
"""Requests of a portion with the same command, by their bytes."""

_Known = tuple[KnownWay, bytes, int, int]
"""KnownWay, head with the alias, length of the frame and command."""


@lru_cache(256)
def _run_of(length: int) -> tuple[struct.Struct, struct.Struct]:
    """Layouts of frames of a length: head and the rest; invoke id and length to read."""
    rest = length - HEAD_SIZE
    return struct.Struct(f"<{HEAD_SIZE}s{rest}s"), struct.Struct(f"<{HEAD_SIZE}xI8xI{rest - 16}x")


def frames_alike(
    data: bytes, position: int, end: int, layout: struct.Struct
) -> tuple[tuple[bytes, ...], int] | None:
    """Return the rests of frames of one head that follow each other, and the place behind them.

    `layout` is head and rest of one frame. None if a head differs before `RUN` frames.
    """
    stop = position + (end - position) // layout.size * layout.size
    heads, rests = zip(*layout.iter_unpack(data[position:stop]), strict=True)
    first = heads[0]
    if heads.count(first) == len(heads):
        return rests, stop
    count = sum(1 for _ in takewhile(first.__eq__, heads))
    if count < RUN:
        return None
    return rests[:count], position + count * layout.size


class KnownRequests(KnownHeads[_Known]):
    """The requests of one connection that are forwarded without decoding."""

    def __init__(self, near: "Peer") -> None:
        super().__init__(near)
        self._near = near
        self._ways: dict[bytes, KnownWay] = {}
        """By target and source."""
        self._changes = -1

    def forward(self, data: bytes, position: int) -> int:
        """Forward the known requests at `position`; return the position of what is left.

        Not more than a portion is forwarded at once.
        """
        near = self._near
        changes = near.router.changes
        if changes != self._changes:
            self.clear()
            self._changes = changes
        size = len(data)
        end = min(size, position + PORTION)
        gathered: dict[Peer, None] = {}
        while position < end:
            known = self._known(data, position)
            if known is None or position + known[2] > size:
                break
            way = known[0]
            if way.uplink.way_for_known(near) is not way.far or not way.exchange.live:
                self.clear()
                break
            source = way.exchange.session.source
            if not near.comes_from(source) or near.limited:
                break
            begin = position
            position = self._forward_to(way, data, position, end)
            if position == begin:
                break
            gathered[way.far] = None
        for far in gathered:
            far.flush() if size <= SMALL_PORTION else far.flush_soon()
        return position

    def single(self, data: bytes) -> PassOn | None:
        """Return the function that forwards requests like `data`; None if `data` is not one whole
        request. `data` was forwarded."""
        known = self._heads.get(data[:HEAD_SIZE])
        if known is None or known[2] != len(data):
            return None
        way, head, length, command = known
        return single_request(self._near, way, head, length, command)

    def _forward_to(self, way: KnownWay, data: bytes, position: int, end: int) -> int:
        """Forward requests at `position` as long as all go the same way."""
        heads, exchange, size = self._heads, way.exchange, len(data)
        now = int(self._near.owner.loop.time() * 1e9)
        room = way.forwarding.requests.room(way.exchange.session, now, _MOST_IN_PORTION)
        requests, session = exchange.requests, exchange.session
        parts: list[bytes] = []
        reads: _Records = {}
        writes: _Records = {}
        others: _Records = {}
        begin, count, load = position, 0, 0
        before: _Known | None = None
        together = True
        while position < end:
            rest = position + HEAD_SIZE
            known = heads.get(data[position:rest])
            if known is None:
                known = self._known(data, position)
                if known is None:
                    break
            its_way, head, length, command = known
            stop = position + length
            if stop > size or its_way is not way:
                break
            if known is not before:
                before = known
            elif command == _READ and together and end - position >= RUN * length:
                taken = self._run(known, data, position, end, requests, room - load, now)
                if taken is not None:
                    part, number, weight = taken
                    parts.append(part)
                    position += number * length
                    count += number
                    load += weight
                    continue
                together = False
            if command == _READ:
                invoke_id, weight = _ID_AND_LENGTH.unpack_from(data, rest)
                weight += 12
                records = reads
            elif command == _WRITE:
                invoke_id, group = _ID_AND_GROUP.unpack_from(data, rest)
                if group in RELEASING_WRITES:
                    break
                weight = length - HEADERS_SIZE
                records = writes
            else:
                invoke_id, group, weight = _ID_GROUP_AND_LENGTH.unpack_from(data, rest)
                if group in CHANGING and not holds_nothing(
                    group, data, position + HEADERS_SIZE, stop
                ):
                    break
                weight += length - HEADERS_SIZE
                records = others
            load += weight
            if load > room or invoke_id in requests:
                load -= weight
                break
            record = records.get(weight)
            if record is None:
                record = PendingRequest(session, command, _REQUEST, None, now, weight)
                records[weight] = record
            requests[invoke_id] = record
            parts += (head, data[rest:stop])
            position = stop
            count += 1
        if count:
            way.forwarding.sent(session, count, load, now)
            self._near.router.client_figures.count_requests(session.source, count)
            way.uplink.last_request = now / 1e9
            windows, size = way.forwarding.windows, position - begin
            if not windows.is_open(session.load):
                parts = windows.admit(session.load, b"".join(parts), count, load)
                size = sum(map(len, parts))
            way.far.gather(parts, size)
        return position

    def _run(
        self,
        known: _Known,
        data: bytes,
        position: int,
        end: int,
        requests: dict[int, PendingRequest],
        room: int,
        now: int,
    ) -> tuple[bytes, int, int] | None:
        """Enter reads of one head that follow each other; None if they are not alike.

        Return them with the alias, their number and the bytes of them and their answers.
        """
        way, head, length, command = known
        whole, fields = _run_of(length)
        alike = frames_alike(data, position, end, whole)
        if alike is None:
            return None
        rests, stop = alike
        count = len(rests)
        invoke_ids, lengths = zip(*fields.iter_unpack(data[position:stop]), strict=True)
        weight = 12 + lengths[0]
        if lengths.count(lengths[0]) != count or weight * count > room:
            return None
        record = PendingRequest(way.exchange.session, command, _REQUEST, None, now, weight)
        entered = dict.fromkeys(invoke_ids, record)
        if len(entered) != count or not requests.keys().isdisjoint(entered):
            return None
        requests.update(entered)
        return head + head.join(rests), count, weight * count

    def _learn(
        self, head: bytes, command: int, flags: int, size: int, length: int
    ) -> _Known | None:
        if flags != _REQUEST or size < _SMALLEST.get(command, size + 1):
            return None
        if command == _READ and size != READ.size:
            return None
        if is_always_decoded(command, head[6:14]):
            return None
        way = self._ways.get(head[6:22]) or self._way(head[14:22], head[6:14])
        if way is None:
            return None
        self._ways[head[6:22]] = way
        return way, head[:14] + way.exchange.session.alias + head[22:], length, command

    def _way(self, source: bytes, target: bytes) -> KnownWay | None:
        """Return the way from a client to a target; None before its first request was decoded."""
        near = self._near
        endpoint: Any = near.router.beyond(target)
        find = getattr(endpoint, "way_for_known", None)
        far: Peer | None = None if find is None else find(near)
        forwarding = None if far is None else far.forwarding
        if far is None or forwarding is None:
            return None
        exchange = forwarding.exchange(near, source, target)
        return None if exchange is None else KnownWay(exchange, endpoint, far, forwarding)

    def clear(self) -> None:
        super().clear()
        self._ways.clear()
