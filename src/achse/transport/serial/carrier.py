"""AMS frames over a serial line: what fits goes, what does not is answered, at both ends alike.

Nothing in here opens a port: bytes come by `receive` and go by a callable. See `serial_port`.

Source: 000 §4.
"""

import logging
from collections.abc import Callable, Iterator

from achse.ams import Command, Connection, DecodeError, Flags, Frame, NotificationStream
from achse.ams.commands import AddNotificationRequest, DataResponse, ResultResponse
from achse.ams.notification import encode_stream
from achse.ams.serial import MAX_PACKET, SerialEnd
from achse.codes import ReturnCode
from achse.transport.connections.byte_transport import Scheduler, Timer

log = logging.getLogger("achse.serial")

_HEADER = 32

_INVOKE_ID = slice(28, 32)
"""Position of the invoke id in a packet."""

_STREAM_HEAD = 8
"""Length and number of stamps."""
_STAMP_HEAD, _SAMPLE_HEAD = 12, 8
"""Time stamp and number of samples; handle and size."""

_ROOM = MAX_PACKET - _HEADER - _STREAM_HEAD

LONGEST_SAMPLE = _ROOM - _STAMP_HEAD - _SAMPLE_HEAD
"""Bytes of the longest value that a notification can carry over a serial line: 195."""

_WITH_LENGTH = (Command.READ, Command.READ_WRITE)

_CONGESTED_SECONDS = 2.0

_FULL = 256 * 1024
"""Bytes that wait to be sent, at which new requests are not acknowledged: those who ask for long
answers faster than the line carries them have given up waiting long before."""

_REMEMBERED = 1024
"""Requests that failed here, whose answers may come late; the oldest is forgotten."""


