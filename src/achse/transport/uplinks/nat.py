"""NAT: a peer that has another NetId than the one by which we know it."""

from collections.abc import Iterator

from achse.ams import Connection, Frame, NetId
from achse.ams.connection import Event
from achse.transport.uplinks.dialled import DialledPeer, DialOwner


class NatPeer(DialledPeer):
    """`ours` is the NetId that we use for it, `theirs` the one that it has itself."""

    _unchanged = False

    def __init__(self, owner: DialOwner, ours: NetId, theirs: NetId) -> None:
        super().__init__(owner)
        self._ours = bytes(ours)
        self._theirs = bytes(theirs)
        self._stream = _NatStream(owner.max_length, self._ours, self._theirs)

    def _put(self, packet: bytes) -> None:
        if packet[6:12] == self._ours:
            packet = packet[:6] + self._theirs + packet[12:]
        super()._put(packet)


class _NatStream(Connection):
    """Frames with their sender as we know it."""

    __slots__ = ("_ours", "_theirs")

    def __init__(self, max_length: int, ours: bytes, theirs: bytes) -> None:
        super().__init__(max_length)
        self._ours = ours
        self._theirs = theirs

    def receive(self, data: bytes) -> Iterator[Event]:
        """Yield every event that `data` completes."""
        for event in super().receive(data):
            if isinstance(event, Frame) and event.source[:6] == self._theirs:
                event.source = self._ours + event.source[6:]
            yield event
