"""AMS over a serial line, without port, clock or loop: bytes in, packets and bytes out.

A frame carries one whole AMS packet of at most 255 bytes. The sender waits until a frame is
acknowledged and repeats it if it is not; the receiver takes each frame once. Times are seconds on
any clock that goes forward; the owner of the line calls `due` when `deadline` has come.

Source: 000 §4; the facts that it leaves open are the named numbers here.
"""

import random
from collections import deque
from enum import Enum
from typing import NamedTuple

from achse.ams.errors import DecodeError

MAX_PACKET = 255
"""Bytes of the longest AMS packet, header included (000 §4.1); how to split one is not public."""

SENDINGS = 3
"""Number of times that a frame is sent before the sender drops it."""

REPEAT_TIME = 0.5
"""Seconds, after the last bit has left, within which an acknowledge must come at 38400 baud or
less: the peer may be in the middle of a frame of its own, 274 ms at 9600 baud."""

QUICK_REPEAT_TIME = 0.2
"""The same above 38400 baud; adapters and their drivers gather bytes for some 20 ms."""

SLOW_BAUD = 38_400

FREE_AFTER = 5.0
"""Seconds of silence after which a frame of any number is taken. Before that the very same frame
is a repeated one, even behind a reset: it may have been on its way that long."""

GAP = 0.05
"""Seconds of silence within a frame after which it is none: its beginning was an accident."""

_HEAD, _TAIL = 6, 2
_BITS_PER_BYTE = 10
"""Start bit, eight bits, stop bit."""

_TABLE = []
for _byte in range(256):
    for _ in range(8):
        _byte = _byte >> 1 ^ (0xA001 if _byte & 1 else 0)
    _TABLE.append(_byte)


def crc16(data: bytes | bytearray) -> int:
    """Return the checksum of a frame: 0x8005 reflected, start 0xFFFF. It is sent high byte
    first."""
    crc = 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc


class FrameKind(Enum):
    """Kind of a frame, by its first two bytes (000 §4.1)."""

    DATA = b"\x01\xa5"
    ACKNOWLEDGE = b"\x01\x5a"
    RESET = b"\x03\xa5"


_KINDS = {kind.value: kind for kind in FrameKind}


class SerialFrame(NamedTuple):
    """One frame on the line. Addresses are 0..255, and 0 on RS232, where there are only two."""

    kind: FrameKind
    fragment: int
    data: bytes = b""
    sender: int = 0
    receiver: int = 0

    def encode(self) -> bytes:
        """Return the bytes of the frame, checksum included."""
        head = bytes((self.sender, self.receiver, self.fragment, len(self.data)))
        body = self.kind.value + head + self.data
        return body + crc16(body).to_bytes(2, "big")

    @classmethod
    def decode(cls, packet: bytes | bytearray) -> "SerialFrame":
        """Return the frame that begins at the first byte; raises DecodeError for what is none."""
        kind = _KINDS.get(bytes(packet[:2]))
        if kind is None or len(packet) < _HEAD + _TAIL:
            raise DecodeError(f"a serial frame begins with 01 A5, 01 5A or 03 A5: {packet[:8]!r}")
        end = _HEAD + packet[5]
        if len(packet) < end + _TAIL:
            raise DecodeError(f"a frame of {end + _TAIL} bytes, got {len(packet)}")
        crc = int.from_bytes(packet[end : end + _TAIL], "big")
        if crc != crc16(packet[:end]):
            raise DecodeError(f"checksum 0x{crc16(packet[:end]):04X} expected, got 0x{crc:04X}")
        return cls(kind, packet[4], bytes(packet[_HEAD:end]), packet[2], packet[3])


