"""The master's end of a slave's mailbox: one conversation at a time, with repeats of lost messages.

Source: 001 §2.6; ETG.1000.4 §6.7 for the repeat by SyncManager 1.
"""

from collections import deque
from collections.abc import Callable

from achse.ethercat.coe import CoeService
from achse.ethercat.description import SyncManagerArea
from achse.ethercat.frame import Datagram, DatagramCommand
from achse.ethercat.mailbox import MailboxError, MailboxProtocol, Message
from achse.ethercat.master.errors import (
    FrameLost,
    MailboxRefusal,
    MailboxTimeout,
    NoAnswer,
    WrongAnswer,
)
from achse.ethercat.master.steps import Pause, Steps, Trip, now, read, write
from achse.ethercat.registers import SM_BASE

_SM_SIZE = 8
_STATUS, _ACTIVATE, _PDI_CONTROL = 5, 6, 7
"""Bytes of a SyncManager's registers."""

_SM1 = SM_BASE + _SM_SIZE
_FULL = 0x08
_REPEAT = 0x02
_EMERGENCY_SIZE = 10
_HEADER_SIZE, _LENGTH_SIZE = 6, 2
_POLL_NS = 1_000_000
_MAX_STALE = 64
"""Messages read at most before a request is sent: a slave that never runs dry is not waited for."""


