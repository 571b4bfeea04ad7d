"""Raw access to one ADS device: group and offset, bytes in and out, and its state."""

import struct
from collections.abc import Callable, Sequence
from typing import NamedTuple

from achse.ams import AdsState, AmsAddress, Command, DecodeError, DeviceError, Frame
from achse.ams.commands import (
    RESULT,
    RESULT_LENGTH,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ReadWriteRequest,
    WriteControlRequest,
    WriteRequest,
)
from achse.client.session.session import Session
from achse.client.session.sums import (
    MAX_BYTES,
    Outcome,
    Part,
    batches,
    command_of,
    outcome,
    sum_of,
    unpack,
)
from achse.codes import PlcGroup, ReservedGroup, ReturnCode

_INFO = int(Command.READ_DEVICE_INFO)
_READ = int(Command.READ)
_WRITE = int(Command.WRITE)
_STATE = int(Command.READ_STATE)
_CONTROL = int(Command.WRITE_CONTROL)
_READ_WRITE = int(Command.READ_WRITE)

Look = Callable[[int, bytes, Sequence[Outcome]], None]

NOT_OFFERED = frozenset({ReturnCode.SERVICE_NOT_SUPPORTED.number, ReturnCode.INVALID_GROUP.number})
"""Errors of a device without the requested service: 0x701, or 0x702 for an unknown group."""


AREAS = frozenset(
    {
        *(ReservedGroup.INPUTS, ReservedGroup.OUTPUTS),
        *(PlcGroup.FLAGS, PlcGroup.RETAIN, PlcGroup.DATA),
    }
)
"""Groups whose offset counts bytes, so that a part of what is there can be read."""

_RESPONSE_HEAD = 32 + 8
"""AMS header, result and length."""

_SUM_HEAD = 16
"""Bytes of a sum request before its parts, beyond those of a response."""

STALE = frozenset({ReturnCode.SYMBOL_NOT_FOUND.number, ReturnCode.SYMBOL_VERSION_INVALID.number})
"""Errors for a symbol handle that is out of date: 0x710, 0x711."""


class DeviceInfo(NamedTuple):
    """Name (16 characters at most) and version of a device."""

    name: str
    major: int
    minor: int
    build: int


class DeviceState(NamedTuple):
    """ADS state (an `AdsState` where the number is one) and device state."""

    ads_state: AdsState | int
    device_state: int


