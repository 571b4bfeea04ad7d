"""AMS frames: the 32-byte header with its data, and the 6-byte header that carries it over TCP.

Source: 000 §3.2, 002 §5; the TCP port commands come from recorded traffic.
"""

import struct
from enum import IntEnum, IntFlag
from typing import NamedTuple, Protocol

from achse.ams.address import AmsAddress
from achse.ams.errors import DecodeError

TCP_HEADER = struct.Struct("<HI")
"""AMS/TCP header: command, length of what follows."""

AMS_HEADER = struct.Struct("<8s8sHHIII")
"""AMS header: target, source, command, state flags, data length, error code, invoke id."""

_TCP_AND_AMS = struct.Struct("<HI8s8sHHIII")


class TcpCommand(IntEnum):
    """Kind of an AMS/TCP packet. The manuals print the field as reserved, 0."""

    AMS = 0x0000
    PORT_CLOSE = 0x0001
    PORT_CONNECT = 0x1000
    ROUTER_NOTE = 0x1001
    GET_LOCAL_NET_ID = 0x1002


class Command(IntEnum):
    """ADS commands (000 §3.2.3)."""

    READ_DEVICE_INFO = 1
    READ = 2
    WRITE = 3
    READ_STATE = 4
    WRITE_CONTROL = 5
    ADD_NOTIFICATION = 6
    DELETE_NOTIFICATION = 7
    NOTIFICATION = 8
    READ_WRITE = 9


class Flags(IntFlag):
    """State flags of the AMS header."""

    RESPONSE = 0x0001
    NO_RESPONSE = 0x0002
    ADS_COMMAND = 0x0004
    SYSTEM_COMMAND = 0x0008
    HIGH_PRIORITY = 0x0010
    TIMESTAMP = 0x0020
    UDP = 0x0040
    INIT_COMMAND = 0x0080
    BROADCAST = 0x8000


class Endpoint(Protocol):
    """A receiver of frames: a device, a client, a connection to a peer."""

    def deliver(self, frame: "Frame") -> bool:
        """Take `frame`; False if this endpoint is closed and the frame is lost."""
        ...


class Frame:
    """One AMS packet.

    `target` and `source` are the 8 wire bytes (an `AmsAddress` or a slice equal to one).
    `flags` is the plain number, see `Flags`; `error` is the AMS error code (routers only).

    Two marks never travel: `origin` is where a received frame came in, `via` where a frame has to
    go out whatever its target says. Clients that share one AMS address (two processes behind one
    host do) are distinguished by them.
    """

    __slots__ = (
        "command",
        "data",
        "error",
        "flags",
        "invoke_id",
        "origin",
        "source",
        "target",
        "via",
    )

    def __init__(
        self,
        target: bytes,
        source: bytes,
        command: int,
        flags: int = 0x0004,
        error: int = 0,
        invoke_id: int = 0,
        data: bytes = b"",
    ) -> None:
        self.target = target
        self.source = source
        self.command = command
        self.flags = flags
        self.error = error
        self.invoke_id = invoke_id
        self.data = data
        self.origin: Endpoint | None = None
        self.via: Endpoint | None = None

    @classmethod
    def decode(cls, packet: bytes) -> "Frame":
        """Return a frame from a whole AMS packet (header and data, without the TCP header)."""
        if len(packet) < 32:
            raise DecodeError(f"an AMS packet has at least 32 bytes, got {len(packet)}")
        target, source, command, flags, length, error, invoke_id = AMS_HEADER.unpack_from(packet)
        if length != len(packet) - 32:
            raise DecodeError(
                f"the AMS header announces {length} bytes of data, the packet has"
                f" {len(packet) - 32}"
            )
        return cls(target, source, command, flags, error, invoke_id, bytes(packet[32:]))

    def encode(self) -> bytes:
        """Return the AMS packet: header and data."""
        data = self.data
        return (
            AMS_HEADER.pack(
                self.target,
                self.source,
                self.command,
                self.flags,
                len(data),
                self.error,
                self.invoke_id,
            )
            + data
        )

    def encode_tcp(self) -> bytes:
        """Return the AMS packet behind its AMS/TCP header."""
        data = self.data
        size = len(data)
        return (
            _TCP_AND_AMS.pack(
                0,
                32 + size,
                self.target,
                self.source,
                self.command,
                self.flags,
                size,
                self.error,
                self.invoke_id,
            )
            + data
        )

    @property
    def is_response(self) -> bool:
        return bool(self.flags & 1)

    @property
    def sender(self) -> dict[str, str]:
        """Sender as fields of a log record: `client` is its AMS address, `peer` host and port if
        known."""
        return {
            "client": str(AmsAddress(self.source)),
            "peer": getattr(self.origin, "peer", ""),
        }

    def reply(self, data: bytes = b"", error: int = 0) -> "Frame":
        """Return the response to this request: addresses swapped, invoke id and command kept.

        It leaves by the way the request came in.
        """
        response = Frame(
            self.source,
            self.target,
            self.command,
            self.flags | 1,
            error,
            self.invoke_id,
            data,
        )
        response.via = self.origin
        return response

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Frame) and self.encode() == other.encode()

    __hash__ = None  # type: ignore[assignment]  # frames are mutable: routers rewrite addresses

    def __repr__(self) -> str:
        return (
            f"Frame({AmsAddress(self.source)} → {AmsAddress(self.target)},"
            f" command={self.command}, flags=0x{self.flags:04X}, error=0x{self.error:X},"
            f" invoke_id={self.invoke_id}, data={self.data.hex(' ')})"
        )


class TcpMessage(NamedTuple):
    """An AMS/TCP packet that is not an AMS frame: port services of the local router."""

    command: TcpCommand
    data: bytes

    def encode_tcp(self) -> bytes:
        return TCP_HEADER.pack(self.command, len(self.data)) + self.data
