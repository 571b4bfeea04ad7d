"""The byte stream of AMS/TCP, without a socket: bytes in, frames out."""

from collections.abc import Iterator

from achse.ams.errors import DecodeError
from achse.ams.frame import AMS_HEADER, TCP_HEADER, Frame, TcpCommand, TcpMessage

__all__ = ["DEFAULT_MAX_LENGTH", "Connection", "Event"]

Event = Frame | TcpMessage

DEFAULT_MAX_LENGTH = 64 * 1024 * 1024
"""A packet announced longer than this (bytes) is a decode error, before anything is allocated."""

_TCP_COMMANDS = {command.value: command for command in TcpCommand}


class Connection:
    """The receiving half of one AMS/TCP connection.

    `receive(data)` takes any slice of the stream and yields what is complete, in order. However
    the stream is cut, the same events come out. Bytes that are no AMS/TCP raise `DecodeError`, at
    their place in the order; afterwards the connection is of no use and every call raises again.
    """

    __slots__ = ("_failure", "_pending", "max_length")

    def __init__(self, max_length: int = DEFAULT_MAX_LENGTH) -> None:
        self.max_length = max_length
        self._pending = bytearray()
        self._failure: DecodeError | None = None

    @property
    def pending(self) -> int:
        """Bytes held that do not make a packet yet."""
        return len(self._pending)

    def receive(self, data: bytes) -> Iterator[Event]:
        """Yield every event that `data` completes. Iterate to the end before the next call."""
        if self._failure is not None:
            raise self._failure
        stream: bytes | bytearray = data
        if self._pending:
            self._pending += data
            stream = self._pending
        position = 0
        try:
            end = len(stream)
            while end - position >= 6:
                command, length = TCP_HEADER.unpack_from(stream, position)
                if command not in _TCP_COMMANDS:
                    raise DecodeError(f"AMS/TCP command 0x{command:04X} is not known")
                if length > self.max_length:
                    raise DecodeError(
                        f"a packet of {length} bytes is announced, the limit is {self.max_length}"
                    )
                start = position + 6
                if command:
                    if length > 64:
                        raise DecodeError(
                            f"a port service takes at most 64 bytes, {length} are announced"
                        )
                    if end - start < length:
                        break
                    position = start + length
                    yield TcpMessage(_TCP_COMMANDS[command], bytes(stream[start:position]))
                    continue
                if length < 32:
                    raise DecodeError(f"an AMS packet has at least 32 bytes, got {length}")
                if end - start < 32:
                    break
                target, source, ads, flags, size, error, invoke_id = AMS_HEADER.unpack_from(
                    stream, start
                )
                if size != length - 32:
                    raise DecodeError(
                        f"the AMS header announces {size} bytes of data, the packet has"
                        f" {length - 32}"
                    )
                if end - start < length:
                    break
                position = start + length
                yield Frame(
                    target,
                    source,
                    ads,
                    flags,
                    error,
                    invoke_id,
                    bytes(stream[start + 32 : position]),
                )
        except DecodeError as failure:
            self._failure = failure
            self._pending = bytearray()
            raise
        if stream is self._pending:
            del self._pending[:position]
        else:
            self._pending += data[position:]
