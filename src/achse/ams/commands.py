"""The nine ADS commands as requests and responses (000 §3.2.3).

Each class is the data part of one frame: `encode()` gives its bytes, `decode(data)` reads them or
raises `DecodeError`. `decode_request` and `decode_response` pick the class by the frame's command.
A response that reports an error still has its full length, zero filled: real clients parse the
layout before they look at the result.
"""

import struct
from typing import NamedTuple, Self

from achse.ams.errors import DecodeError
from achse.ams.frame import Command, Frame
from achse.ams.notification import NotificationStream

READ = struct.Struct("<III")
READ_WRITE = struct.Struct("<IIII")
WRITE_CONTROL = struct.Struct("<HHI")
RESULT = struct.Struct("<I")
RESULT_LENGTH = struct.Struct("<II")
RESULT_STATE = struct.Struct("<IHH")
DEVICE_INFO = struct.Struct("<IBBH16s")
ADD_NOTIFICATION_BODY = struct.Struct("<IIIIII16x")
"""Group, offset, length, transmission mode, max delay, cycle time (both 100 ns), 16 reserved.

The manuals print the times in ms; real targets and clients use 100 ns.
"""

ERROR_PADDING = {
    Command.READ_DEVICE_INFO: bytes(20),
    Command.READ: bytes(4),
    Command.WRITE: b"",
    Command.READ_STATE: bytes(4),
    Command.WRITE_CONTROL: b"",
    Command.ADD_NOTIFICATION: bytes(4),
    Command.DELETE_NOTIFICATION: b"",
    Command.READ_WRITE: bytes(4),
}
"""Padding after the result in an error response, so that the layout is complete."""


def _expect(data: bytes, size: int, what: str) -> None:
    if len(data) != size:
        raise DecodeError(f"{what} has {size} bytes, got {len(data)}")


def _expect_at_least(data: bytes, size: int, what: str) -> None:
    if len(data) < size:
        raise DecodeError(f"{what} has at least {size} bytes, got {len(data)}")


class EmptyRequest(NamedTuple):
    """Read Device Info or Read State: nothing but the command."""

    def encode(self) -> bytes:
        return b""

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 0, "a Read Device Info or Read State request")
        return cls()


class ReadRequest(NamedTuple):
    """Read `length` bytes. Lengths far above the value are usual: never allocate by it."""

    index_group: int
    index_offset: int
    length: int

    def encode(self) -> bytes:
        return READ.pack(*self)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 12, "a Read request")
        return cls._make(READ.unpack(data))


class WriteRequest(NamedTuple):
    """Write `data`."""

    index_group: int
    index_offset: int
    data: bytes

    def encode(self) -> bytes:
        return READ.pack(self.index_group, self.index_offset, len(self.data)) + self.data

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect_at_least(data, 12, "a Write request")
        group, offset, length = READ.unpack_from(data)
        _expect(data, 12 + length, f"a Write request with {length} bytes of data")
        return cls(group, offset, data[12:])


class ReadWriteRequest(NamedTuple):
    """Write `data` and read up to `read_length` bytes in one call."""

    index_group: int
    index_offset: int
    read_length: int
    data: bytes

    def encode(self) -> bytes:
        return (
            READ_WRITE.pack(self.index_group, self.index_offset, self.read_length, len(self.data))
            + self.data
        )

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect_at_least(data, 16, "a Read Write request")
        group, offset, read_length, length = READ_WRITE.unpack_from(data)
        _expect(data, 16 + length, f"a Read Write request with {length} bytes of data")
        return cls(group, offset, read_length, data[16:])


class WriteControlRequest(NamedTuple):
    """Ask for an ADS state and device state; `data` is read by few devices."""

    ads_state: int
    device_state: int
    data: bytes = b""

    def encode(self) -> bytes:
        return WRITE_CONTROL.pack(self.ads_state, self.device_state, len(self.data)) + self.data

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect_at_least(data, 8, "a Write Control request")
        ads_state, device_state, length = WRITE_CONTROL.unpack_from(data)
        _expect(data, 8 + length, f"a Write Control request with {length} bytes of data")
        return cls(ads_state, device_state, data[8:])


class AddNotificationRequest(NamedTuple):
    """Subscribe to `length` bytes; `max_delay` and `cycle_time` in 100 ns."""

    index_group: int
    index_offset: int
    length: int
    mode: int
    max_delay: int
    cycle_time: int

    def encode(self) -> bytes:
        return ADD_NOTIFICATION_BODY.pack(*self)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 40, "an Add Notification request")
        return cls._make(ADD_NOTIFICATION_BODY.unpack(data))