class MailboxClient:
    """Messages to and from the slave at `station`.

    Times in ns: a message is taken within `request_ns`, answered within `response_ns` (ESI:
    RequestTimeout, ResponseTimeout). `emergency` gets the 8 bytes of each emergency message. With
    `split_writes` a message travels without what fills its mailbox up: its bytes and the last byte
    of the mailbox, as the vendor's master does it; else whole.
    """

    def __init__(
        self,
        station: int,
        outgoing: SyncManagerArea,
        incoming: SyncManagerArea,
        emergency: Callable[[bytes], None],
        *,
        request_ns: int = 100_000_000,
        response_ns: int = 2_000_000_000,
        split_writes: bool = False,
    ) -> None:
        self.station = station
        self.split_writes = split_writes
        self.outgoing = outgoing
        self.incoming = incoming
        self.request_ns = request_ns
        self.response_ns = response_ns
        self.repeats = 0
        """Messages that were lost on the way and requested again."""
        self._emergency = emergency
        self._counter = 0
        self._last_received = 0
        self._turn: deque[object] = deque()
        self._listeners: dict[int, Callable[[bytes], None]] = {}

    def listen(self, protocol: MailboxProtocol, listener: Callable[[bytes], None]) -> None:
        """Pass the data of each unsolicited message of a protocol to `listener`."""
        self._listeners[protocol] = listener

    def reset(self) -> None:
        """Note that the slave left Init: its counters begin again."""
        self._counter = self._last_received = 0

    @property
    def capacity(self) -> int:
        """Bytes of a message behind the mailbox header."""
        return self.outgoing.length - 6

    def converse(
        self,
        protocol: MailboxProtocol,
        data: bytes,
        wanted: Callable[[bytes], bool],
        response_ns: int = 0,
    ) -> Steps[bytes]:
        """Send a message and return the first answer of that protocol that is `wanted`.

        Raises `MailboxTimeout`, `MailboxRefusal`, `NoAnswer` or `FrameLost`.
        """
        yield from self.acquire()
        try:
            yield from self.send(protocol, data)
            return (yield from self.receive(protocol, wanted, response_ns))
        finally:
            self.release()

    def acquire(self) -> Steps[None]:
        """Wait until those before have had their answers."""
        ticket = object()
        self._turn.append(ticket)
        try:
            while self._turn[0] is not ticket:
                yield Pause(_POLL_NS)
        except BaseException:
            self._turn.remove(ticket)
            raise

    def release(self) -> None:
        """Let the next have the mailbox."""
        self._turn.popleft()

    @property
    def idle(self) -> bool:
        """True if no request is pending."""
        return not self._turn

    def collect(self) -> Steps[None]:
        """Read what waits, for emergencies and listeners; answers to requests that have ended
        are dropped."""
        yield from self.acquire()
        try:
            yield from self._drain()
        finally:
            self.release()

    def _drain(self) -> Steps[None]:
        for _ in range(_MAX_STALE):
            if not (yield from self._full()):
                return
            message = yield from self._fetch()
            if message is not None:
                self._dispatch(message)

    def _dispatch(self, message: Message) -> None:
        listener = self._listeners.get(message.protocol)
        if listener is not None:
            listener(message.data)

    def send(self, protocol: MailboxProtocol, data: bytes) -> Steps[None]:
        """Put a message into the slave's mailbox, once what waits there has been read."""
        if len(data) > self.capacity:
            raise WrongAnswer(f"a message has {self.capacity} bytes at most, got {len(data)}")
        yield from self._drain()
        self._counter = self._counter % 7 + 1
        message = Message(protocol, data, self._counter).encode()
        start = yield from now()
        request = self._requests(message)
        while True:
            # the slave drops a message that comes a second time: same counter
            time_ns = yield from now()
            back = yield Trip(request)
            if all(each.counter for each in back.datagrams):
                return
            if time_ns - start >= self.request_ns:
                raise MailboxTimeout(
                    f"station {self.station}: mailbox stays full for"
                    f" {self.request_ns // 1_000_000} ms"
                )
            yield Pause(_POLL_NS)

    def _requests(self, message: bytes) -> tuple[Datagram, ...]:
        """Return the datagrams that write a message; the last byte of the mailbox hands it over."""
        start, length = self.outgoing.start, self.outgoing.length
        write = DatagramCommand.FPWR
        if not self.split_writes or len(message) >= length - 1:
            whole = message.ljust(length, b"\0")
            return (Datagram.at(write, self.station, start, whole),)
        return (
            Datagram.at(write, self.station, start, message),
            Datagram.at(write, self.station, start + length - 1, b"\0"),
        )

    def receive(
        self, protocol: MailboxProtocol, wanted: Callable[[bytes], bool], response_ns: int = 0
    ) -> Steps[bytes]:
        """Return the next message of that protocol that is `wanted`; others go to listeners.

        The last look at the mailbox is when the time is over, however long this process was away.
        """
        allowed = response_ns or self.response_ns
        start = yield from now()
        while True:
            time_ns = yield from now()
            if (yield from self._full()):
                message = yield from self._fetch()
                if message is not None:
                    if message.protocol == MailboxProtocol.ERROR:
                        detail = int.from_bytes(message.data[2:4], "little")
                        raise MailboxRefusal(self.station, detail)
                    if message.protocol == protocol and wanted(message.data):
                        return message.data
                    self._dispatch(message)
                if time_ns - start < allowed:
                    continue
            if time_ns - start >= allowed:
                raise MailboxTimeout(
                    f"station {self.station}: no answer within {allowed // 1_000_000} ms"
                )
            yield Pause(_POLL_NS)

    def _full(self) -> Steps[bool]:
        status = yield from read(self.station, _SM1 + _STATUS, 1)
        return bool(status[0] & _FULL)

    def _fetch(self) -> Steps[Message | None]:
        """Read the message that waits; None if it is an emergency, a double or broken."""
        try:
            data = yield from self._take()
        except (FrameLost, NoAnswer):
            # the slave may have sent it already: request it once more
            yield from self._request_repeat()
            data = yield from read(self.station, self.incoming.start, self.incoming.length)
        message = Message.decode(data)
        if isinstance(message, MailboxError):
            return None
        if message.counter and message.counter == self._last_received:
            return None
        self._last_received = message.counter
        body = message.data
        if (
            message.protocol == MailboxProtocol.COE
            and len(body) >= _EMERGENCY_SIZE
            and body[1] >> 4 == CoeService.EMERGENCY
        ):
            self._emergency(body[2:_EMERGENCY_SIZE])
            return None
        return message

    def _take(self) -> Steps[bytes]:
        """Return the bytes of the message that waits; its last byte frees the mailbox."""
        station, start, length = self.station, self.incoming.start, self.incoming.length
        if not self.split_writes:
            return (yield from read(station, start, length, tries=1))
        head = yield from read(station, start, _LENGTH_SIZE)  # frees nothing
        size = min(_HEADER_SIZE + int.from_bytes(head, "little"), length)
        fetch = DatagramCommand.FPRD
        parts = [Datagram.at(fetch, station, start, bytes(size))]
        if size < length:
            parts.append(Datagram.at(fetch, station, start + length - 1, b"\0"))
        back = yield Trip(tuple(parts), 1)
        for each in back.datagrams:
            if each.counter != 1:
                raise NoAnswer(station, each.ado, each.counter)
        return back.datagrams[0].data

    def _request_repeat(self) -> Steps[None]:
        """Toggle the repeat bit, wait until the slave has done the same, then for the message."""
        self.repeats += 1
        self._last_received = 0  # it comes with the same counter
        (activate,) = yield from read(self.station, _SM1 + _ACTIVATE, 1)
        activate ^= _REPEAT
        yield from write(self.station, _SM1 + _ACTIVATE, bytes((activate,)))
        start = yield from now()
        while True:
            time_ns = yield from now()
            _, control = yield from read(self.station, _SM1 + _ACTIVATE, 2)
            if not (control ^ activate) & _REPEAT and (yield from self._full()):
                return
            if time_ns - start >= self.request_ns:
                raise MailboxTimeout(f"station {self.station}: a lost message is not repeated")
            yield Pause(_POLL_NS)
