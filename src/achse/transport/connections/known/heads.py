"""Heads of frames: what is known of a frame by its first bytes, before any decoding.

Source: 000 §3.2, the headers of AMS/TCP.
"""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Generic, TypeVar

from achse.ams.frame import AMS_HEADER, TCP_HEADER
from achse.transport.connections.known.single import HEAD_SIZE, HEADERS_SIZE, MOST_HEADS

if TYPE_CHECKING:
    from achse.transport.connections.peer import Peer

K = TypeVar("K")


class KnownHeads(ABC, Generic[K]):
    """Heads of the frames that come by one connection, with what `_learn` found out of each."""

    def __init__(self, peer: "Peer") -> None:
        self._peer = peer
        self._heads: dict[bytes, K] = {}

    @abstractmethod
    def _learn(self, head: bytes, command: int, flags: int, size: int, length: int) -> K | None:
        """Return what is known of frames with a head; None if they have to be decoded.

        `size` counts the bytes behind the AMS header, `length` those of the frame.
        """

    def _known(self, data: bytes, position: int) -> K | None:
        """Return what is known of the frame at `position`; None if it has to be decoded."""
        head = data[position : position + HEAD_SIZE]
        known = self._heads.get(head)
        if known is not None:
            return known
        if len(data) - position < HEADERS_SIZE:
            return None
        tcp_command, length = TCP_HEADER.unpack_from(head)
        _, _, command, flags, size, error, _ = AMS_HEADER.unpack_from(
            data, position + TCP_HEADER.size
        )
        if tcp_command or length != AMS_HEADER.size + size or error:
            return None
        if length > self._peer.owner.max_length:
            return None
        known = self._learn(head, command, flags, size, TCP_HEADER.size + length)
        if known is not None:
            if len(self._heads) >= MOST_HEADS:
                self.clear()
            self._heads[head] = known
        return known

    def clear(self) -> None:
        """Forget all heads."""
        self._heads.clear()