class SerialEnd:
    """One end of a line; both ends are alike.

    `send` queues packets, `take` gives the bytes that are to go out now, `receive` the packets that
    came. `undelivered` has the unacknowledged ones: they may have arrived all the same.
    A new end begins with a reset, so that the other one takes its first number, which is drawn by
    chance: the first frame of a program that is started again is not taken for the last one's.
    """

    def __init__(self, baud: int = 38_400, *, address: int = 0, first: int | None = None) -> None:
        if baud <= 0:
            raise ValueError(f"a line has 1 baud or more, got {baud}")
        self.baud = baud
        self.address = address
        self.undelivered: deque[bytes] = deque()
        """Packets sent in vain, oldest first; the reader takes them out."""
        self.sent_packets = self.received_packets = self.repeated_frames = self.spoiled_frames = 0
        """Packets acknowledged and passed on, frames sent again, frames and bytes of no use."""
        self.resets = 0
        """Number of resets by the other end."""
        self.full = False
        """Set it while nothing new can be taken: only repeated packets are acknowledged then."""
        self._queue: deque[bytes] = deque()
        self._queued = 0
        self._out = bytearray()
        self._free_at = 0.0
        """Time at which the last bit of the bytes passed out by `take` is on the line."""
        self._fragment = random.randrange(256) if first is None else first
        self._begins = True
        """A reset is due before the next new frame."""
        self._waiting: SerialFrame | None = None
        self._sendings = 0
        self._repeat_at: float | None = None
        self._came = bytearray()
        self._came_at = 0.0
        self._expected: int | None = None
        self._good: SerialFrame | None = None
        self._good_at = 0.0

    # out -------------------------------------------------------------------------------------

    @property
    def unsent(self) -> int:
        """Bytes of packets that are not acknowledged yet."""
        return self._queued + (0 if self._waiting is None else len(self._waiting.data))

    def send(self, packet: bytes, now: float) -> None:
        """Queue an AMS packet. Raises ValueError if it does not fit a frame."""
        if not 0 < len(packet) <= MAX_PACKET:
            raise ValueError(f"an AMS packet on a serial line has 1..255 bytes, got {len(packet)}")
        self._queue.append(packet)
        self._queued += len(packet)
        self._next(now)

    def give_up(self) -> None:
        """Note that the line is gone: what is not acknowledged goes to `undelivered`."""
        if self._waiting is not None:
            self.undelivered.append(self._waiting.data)
        self.undelivered += self._queue
        self._queue.clear()
        self._queued = 0
        self._waiting, self._repeat_at, self._begins = None, None, True

    @property
    def waiting(self) -> bytes | None:
        """The packet whose acknowledge is waited for."""
        return None if self._waiting is None else self._waiting.data

    def confirm(self, now: float) -> None:
        """Note that the packet that waits has arrived, as its answer shows: its acknowledge was
        lost."""
        if self._waiting is not None:
            self._acknowledged(self._waiting.fragment, now)

    def take(self, now: float) -> bytes:
        """Return the bytes that are to be written now, once."""
        data = bytes(self._out)
        self._out.clear()
        return data

    def _put(self, frame: SerialFrame, now: float) -> None:
        data = frame.encode()
        self._out += data
        self._free_at = max(now, self._free_at) + len(data) * _BITS_PER_BYTE / self.baud

    def _next(self, now: float) -> None:
        """Send the next packet, if nothing waits for its acknowledge."""
        if self._waiting is not None or not self._queue:
            return
        packet = self._queue.popleft()
        self._queued -= len(packet)
        if self._begins:
            self._put(SerialFrame(FrameKind.RESET, 0, b"", self.address), now)
        self._waiting = SerialFrame(FrameKind.DATA, self._fragment, packet, self.address)
        self._fragment = (self._fragment + 1) % 256
        self._sendings = 0
        self._send_waiting(now)

    def _send_waiting(self, now: float) -> None:
        assert self._waiting is not None
        self._put(self._waiting, now)
        self._sendings += 1
        patience = REPEAT_TIME if self.baud <= SLOW_BAUD else QUICK_REPEAT_TIME
        self._repeat_at = self._free_at + patience

    # time ------------------------------------------------------------------------------------

    @property
    def deadline(self) -> float | None:
        """Time of the next call of `due`; None if there is nothing to wait for."""
        gap = self._came_at + GAP if self._came else None
        if gap is None or self._repeat_at is None:
            return self._repeat_at if gap is None else gap
        return min(gap, self._repeat_at)

    def due(self, now: float) -> list[bytes]:
        """Time has passed: repeat, give up, look again at what did not become a frame.

        The packets that came, as from `receive`.
        """
        packets: list[bytes] = []
        while self._came and now >= self._came_at + GAP:
            self._spoil()
            packets += self._frames(now)
        if self._repeat_at is not None and now >= self._repeat_at:
            self._repeat(now)
        return packets

    def _repeat(self, now: float) -> None:
        assert self._waiting is not None
        if self._sendings < SENDINGS:
            self.repeated_frames += 1
            self._send_waiting(now)
            return
        self.undelivered.append(self._waiting.data)
        # Never between two sendings of a frame: the other end would take it twice.
        self._put(SerialFrame(FrameKind.RESET, 0, b"", self.address), now)
        self._waiting, self._repeat_at, self._begins = None, None, True
        self._next(now)

    # in --------------------------------------------------------------------------------------

    def receive(self, data: bytes, now: float) -> list[bytes]:
        """Take bytes as they come; the AMS packets that are complete, each once, in order."""
        packets: list[bytes] = []
        while self._came and now >= self._came_at + GAP:
            self._spoil()
            packets += self._frames(now)
        self._came += data
        self._came_at = now
        return packets + self._frames(now)

    def _spoil(self) -> None:
        """Discard the first byte: it begins no frame."""
        del self._came[0]
        self.spoiled_frames += 1

    def _frames(self, now: float) -> list[bytes]:
        came, packets = self._came, []
        while len(came) >= 2:
            if bytes(came[:2]) not in _KINDS:
                self._spoil()
                continue
            if len(came) < _HEAD or len(came) < _HEAD + came[5] + _TAIL:
                break
            try:
                frame = SerialFrame.decode(came)
            except DecodeError:
                self._spoil()
                continue
            del came[: _HEAD + len(frame.data) + _TAIL]
            if self._take(frame, now):
                packets.append(frame.data)
        if len(came) == 1 and not any(kind[0] == came[0] for kind in _KINDS):
            self._spoil()
        return packets

    def _take(self, frame: SerialFrame, now: float) -> bool:
        """Accept a good frame; True if it brings a packet to pass on."""
        if frame.kind is FrameKind.RESET:
            self.resets += 1
            self._expected = None
            return False
        if frame.kind is FrameKind.ACKNOWLEDGE:
            self._acknowledged(frame.fragment, now)
            return False
        if not frame.data:
            self.spoiled_frames += 1
            return False
        since = now - self._good_at
        same = frame == self._good and since < FREE_AFTER
        fresh = not same
        if fresh and self._expected is not None and since < FREE_AFTER:
            # The last number with other data is no repeated frame: the sender started again.
            fresh = (self._expected - frame.fragment) % 256 < 2
        if not (fresh or same) or (fresh and self.full):
            self.spoiled_frames += 1
            return False
        acknowledge = FrameKind.ACKNOWLEDGE, frame.fragment, b"", self.address, frame.sender
        self._put(SerialFrame(*acknowledge), now)
        self._good_at = now
        self._expected = (frame.fragment + 1) % 256
        if fresh:
            self._good = frame
            self.received_packets += 1
        return fresh

    def _acknowledged(self, fragment: int, now: float) -> None:
        if self._waiting is not None and self._waiting.fragment == fragment:
            self.sent_packets += 1
            self._waiting, self._repeat_at, self._begins = None, None, False
            self._next(now)