class SerialCarrier:
    """Frames over one end of a line.

    `write` gets the bytes to send, `received` each frame that comes, and the answer to a request
    that cannot go: ADS result 0x705 if it is longer than a serial line carries, as are longer
    answers; AMS error 0x745 if it was not acknowledged, or the port is lost. An answer that comes
    behind this one is dropped. A notification of many samples is sent in
    several frames. `changed` is called when the number of unsent bytes changes.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        write: Callable[[bytes], object],
        received: Callable[[Frame], object],
        *,
        baud: int,
        changed: Callable[[], object] = bool,
    ) -> None:
        self.end = SerialEnd(baud)
        self._scheduler = scheduler
        self._write = write
        self._received = received
        self._changed = changed
        self._timer: Timer | None = None
        self._timer_at = 0.0
        self._closed = False
        self._told_lost = False
        self._failed: dict[tuple[bytes, bytes, int], None] = {}
        """Requests that have their answer, 0x745."""

    @property
    def unsent(self) -> int:
        """Bytes that are not acknowledged yet."""
        return self.end.unsent

    @property
    def congested_at(self) -> int:
        """Unsent bytes from which on others had better wait: two seconds of the line."""
        return int(self.end.baud / 10 * _CONGESTED_SECONDS)

    def send(self, frame: Frame) -> None:
        """Send `frame`, or say why it cannot go."""
        if self._closed:
            return
        if self._failed and not frame.is_response:
            self._failed.pop((frame.source, frame.target, frame.invoke_id), None)
        packet = frame.encode()
        if len(packet) <= MAX_PACKET and not _requests_too_much(frame):
            self.end.send(packet, self._scheduler.time())
        elif frame.command == Command.NOTIFICATION:
            for part in self._parts(frame):
                self.end.send(part.encode(), self._scheduler.time())
        elif frame.is_response:
            self.end.send(_too_long(frame).encode(), self._scheduler.time())
        elif not frame.flags & Flags.NO_RESPONSE:
            answer = _too_long(frame.reply())
            self._scheduler.call_soon(lambda: self._pass(answer))
        self._settle()

    def receive(self, data: bytes) -> None:
        """Take bytes as they come."""
        if not self._closed:
            self._take(self.end.receive(data, self._scheduler.time()))

    def give_up(self) -> None:
        """Answer unacknowledged requests at once: the port is lost."""
        self.end.give_up()
        while self.end.undelivered:
            answer = self._failure_of(Frame.decode(self.end.undelivered.popleft()))
            if answer is not None:
                self._pass(answer)

    def close(self) -> None:
        """Close: nothing is received or sent any more."""
        self._closed = True
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    # -------------------------------------------------------------------------------------------

    def _take(self, packets: list[bytes]) -> None:
        for packet in packets:
            try:
                frame = Frame.decode(packet)
            except DecodeError as fault:
                log.info("a serial frame with a good checksum carries no AMS packet: %s", fault)
                continue
            if frame.is_response:
                if self._is_late(frame):
                    continue
                if self._answers(frame, self.end.waiting):
                    self.end.confirm(self._scheduler.time())
            elif _requests_too_much(frame):
                self.end.send(_too_long(frame.reply()).encode(), self._scheduler.time())
                continue
            self._pass(frame)
        self._settle()

    @staticmethod
    def _answers(response: Frame, packet: bytes | None) -> bool:
        """Return True if `response` answers the request that the packet carries."""
        if packet is None or packet[_INVOKE_ID] != response.invoke_id.to_bytes(4, "little"):
            return False
        request = Frame.decode(packet)
        return (
            not request.is_response
            and request.target == response.source
            and request.source == response.target
        )

    def _is_late(self, response: Frame) -> bool:
        """Return True if the request of `response` has been answered here with 0x745."""
        key = (response.target, response.source, response.invoke_id)
        return bool(self._failed) and self._failed.pop(key, key) is None

    def _pass(self, frame: Frame) -> None:
        if not self._closed:
            self._received(frame)

    def _settle(self) -> None:
        """Write what is due, report abandoned frames, and set the timer."""
        if self._closed:
            return
        data = self.end.take(self._scheduler.time())
        if data:
            self._write(data)
        while self.end.undelivered:
            self._lost(Frame.decode(self.end.undelivered.popleft()))
        self.end.full = self.end.unsent > _FULL
        self._changed()
        deadline = self.end.deadline
        if self._timer is not None and (deadline is None or deadline != self._timer_at):
            self._timer.cancel()
            self._timer = None
        if deadline is not None and self._timer is None and not self._closed:
            self._timer_at = deadline
            self._timer = self._scheduler.call_at(deadline, self._due)

    def _due(self) -> None:
        self._timer = None
        if self._closed:
            return
        # A timer may be early by its resolution.
        self._take(self.end.due(max(self._scheduler.time(), self._timer_at)))

    def _lost(self, frame: Frame) -> None:
        if not self._told_lost:
            self._told_lost = True
            log.warning("frames are not acknowledged, %s was the first", frame)
        answer = self._failure_of(frame)
        if answer is not None:
            self._scheduler.call_soon(lambda: self._pass(answer))

    def _failure_of(self, frame: Frame) -> Frame | None:
        """Return the answer 0x745 to a request; None for what wants none."""
        if frame.is_response or frame.command == Command.NOTIFICATION:
            return None
        if frame.flags & Flags.NO_RESPONSE:
            return None
        self._failed[frame.source, frame.target, frame.invoke_id] = None
        if len(self._failed) > _REMEMBERED:
            del self._failed[next(iter(self._failed))]
        return frame.reply(error=ReturnCode.CLIENT_TIMEOUT.number)

    def _parts(self, frame: Frame) -> Iterator[Frame]:
        """Yield a notification in several frames, its samples in order."""
        try:
            stream = NotificationStream.decode(frame.data)
        except DecodeError:
            return
        gathered: list[tuple[int, list[tuple[int, bytes]]]] = []
        room = _ROOM
        for stamp in stream.stamps:
            for sample in stamp.samples:
                size = _STAMP_HEAD + _SAMPLE_HEAD + len(sample.data)
                if size > _ROOM:
                    continue  # its subscription was refused here: it was made over another way
                if size > room:
                    yield _with_data(frame, encode_stream(gathered))
                    gathered, room = [], _ROOM
                gathered.append((stamp.filetime, [(sample.handle, sample.data)]))
                room -= size
        if gathered:
            yield _with_data(frame, encode_stream(gathered))


def _with_data(frame: Frame, data: bytes) -> Frame:
    head = (frame.target, frame.source, frame.command, frame.flags, frame.error, frame.invoke_id)
    return Frame(*head, data)


def _requests_too_much(frame: Frame) -> bool:
    """Return True if `frame` subscribes to samples that are too long for a serial frame."""
    if frame.command != Command.ADD_NOTIFICATION or frame.is_response:
        return False
    try:
        return AddNotificationRequest.decode(frame.data).length > LONGEST_SAMPLE
    except DecodeError:
        return False  # the device says what is wrong with it


def _too_long(response: Frame) -> Frame:
    """`response` with result 0x705 in place of what it carries."""
    code = ReturnCode.INVALID_SIZE.number
    with_length = response.command in _WITH_LENGTH
    result = DataResponse(code, b"") if with_length else ResultResponse(code)
    return _with_data(response, result.encode())


class SerialTransport:
    """A serial line as the transport of a `Peer`: its bytes are AMS/TCP, those of the line are
    not."""

    def __init__(
        self, carrier: SerialCarrier, close: Callable[[], object], abort: Callable[[], object]
    ) -> None:
        self.carrier = carrier
        self._close = close
        self._abort = abort
        self._packets = Connection()

    def write(self, data: bytes, /) -> None:
        for event in self._packets.receive(data):
            if isinstance(event, Frame):
                self.carrier.send(event)

    def get_write_buffer_size(self) -> int:
        return self.carrier.unsent

    def close(self) -> None:
        self._close()

    def abort(self) -> None:
        self._abort()

    def pause_reading(self) -> None:
        """Do nothing: a serial line brings little."""

    def resume_reading(self) -> None:
        """Do nothing: reading was never paused."""
