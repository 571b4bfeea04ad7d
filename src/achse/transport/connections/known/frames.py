"""Frames of a connection that are passed on without decoding, and events of the others."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from achse.ams import Connection, Event
from achse.ams.frame import TCP_HEADER
from achse.transport.connections.known.answers import KnownAnswers
from achse.transport.connections.known.requests import KnownRequests
from achse.transport.connections.known.single import (
    HEAD_SIZE,
    MOST_HEADS,
    PassOn,
)

if TYPE_CHECKING:
    from achse.transport.connections.peer import Peer


class KnownFrames:
    """Requests of known clients that come by a connection, and answers to requests that went by it.

    `stream` decodes what is not known.
    """

    def __init__(self, peer: "Peer", stream: Connection) -> None:
        self._peer = peer
        self._stream = stream
        self._requests = KnownRequests(peer)
        self._answers: KnownAnswers | None = None
        self.singles: dict[bytes, PassOn] = {}
        """Functions that pass on a portion that is one frame, by its first bytes."""

    def pass_on_portion(self, data: bytes) -> int:
        """Pass on what is known of a portion; return the position of what is left."""
        position = self.pass_on(data)
        if position == len(data):
            self._note_single(data)
        return position

    def _note_single(self, data: bytes) -> None:
        """Remember how a portion was passed on, if it was one frame."""
        known: PassOn | None
        known = None if self._answers is None else self._answers.single(data)
        known = known or self._requests.single(data)
        if known is not None:
            if len(self.singles) >= MOST_HEADS:
                self.singles.clear()
            self.singles[data[:HEAD_SIZE]] = known

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
        """Drop all: the peer is disconnected."""
        self.singles.clear()
        self._requests.clear()
        if self._answers is not None:
            self._answers.clear()
