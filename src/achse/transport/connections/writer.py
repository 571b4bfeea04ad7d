"""Writing half of a peer: frames are gathered, and written once per turn of the loop."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable

from achse.transport.connections.byte_transport import ByteTransport, PeerOwner
from achse.transport.connections.write_buffer import WriteBuffer

CONGESTED = 1024 * 1024
"""Bytes waiting for a peer at which devices keep notifications back."""

_FLUSH_SIZE = 256 * 1024
"""Answers are written once per turn of the loop, or when this many bytes have gathered."""

_SMALL = 4096
"""Gathered bytes below this are not counted until they are written, with the same turn."""


class PeerWriter(ABC):
    """Writer of frames for a peer; counts the bytes that its transport has not accepted."""

    def __init__(self, owner: PeerOwner) -> None:
        self.owner = owner
        self.write_buffer = WriteBuffer()
        self._counted = 0
        """Bytes that `owner.send_budget` counts for this peer."""
        self._flush_due = False
        self._receiving = False
        """True while events are processed: what they gather is written behind the last one."""
        self._congested = CONGESTED
        self.unread = 0
        """Bytes in the transport's buffer after the last write."""
        self.direct_write: Callable[[bytes], object] = self.write
        """Function that sends a frame at once if no other is gathered or unread before it."""
        self._transport: ByteTransport | None = None
        self.connected = False
        """True while something comes from the peer and goes to it."""
        self.cut_off = False
        """True once the peer was closed because it took too much room."""

    @property
    @abstractmethod
    def unprocessed(self) -> int:
        """Received bytes that are buffered."""

    @abstractmethod
    def warn(self, reason: str, *details: object) -> None:
        """Log the reason of the end of this connection."""

    @abstractmethod
    def abort(self) -> None:
        """Close at once, and drop the buffered bytes."""

    def write(self, packet: bytes) -> None:
        """Send an encoded frame at once, unless others are gathered before it."""
        out, transport = self.write_buffer, self._transport
        if out.size or self._receiving or transport is None:
            self.put((packet,), len(packet))
            return
        transport.write(packet)
        self.unread = transport.get_write_buffer_size()
        if self.unread or self._counted:
            self._check_unread()

    def gather_notification(self, packet: bytes) -> None:
        """Keep a notification until `flush` or `flush_soon`, or longer if it must not come yet."""
        if not self._delay(packet):
            self.gather((packet,), len(packet))

    def write_notification(self, packet: bytes) -> None:
        """Send a notification at once, if it may come now and nothing is gathered before it."""
        if not self._delay(packet):
            self.write(packet)

    def room_for_notifications(self) -> int:
        """Return bytes of notifications that may be `put` in one go, as they would be one by one; 0
        while they are kept back."""
        transport = self._transport
        if (
            transport is None
            or not self.connected
            or self.write_buffer.delays(self.owner.loop.time())
        ):
            return 0
        return 0 if self.congested else max(_FLUSH_SIZE - self.write_buffer.size, 0)

    def _put(self, packet: bytes) -> None:
        self.put((packet,), len(packet))

    def put(self, packets: Iterable[bytes], size: int) -> None:
        """Send encoded frames, all in all `size` bytes."""
        self.gather(packets, size)
        self.flush_soon()

    def gather(self, packets: Iterable[bytes], size: int) -> None:
        """Keep encoded frames until `flush` or `flush_soon`."""
        out = self.write_buffer
        out.gathered += packets
        out.size += size
        if out.size > _FLUSH_SIZE:
            self._flush()

    def flush_soon(self) -> None:
        """Write what is gathered at the end of this turn."""
        size = self.write_buffer.size
        if size and not self._receiving:
            if not self._flush_due:
                self._flush_due = True
                self.owner.loop.call_soon(self._flush)
            if size > _SMALL:
                self.count()

    def flush(self) -> None:
        """Write what is gathered now, or behind the last event that is processed."""
        if not self._receiving:
            self._flush()

    def _delay(self, packet: bytes) -> bool:
        """Delay a notification that must not be sent yet."""
        out, loop = self.write_buffer, self.owner.loop
        waited = out.due is not None
        if not out.delay(packet, loop.time()):
            return False
        if not waited:
            self._release_at(out.due)
        self.count()
        return True

    def _release_at(self, due: float | None) -> None:
        if due is not None:
            self.owner.loop.call_at(due, self._release)

    def _release(self) -> None:
        """Send the notifications that have waited long enough, in order."""
        out, due = self.write_buffer, self.write_buffer.due
        if self.connected and due is not None:
            out.release(max(self.owner.loop.time(), due))  # timers may be early by their resolution
            self._release_at(out.due)
            self._flush()

    @property
    def congested(self) -> bool:
        """True while the peer leaves so much unread that notifications had better wait."""
        transport = self._transport
        return transport is not None and transport.get_write_buffer_size() > self._congested

    @property
    def backlog(self) -> int:
        """Bytes that the peer has not taken yet."""
        transport = self._transport
        return self.write_buffer.size + (
            0 if transport is None else transport.get_write_buffer_size()
        )

    @property
    def buffered_bytes(self) -> int:
        """Bytes it has not taken, also after the end, and packets that lack their end."""
        if self.cut_off:
            return 0
        return self.backlog + self.write_buffer.delayed_size + self.unprocessed

    def count(self) -> None:
        """Update the send-buffer budget after a change of the buffered bytes."""
        transport = self._transport
        self.unread = 0 if transport is None else transport.get_write_buffer_size()
        size = self.buffered_bytes
        if size != self._counted:
            self._counted = size
            self.owner.send_budget.count(self, size)

    def cut(self, reason: str, *details: object) -> None:
        """Close at once because the peer takes too much room."""
        self.warn(reason, *details)
        self.cut_off = True
        self.abort()

    def _flush(self) -> None:
        self._flush_due = False
        out, transport = self.write_buffer, self._transport
        if not out.size or transport is None:
            return
        transport.write(out.take())
        self.unread = transport.get_write_buffer_size()
        self._check_unread()

    def _check_unread(self) -> None:
        """End a connection whose peer leaves too much unread."""
        if self.unread > self.owner.max_backlog:
            self.cut("it does not read its answers")
        elif self.unread or self._counted:
            self.count()
