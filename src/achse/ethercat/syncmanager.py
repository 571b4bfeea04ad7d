"""SyncManagers: consistent buffers and mailboxes between master and application.

A buffer or mailbox changes owner when its last byte is accessed. What is refused here is not
counted by the working counter; that is all a master learns of it.

Source: ETG.1000.4 §6.7, table 59.
"""

from collections.abc import Callable

_MODE_AND_DIRECTION = 0x0F
_ENABLE = 0x01
_REPEAT = 0x02
_WRITE_EVENT = 0x01
_READ_EVENT = 0x02
_FULL = 0x08


class SyncManager:
    """One SyncManager, 8 bytes of registers at 0x0800 + 8·number.

    `buffered` is the three-buffer mode (control bits 0..1 = 00), else it is a mailbox (10).
    `to_application` is the direction (bits 2..3 = 01: the master writes). The application lets the
    SyncManager work only when `locked` is False (register PDI control bit 0).

    Events: `on_written(data)` after the master completed a buffer or message, `on_taken()` after it
    read the last byte of a message.
    """

    __slots__ = (
        "_last_buffer",
        "_newest",
        "_reading",
        "_writing",
        "buffered",
        "control",
        "enabled",
        "events",
        "full",
        "length",
        "locked",
        "number",
        "on_taken",
        "on_written",
        "repeat_acknowledge",
        "repeat_request",
        "sink",
        "source",
        "start",
        "to_application",
    )

    def __init__(
        self,
        number: int,
        on_written: Callable[[bytes], None],
        on_taken: Callable[[], None],
    ) -> None:
        self.number = number
        self.on_written = on_written
        self.on_taken = on_taken
        self.locked = True
        self.source: Callable[[], bytes] | None = None
        """Source of the newest content of a buffer to the master."""
        self.sink: Callable[[bytes], None] | None = None
        """Receiver of whole buffers of logical datagrams, instead of `complete`; sets no events."""
        self.repeat_request = self.repeat_acknowledge = False
        self.configure(bytes(8))

    def configure(self, registers: bytes) -> None:
        """Take over what the master wrote to the 8 registers; buffers start empty."""
        self.start = registers[0] | registers[1] << 8
        self.length = registers[2] | registers[3] << 8
        self.control = registers[4]
        self.enabled = bool(registers[6] & _ENABLE)
        self.repeat_request = bool(registers[6] & _REPEAT)
        self.buffered = self.control & 0x03 == 0
        self.to_application = self.control & 0x0C == 0x04
        self.reset()

    def reset(self) -> None:
        """Empty the buffers."""
        self.full = False
        self.events = 0
        self._last_buffer = 3  # none
        self._writing = bytearray(self.length)
        self._newest = self._reading = bytes(self.length)

    @property
    def end(self) -> int:
        """First address behind the area."""
        return self.start + self.length

    @property
    def guards(self) -> bool:
        """True if the SyncManager controls accesses to the area."""
        return self.enabled and self.length > 0

    @property
    def works(self) -> bool:
        """True if master and application both enable it."""
        return self.guards and not self.locked

    def is_like(self, control: int) -> bool:
        """Return True if mode and direction are those of another control byte."""
        return not (self.control ^ control) & _MODE_AND_DIRECTION

    @property
    def triggers_watchdog(self) -> bool:
        return bool(self.control & 0x40)

    @property
    def status(self) -> int:
        """Register status: events, mailbox full, the last written of three buffers."""
        if self.buffered:
            return self.events | self._last_buffer << 4
        return self.events | _FULL * self.full

    # the master's side

    def accepts(self, write: bool) -> bool:
        """Return True if the master may write or read now."""
        if self.locked or write != self.to_application:
            return False
        return self.buffered or self.full != write

    def write(self, offset: int, data: bytes | bytearray) -> None:
        """Write the master's part; the last byte completes the buffer."""
        end = offset + len(data)
        self._writing[offset:end] = data
        if end == self.length:
            self.complete(bytes(self._writing))

    def complete(self, data: bytes) -> None:
        """Complete a buffer or message that the master wrote."""
        self._newest = data
        self.full = not self.buffered
        self.events = _WRITE_EVENT
        self._last_buffer = (self._last_buffer + 1) % 3 if self._last_buffer < 3 else 0
        self.on_written(data)

    def read(self, offset: int, length: int) -> bytes:
        """The master reads a part; the first byte fixes the buffer, the last releases it."""
        if offset == 0:
            self._reading = self.source() if self.source else self._newest
        part = self._reading[offset : offset + length]
        if offset + length == self.length and not self.buffered:
            self.full = False
            self.events = _READ_EVENT
            self.on_taken()
        return part

    def peek(self) -> bytearray:
        """The buffer the master is writing, for single bits."""
        return self._writing

    # the application's side

    def put(self, message: bytes) -> None:
        """Fill a mailbox or buffer to the master, padded to its length."""
        self._newest = message.ljust(self.length, b"\0")
        if not self.buffered:
            self._reading = self._newest
        self.full = not self.buffered
        self.events = _WRITE_EVENT

    def release(self) -> None:
        """Note that the application has read the message; the master may write the next."""
        self.full = False
        self.events = _READ_EVENT

    @property
    def concerns_application(self) -> bool:
        """True if the master wrote data that the application has not read, or took the waiting
        message."""
        if self.sink is not None or self.source is not None:
            return False  # an access to whole buffers has read them
        event = _WRITE_EVENT if self.to_application else _READ_EVENT
        return self.works and bool(self.events & event)

    @property
    def newest(self) -> bytes:
        """The last complete buffer."""
        return self._newest
