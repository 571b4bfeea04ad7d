"""Two AMS connections and the wire between them, which the test holds in its hand."""

from collections import deque

from achse.ams import Connection, DecodeError, Event, Frame, TcpMessage


class LinkEnd:
    """One end: `send` puts packets on the wire, `received` is what came out of it."""

    def __init__(self) -> None:
        self.received: list[Event] = []
        self.failure: DecodeError | None = None
        """Error after which this end accepts no more bytes; None before."""
        self.is_open = True
        self.wire = bytearray()
        """Bytes on their way to this end."""
        self.other: LinkEnd
        self._stream = Connection()

    @property
    def frames(self) -> list[Frame]:
        """The AMS frames among what came."""
        return [event for event in self.received if isinstance(event, Frame)]

    def send(self, *packets: Frame | TcpMessage | bytes) -> None:
        """Put packets, or any bytes, on the wire. Raises ConnectionResetError after a cut."""
        if not self.is_open:
            raise ConnectionResetError("the wire is cut")
        for packet in packets:
            self.other.wire += packet if isinstance(packet, bytes) else packet.encode_tcp()

    def deliver(self, frame: Frame) -> bool:
        """Send `frame` like an endpoint of a router; False after a cut."""
        if self.is_open:
            self.send(frame)
        return self.is_open

    def take(self, count: int) -> None:
        """Let `count` bytes come out of the wire."""
        data = bytes(self.wire[:count])
        del self.wire[:count]
        if self.failure is None:
            try:
                for event in self._stream.receive(data):
                    self.received.append(event)
            except DecodeError as failure:
                self.failure = failure


class LinkedPair:
    """`pair.left.send(frame); pair.flow(); pair.right.frames`

    `chunk` cuts the stream into pieces of so many bytes; 0 lets everything through at once.
    """

    def __init__(self, chunk: int = 0) -> None:
        self.chunk = chunk
        self.left, self.right = LinkEnd(), LinkEnd()
        self.left.other, self.right.other = self.right, self.left

    def flow(self, limit: int | None = None) -> None:
        """Let everything arrive, or at most `limit` bytes in each direction."""
        for end in (self.left, self.right):
            due = len(end.wire) if limit is None else min(limit, len(end.wire))
            pieces = deque(
                [self.chunk] * (due // self.chunk) + [due % self.chunk] if self.chunk else [due]
            )
            while pieces:
                end.take(pieces.popleft())

    def cut(self) -> None:
        """Pull the cable: what is on the wire is lost, and nothing more can be sent."""
        for end in (self.left, self.right):
            end.wire.clear()
            end.is_open = False
