"""Connections for which there is no room: the first request is answered so, then they end.

A connection that is closed without a word looks like a missing route; one that is answered says
what is wrong. What this costs is bounded in number, bytes and time, whatever the peers do.
"""

import asyncio

from achse.ams import Command, Flags, Frame
from achse.ams.frame import AMS_HEADER, TCP_HEADER
from achse.codes import ReturnCode

NO_ROOM = ReturnCode.ROUTER_NO_MORE_QUEUES
"""0x508: what a router answers that has no more ports to give (000 §7, 002 §8)."""

_AT_ONCE = 64
"""Refused connections that may still be open; beyond, the oldest is dropped."""

_PATIENCE = 5.0
"""Seconds that a refused peer has to ask, and to close after the answer."""

_HEADS = TCP_HEADER.size + AMS_HEADER.size


class RefusedConnections:
    """The refused connections of one listener that are still open."""

    def __init__(self) -> None:
        self._open: dict[_Refusal, None] = {}

    def __len__(self) -> int:
        return len(self._open)

    def add(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop) -> None:
        """Answer the first request that comes over `transport`, then close it."""
        if len(self._open) >= _AT_ONCE:
            next(iter(self._open)).end()
        refusal = _Refusal(self._open, transport)
        self._open[refusal] = None
        refusal.timer = loop.call_later(_PATIENCE, refusal.end)
        transport.set_protocol(refusal)

    def close(self) -> None:
        """End all of them."""
        for refusal in list(self._open):
            refusal.end()


class _Refusal(asyncio.Protocol):
    """One of them: keeps the head of a packet at most, and reads on so that the answer arrives."""

    timer: asyncio.TimerHandle

    def __init__(self, among: "dict[_Refusal, None]", transport: asyncio.Transport) -> None:
        self._among = among
        self._transport = transport
        self._head = b""
        self._has_logged = False

    def data_received(self, data: bytes) -> None:
        if self._has_logged:
            return  # unread, it would turn the end of the connection into an RST
        self._head += data[: _HEADS - len(self._head)]
        if len(self._head) >= TCP_HEADER.size and TCP_HEADER.unpack_from(self._head)[0]:
            self._say(b"")  # the port service has no way to refuse but this
        elif len(self._head) == _HEADS:
            self._say(self._answer())

    def connection_lost(self, exc: Exception | None) -> None:
        self.timer.cancel()
        self._among.pop(self, None)

    def end(self) -> None:
        """Close at once."""
        self._among.pop(self, None)
        self.timer.cancel()
        self._transport.abort()

    def _answer(self) -> bytes:
        target, source, command, flags, _, error, invoke_id = AMS_HEADER.unpack_from(
            self._head, TCP_HEADER.size
        )
        if flags & (Flags.RESPONSE | Flags.NO_RESPONSE) or command == Command.NOTIFICATION:
            return b""
        request = Frame(target, source, command, flags, error, invoke_id)
        return request.reply(error=NO_ROOM.number).encode_tcp()

    def _say(self, answer: bytes) -> None:
        self._has_logged = True
        if answer:
            self._transport.write(answer)
        self._transport.write_eof()
