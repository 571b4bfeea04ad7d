"""Answers and notifications for known clients: passed on without decoding.

They are the counterpart of `requests`: the first 34 bytes of an answer are the same for all
answers of one target to one client with the same command and length. Answers that give out or
release what a client holds, errors of the AMS header, and what comes for a client that is gone are
left for decoding.

Source: 000 §3.2, the headers of AMS/TCP; answers of Read, Write and ReadWrite; notifications.
"""

import struct
from collections import deque
from functools import lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, cast

from achse.ams import Command, Flags
from achse.router.forwarding.pending import PendingExchange, PendingRequest
from achse.transport.connections.known.heads import KnownHeads
from achse.transport.connections.known.requests import RUN, frames_alike
from achse.transport.connections.known.single import (
    HEAD_SIZE,
    PORTION,
    SMALL_PORTION,
    PassOn,
    single_answer,
)  # fmt: skip

if TYPE_CHECKING:
    from achse.router.forwarding import Forwarding
    from achse.transport.connections.peer import Peer

_NOTIFICATION = int(Command.NOTIFICATION)

_ANSWERED = (int(Command.READ), int(Command.WRITE), int(Command.READ_WRITE))

_ANSWER, _NOTICE = int(Flags.ADS_COMMAND | Flags.RESPONSE), int(Flags.ADS_COMMAND)

_size = attrgetter("size")

_ID_AND_RESULT = struct.Struct("<II")

_Known = tuple[PendingExchange, "Peer", bytes, int, bool]
"""Exchange, connection of the client, head with its address, length, True for notifications."""


@lru_cache(256)
def _run_of(length: int) -> tuple[struct.Struct, struct.Struct]:
    """Layouts of frames of a length: head and the rest; invoke id and result."""
    rest = length - HEAD_SIZE
    return struct.Struct(f"<{HEAD_SIZE}s{rest}s"), struct.Struct(f"<{HEAD_SIZE}xII{rest - 8}x")


class KnownAnswers(KnownHeads[_Known]):
    """The answers and notifications of one connection that are passed on without decoding."""

    def __init__(self, far: "Peer", forwarding: "Forwarding") -> None:
        super().__init__(far)
        self._far = far
        self._forwarding = forwarding

    def pass_on(self, data: bytes, position: int) -> int:
        """Pass on the known frames at `position`; return the position of what is left.

        Not more than a portion is passed on at once.
        """
        size = len(data)
        end = min(size, position + PORTION)
        gathered: dict[Peer, None] = {}
        while position < end:
            known = self._known(data, position)
            if known is None or position + known[3] > size:
                break
            exchange, near = known[:2]
            if not exchange.live or not near.connected:
                self._heads.clear()
                break
            if not self._far.comes_from(exchange.target) or not self._far.answers(exchange.target):
                break
            begin = position
            if known[4]:
                _, _, head, length, _ = known
                position += length
                self._forwarding.returned += 1
                near.gather_notification(head + data[begin + HEAD_SIZE : position])
                gathered[near] = None
                continue
            position = self._pass_on_to(exchange, near, data, position, end)
            if position == begin:
                break
            gathered[near] = None
        for near in gathered:
            near.flush() if size <= SMALL_PORTION else near.flush_soon()
        return position

    def single(self, data: bytes) -> PassOn | None:
        """Return the function that passes on frames like `data`; None if `data` is not one whole
        frame. `data` was passed on."""
        known = self._heads.get(data[:HEAD_SIZE])
        if known is None or known[3] != len(data):
            return None
        exchange, near, head, length, notification = known
        return single_answer(self._far, near, exchange, head, length, notification)

    def _pass_on_to(
        self, exchange: PendingExchange, near: "Peer", data: bytes, position: int, end: int
    ) -> int:
        """Pass on answers at `position` as long as they belong to the same exchange."""
        if exchange.further:
            return position
        heads, size, requests = self._heads, len(data), exchange.requests
        parts: list[bytes] = []
        begin, count, load, failed = position, 0, 0, 0
        before: _Known | None = None
        request = last = None
        together = True
        while position < end:
            rest = position + HEAD_SIZE
            known = heads.get(data[position:rest])
            if known is None:
                known = self._known(data, position)
                if known is None:
                    break
            its_exchange, _, head, length, notification = known
            stop = position + length
            if stop > size or its_exchange is not exchange or notification:
                break
            if known is not before:
                before = known
            elif together and end - position >= RUN * length:
                taken = self._run(known, data, position, end)
                if taken is not None:
                    part, number, weight, last = taken
                    parts.append(part)
                    position += number * length
                    count += number
                    load += weight
                    continue
                together = False
            invoke_id, result = _ID_AND_RESULT.unpack_from(data, rest)
            request = requests.pop(invoke_id, None)
            if request is None:
                break
            if request.change is not None:
                requests[invoke_id] = request
                break
            last = request
            load += request.size
            if result:
                failed += 1
            parts += (head, data[rest:stop])
            position = stop
            count += 1
        if last is not None:
            self._forwarding.answered(last, count, load)
            for _ in range(failed):
                self._far.router.client_figures.count_error(exchange.session.source)
            near.gather(parts, position - begin)
        return position

    def _run(
        self, known: _Known, data: bytes, position: int, end: int
    ) -> tuple[bytes, int, int, PendingRequest] | None:
        """Remove the requests of answers of one head that follow each other.

        Return the answers with the client's address, their number, the bytes of the requests and
        answers, and the last request; None if the frames are not alike.
        """
        exchange, _, head, length, _ = known
        requests = exchange.requests
        whole, fields = _run_of(length)
        alike = frames_alike(data, position, end, whole)
        if alike is None:
            return None
        rests, stop = alike
        count = len(rests)
        invoke_ids, results = zip(*fields.iter_unpack(data[position:stop]), strict=True)
        if any(results) or len(set(invoke_ids)) != count:
            return None
        pending = tuple(map(requests.get, invoke_ids))
        if not all(each is not None and each.change is None for each in set(pending)):
            return None
        load = sum(map(_size, pending))
        deque(map(requests.__delitem__, invoke_ids), 0)
        return head + head.join(rests), count, load, cast(PendingRequest, pending[-1])

    def _learn(
        self, head: bytes, command: int, flags: int, size: int, length: int
    ) -> _Known | None:
        notification = command == _NOTIFICATION and flags == _NOTICE
        if not notification and (command not in _ANSWERED or flags != _ANSWER or size < 4):
            return None
        exchange = self._forwarding.requests.exchanges.get(head[6:22])
        if exchange is None or not exchange.live or exchange.session.handles is not None:
            return None
        near = exchange.session.client
        takes = getattr(near, "takes_known", None)
        if takes is None or not takes():
            return None
        changed = head[:6] + exchange.session.source + head[14:]
        return exchange, cast("Peer", near), changed, length, notification
