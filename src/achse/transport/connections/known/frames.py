"""Frames of a connection that are passed on without decoding, and events of the others."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from achse.ams import Connection, Event
from achse.ams.frame import TCP_HEADER
from achse.transport.connections.known.answers import KnownAnswers
from achse.transport.connections.known.requests import KnownRequests

if TYPE_CHECKING:
    from achse.transport.connections.peer import Peer

__all__ = ["KnownFrames"]


class KnownFrames:
    """Requests of known clients that come by a connection, and answers to requests that went by it.

    `stream` decodes what is not known.
    """

    def __init__(self, peer: "Peer", stream: Connection) -> None:
        self._peer = peer
        self._stream = stream
        self._requests = KnownRequests(peer)
        self._answers: KnownAnswers | None = None

    def pass_on(self, data: bytes, position: int = 0) -> int:
        """Pass on the known frames at `position`; return the position of what is left."""
        peer = self._peer
        if peer.router.attended or self._stream.pending:
            return position
        if peer.forwarding is not None:
            if self._answers is None:
                self._answers = KnownAnswers(peer, peer.forwarding)
            position = self._answers.pass_on(data, position)
        return self._requests.forward(data, position)

    def events(self, data: bytes) -> Iterator[Event | None]:
        """Pass on what is known and yield the other events, in order.

        None is yielded after each portion of known frames: others may have their turn.
        """
        peer, stream = self._peer, self._stream
        position, end = 0, len(data)
        while position < end and peer.connected:
            begin = position
            position = self.pass_on(data, position)
            if position > begin:
                yield None
                continue
            if stream.pending:
                stop = position + stream.missing
            elif end - position >= TCP_HEADER.size:
                stop = position + TCP_HEADER.size + TCP_HEADER.unpack_from(data, position)[1]
            else:
                stop = end
            yield from stream.receive(data[position:stop])
            position = stop

    def clear(self) -> None:
        """Forget all: the peer is gone."""
        self._requests.clear()
        if self._answers is not None:
            self._answers.clear()
