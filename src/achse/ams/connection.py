"""The byte stream of AMS/TCP, without a socket: bytes in, frames out."""

from collections.abc import Iterator

from achse.ams.errors import DecodeError
from achse.ams.frame import AMS_HEADER, TCP_HEADER, Frame, TcpCommand, TcpMessage

Event = Frame | TcpMessage

DEFAULT_MAX_LENGTH = 64 * 1024 * 1024
"""A packet announced longer than this (bytes) is a decode error, before anything is allocated."""

_TCP_COMMANDS = {command.value: command for command in TcpCommand}

_MAX_SERVICE_LENGTH = 64
"""No port service takes more bytes than these; the longest known takes 8."""


class Connection:
    """The receiving half of one AMS/TCP connection.

    `receive(data)` takes any slice of the stream and yields what is complete, in order. However
    the stream is cut, the same events come out. Bytes that are not AMS/TCP raise `DecodeError`, at
    their place in the order; afterwards the connection is of no use and every call raises again.
    """

    __slots__ = ("_failure", "_needed", "_pending", "max_length")

    def __init__(self, max_length: int = DEFAULT_MAX_LENGTH) -> None:
        self.max_length = max_length
        self._pending = bytearray()
        self._needed = 0
        self._failure = ""

    @property
    def pending(self) -> int:
        """Buffered bytes that do not make a packet yet."""
        return len(self._pending)

    @property
    def missing(self) -> int:
        """Bytes still missing for the next step of the buffered ones."""
        return self._needed - len(self._pending)

    def receive(self, data: bytes) -> Iterator[Event]:
        """Yield every event that `data` completes. Iterate to the end before the next call."""
        if self._failure:
            raise DecodeError(self._failure)
        if self._pending:
            self._pending += data
            if len(self._pending) < self._needed:
                return
            data = bytes(self._pending)
            self._pending = bytearray()
        position, end = 0, len(data)
        try:
            while end - position >= 6:
                command, length = TCP_HEADER.unpack_from(data, position)
                start = position + 6
                stop = start + length
                if command:
                    self._check_service(command, length)
                    if stop > end:
                        self._needed = 6 + length
                        break
                    yield TcpMessage(_TCP_COMMANDS[command], data[start:stop])
                    position = stop
                    continue
                if length < 32:
                    raise DecodeError(f"an AMS packet has at least 32 bytes, got {length}")
                if length > self.max_length:
                    raise DecodeError(
                        f"a packet of {length} bytes is announced, the limit is {self.max_length}"
                    )
                if end - start < 32:
                    self._needed = 38
                    break
                target, source, ads, flags, size, error, invoke_id = AMS_HEADER.unpack_from(
                    data, start
                )
                if size != length - 32:
                    raise DecodeError(
                        f"the AMS header announces {size} bytes of data, the packet has"
                        f" {length - 32}"
                    )
                if stop > end:
                    self._needed = 6 + length
                    break
                yield Frame(target, source, ads, flags, error, invoke_id, data[start + 32 : stop])
                position = stop
            else:
                self._needed = 6
        except DecodeError as failure:
            self._failure = str(failure)
            raise
        if position < end:
            self._pending += data[position:]

    def drop(self) -> None:
        """Drop the buffered bytes: nothing more is received."""
        self._pending = bytearray()

    def _check_service(self, command: int, length: int) -> None:
        if command not in _TCP_COMMANDS:
            raise DecodeError(f"AMS/TCP command 0x{command:04X} is not known")
        if length > _MAX_SERVICE_LENGTH:
            raise DecodeError(
                f"a port service takes at most {_MAX_SERVICE_LENGTH} bytes, {length} are announced"
            )