class RawTarget:
    """One AMS port at the other end of a session; makes requests, holds nothing."""

    def __init__(self, session: Session, address: AmsAddress, timeout: float) -> None:
        self.session = session
        self.address = address
        self.timeout = timeout
        self._no_sums: set[type[Part]] = set()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.address} at {self.session.dialer.peer})"

    # the commands ----------------------------------------------------------------------------

    async def device_info(self) -> DeviceInfo:
        """Name and version (000 §3.2.3.1)."""
        response = await self.session.exchange(self.address, _INFO, b"", self.timeout)
        self._check(response, "read device info")
        # A test server that many use does not fill the name up to 16 bytes.
        info = ReadDeviceInfoResponse.decode(response.data.ljust(24, b"\0"))
        return DeviceInfo(info.name, info.major, info.minor, info.build)

    async def state(self) -> DeviceState:
        """ADS state and device state (000 §3.2.3.4)."""
        response = await self.session.exchange(self.address, _STATE, b"", self.timeout)
        self._check(response, "read state")
        _, ads_state, device_state = ReadStateResponse.decode(response.data)
        try:
            return DeviceState(AdsState(ads_state), device_state)
        except ValueError:
            return DeviceState(ads_state, device_state)

    async def write_control(self, ads_state: int, device_state: int = 0, data: bytes = b"") -> None:
        """Ask for another state (000 §3.2.3.5); `data` is read by few devices."""
        request = _encoded(WriteControlRequest(ads_state, device_state, data))
        response = await self.session.exchange(self.address, _CONTROL, request, self.timeout)
        self._check(response, "ask for state", ads_state)

    async def read_raw(self, group: int, offset: int, length: int) -> bytes:
        """Read up to `length` bytes; devices may answer fewer.

        Over a link with short packets a read of an area of memory goes in pieces.
        """
        most = self.longest_read
        if most is not None and length > most and group in AREAS:
            return await self._read_in_pieces(group, offset, length, most)
        response = await self.session.exchange(
            self.address, _READ, _encoded(ReadRequest(group, offset, length)), self.timeout
        )
        return self._data(response, "read", group, offset)

    @property
    def longest_read(self) -> int | None:
        """Bytes that one response brings over this link at most; None: any number."""
        link = self.session.link
        packet = None if link is None else link.max_packet
        return None if packet is None else packet - _RESPONSE_HEAD

    async def _read_in_pieces(self, group: int, offset: int, length: int, most: int) -> bytes:
        data = b""
        while len(data) < length:
            wanted = min(most, length - len(data))
            request = _encoded(ReadRequest(group, offset + len(data), wanted))
            response = await self.session.exchange(self.address, _READ, request, self.timeout)
            piece = self._data(response, "read", group, offset + len(data))
            data += piece
            if len(piece) < wanted:
                break
        return data

    async def write_raw(self, group: int, offset: int, data: bytes) -> None:
        """Write `data`."""
        response = await self.session.exchange(
            self.address, _WRITE, _encoded(WriteRequest(group, offset, data)), self.timeout
        )
        self._check(response, "write", group, offset)

    async def read_write_raw(self, group: int, offset: int, read_length: int, data: bytes) -> bytes:
        """Write `data` and read up to `read_length` bytes in one call."""
        request = _encoded(ReadWriteRequest(group, offset, read_length, data))
        response = await self.session.exchange(self.address, _READ_WRITE, request, self.timeout)
        return self._data(response, "read/write", group, offset)

    def _data(self, response: Frame, *what: str | int) -> bytes:
        data = response.data
        if len(data) < 8:
            self._check(response, *what)
        result, length = RESULT_LENGTH.unpack_from(data)
        if result:
            raise self._refusal(result, what)
        if length != len(data) - 8:
            raise DecodeError(
                f"{self._what(what)}: {length} bytes are announced, {len(data) - 8} came"
            )
        return data[8:]

    def _check(self, response: Frame, *what: str | int) -> None:
        """Raise what `response` says went wrong, even where its layout is cut short after that."""
        data = response.data
        if len(data) < 4:
            raise DecodeError(f"{self._what(what)}: a response has a result, got {len(data)} bytes")
        (result,) = RESULT.unpack_from(data)
        if result:
            raise self._refusal(result, what)
        if len(data) < 8 and response.command in (_READ, _READ_WRITE):
            raise DecodeError(f"{self._what(what)}: 8 bytes or more, got {len(data)}")

    def _refusal(self, code: int, what: Sequence[str | int]) -> DeviceError:
        return DeviceError(code, self._what(what))

    def _what(self, what: Sequence[str | int]) -> str:
        verb, *place = what
        where = ":".join(f"0x{number:X}" for number in place if isinstance(number, int))
        return f"{verb} {where} of {self.address}" if where else f"{verb} of {self.address}"

    # many at once ----------------------------------------------------------------------------

    async def send_each(
        self,
        parts: Sequence[Part],
        look: Look | None = None,
    ) -> list[Outcome]:
        """Send requests of one kind, in sums of at most 500, and give each one's outcome.

        A single one travels alone, and so do all if the target answers that it has no such sum
        (0x701, 0x702). `look(first, source, outcomes)` sees outcomes the moment they come, before
        any frame behind them: those of `parts[first:]`, answered by the device `source`.
        """
        outcomes: list[Outcome] = []
        most = MAX_BYTES if (room := self.longest_read) is None else room - _SUM_HEAD
        for batch in batches(parts, most):
            if len(batch) > 1 and type(batch[0]) not in self._no_sums:
                try:
                    outcomes += await self._send_sum(batch, len(outcomes), look)
                    continue
                except DeviceError as error:
                    if error.code not in NOT_OFFERED:
                        raise
                    self._no_sums.add(type(batch[0]))
            for part in batch:
                outcomes.append(await self._send_alone(part, len(outcomes), look))
        return outcomes

    async def _send_sum(
        self,
        parts: Sequence[Part],
        first: int,
        look: Look | None,
    ) -> list[Outcome]:
        request = sum_of(parts)
        outcomes: list[Outcome] = []

        def read(response: Frame) -> None:
            if not response.error:
                data = self._data(response, "sum", request.index_group)
                outcomes.extend(unpack(parts, data))
                if look is not None:
                    look(first, response.source, outcomes)

        await self.session.exchange(self.address, _READ_WRITE, request.encode(), self.timeout, read)
        return outcomes

    async def _send_alone(
        self,
        part: Part,
        first: int,
        look: Look | None,
    ) -> Outcome:
        outcomes: list[Outcome] = []

        def read(response: Frame) -> None:
            if not response.error:
                outcomes.append(outcome(response))
                if look is not None:
                    look(first, response.source, outcomes)

        await self.session.exchange(
            self.address, command_of(part), part.encode(), self.timeout, read
        )
        return outcomes[0]


def _encoded(request: ReadRequest | WriteRequest | ReadWriteRequest | WriteControlRequest) -> bytes:
    """Return the bytes of `request`. ValueError if a number or its data do not fit into it."""
    try:
        return request.encode()
    except (struct.error, TypeError):
        most = "0xFFFF" if isinstance(request, WriteControlRequest) else "0xFFFFFFFF"
        fields = ", ".join(f"{name}={value!r:.40}" for name, value in request._asdict().items())
        raise ValueError(f"expected numbers 0..{most}, and bytes as data, got {fields}") from None