class DeleteNotificationRequest(NamedTuple):
    """End the subscription `handle`."""

    handle: int

    def encode(self) -> bytes:
        return RESULT.pack(self.handle)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 4, "a Delete Notification request")
        return cls._make(RESULT.unpack(data))


class ReadDeviceInfoResponse(NamedTuple):
    """Version (major 1, minor 1, build 2 bytes) and name (cp1252, cut or NUL padded to 16)."""

    result: int
    major: int = 0
    minor: int = 0
    build: int = 0
    name: str = ""

    def encode(self) -> bytes:
        return DEVICE_INFO.pack(
            self.result,
            self.major,
            self.minor,
            self.build,
            self.name.encode("cp1252", "replace"),
        )

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 24, "a Read Device Info response")
        result, major, minor, build, name = DEVICE_INFO.unpack(data)
        text = name.split(b"\0", 1)[0].decode("cp1252", "replace")
        return cls(result, major, minor, build, text)


class DataResponse(NamedTuple):
    """Answer to Read and Read Write."""

    result: int
    data: bytes = b""

    def encode(self) -> bytes:
        return RESULT_LENGTH.pack(self.result, len(self.data)) + self.data

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect_at_least(data, 8, "a Read response")
        result, length = RESULT_LENGTH.unpack_from(data)
        _expect(data, 8 + length, f"a Read response with {length} bytes of data")
        return cls(result, data[8:])


class ResultResponse(NamedTuple):
    """Answer to Write, Write Control and Delete Notification."""

    result: int

    def encode(self) -> bytes:
        return RESULT.pack(self.result)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 4, "a result")
        return cls._make(RESULT.unpack(data))


class ReadStateResponse(NamedTuple):
    """ADS state and device state."""

    result: int
    ads_state: int = 0
    device_state: int = 0

    def encode(self) -> bytes:
        return RESULT_STATE.pack(*self)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 8, "a Read State response")
        return cls._make(RESULT_STATE.unpack(data))


class AddNotificationResponse(NamedTuple):
    """The handle of the new subscription."""

    result: int
    handle: int = 0

    def encode(self) -> bytes:
        return RESULT_LENGTH.pack(*self)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        _expect(data, 8, "an Add Notification response")
        return cls._make(RESULT_LENGTH.unpack(data))


Request = (
    EmptyRequest
    | ReadRequest
    | WriteRequest
    | WriteControlRequest
    | AddNotificationRequest
    | DeleteNotificationRequest
    | NotificationStream
    | ReadWriteRequest
)
Response = (
    ReadDeviceInfoResponse
    | DataResponse
    | ResultResponse
    | ReadStateResponse
    | AddNotificationResponse
)

_REQUESTS: dict[int, type[Request]] = {
    Command.READ_DEVICE_INFO: EmptyRequest,
    Command.READ: ReadRequest,
    Command.WRITE: WriteRequest,
    Command.READ_STATE: EmptyRequest,
    Command.WRITE_CONTROL: WriteControlRequest,
    Command.ADD_NOTIFICATION: AddNotificationRequest,
    Command.DELETE_NOTIFICATION: DeleteNotificationRequest,
    Command.NOTIFICATION: NotificationStream,
    Command.READ_WRITE: ReadWriteRequest,
}
_RESPONSES: dict[int, type[Response]] = {
    Command.READ_DEVICE_INFO: ReadDeviceInfoResponse,
    Command.READ: DataResponse,
    Command.WRITE: ResultResponse,
    Command.READ_STATE: ReadStateResponse,
    Command.WRITE_CONTROL: ResultResponse,
    Command.ADD_NOTIFICATION: AddNotificationResponse,
    Command.DELETE_NOTIFICATION: ResultResponse,
    Command.READ_WRITE: DataResponse,
}


def decode_request(frame: Frame) -> Request:
    """Return the request in `frame`; raises `DecodeError` for an unknown command or wrong sizes."""
    kind = _REQUESTS.get(frame.command)
    if kind is None:
        raise DecodeError(f"ADS command {frame.command} is not one of 1..9")
    return kind.decode(frame.data)


def decode_response(frame: Frame) -> Response:
    """Return the response in `frame`; raises `DecodeError` for an unknown command or wrong sizes.

    An error of just four bytes is taken as well: some TwinCAT 2 devices answer so.
    """
    kind = _RESPONSES.get(frame.command)
    if kind is None:
        raise DecodeError(f"ADS command {frame.command} has no response")
    data = frame.data
    if len(data) == 4 and any(data):
        return kind(*RESULT.unpack(data))
    return kind.decode(data)
