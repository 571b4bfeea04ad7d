"""Conformance rules for every device and every transport, checked from outside."""

import asyncio
import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractAsyncContextManager
from typing import Any, Protocol

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import ERROR_PADDING
from achse.codes import ReservedGroup, ReturnCode
from achse.router import Router
from achse.server import READ, READ_WRITE, WRITE, Device, RowFacts

_PORT = 26_999
_NET_ID = NetId("5.0.0.1.1.1")
_PLACE = struct.Struct("<III")
_INTERNAL = ReturnCode.INTERNAL_ERROR.number
_READ_LENGTHS = (0, 1, 4, 1024, 0xFFFF_FFFF)
_OFTEN = 256
"""Index groups with more objects are looked at through the first ones."""


class ConformanceError(AssertionError):
    """Violation of one or more rules; one line per violation."""


class _Client:
    """Sends requests to a device through a router and checks the answers bit by bit."""

    def __init__(self, device: Device) -> None:
        self.router = Router(_NET_ID)
        self.target = device.attach(self.router, _PORT)
        self.address = self.router.register(0, self)
        self.frames: list[Frame] = []
        self._invoke_id = 0

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True

    def request(self, command: int, data: bytes = b"") -> Frame:
        """Return the answer; what else came (samples) is dropped."""
        self._invoke_id += 1
        self.frames.clear()
        self.router.deliver(Frame(self.target, self.address, command, 4, 0, self._invoke_id, data))
        answers = [frame for frame in self.frames if frame.is_response]
        if len(answers) != 1:
            raise ConformanceError(f"command {command}: {len(answers)} answers")
        return answers[0]

    def result(self, command: int, data: bytes = b"") -> int:
        answer = self.request(command, data)
        return int.from_bytes(answer.data[:4], "little")


def check_device(make_device: Callable[[], Device], *, rows: bool = True) -> None:
    """Demand of a device what clients rely on; raises ConformanceError with all that is wrong.

    - it knows name, version and state, and refuses unknown commands, groups and offsets;
    - each error reply has its full length and the invoke id of its request;
    - no answer is longer than requested, none fails inside (0x1), whatever the length;
    - a sum answers as the single requests do;
    - a notification handle ends with Delete, and is refused (0x714) afterwards.

    With `rows`, every row of the device's table is read and every writable one refuses a wrong
    size. Writes may act: each group of checks has a device of its own.
    """
    faults = [
        *_basics(_Client(make_device())),
        *_notifications(_Client(make_device())),
    ]
    if rows:
        device = make_device()
        faults += _rows(_Client(device), list(device.services.describe()))
    if faults:
        raise ConformanceError("\n".join(faults))


def _basics(client: _Client) -> Iterator[str]:
    info = client.request(Command.READ_DEVICE_INFO)
    if len(info.data) != 24 or any(info.data[:4]) or not info.data[8:].rstrip(b"\0"):
        yield f"Read Device Info answers {info.data.hex(' ')}"
    state = client.request(Command.READ_STATE)
    if len(state.data) != 8 or any(state.data[:4]):
        yield f"Read State answers {state.data.hex(' ')}"
    unknown = client.request(0x77)
    if not unknown.error:
        yield "an unknown command is not refused in the AMS header"
    nowhere = 0x7777_0001
    for command, data in (
        (Command.READ, _PLACE.pack(nowhere, 0, 4)),
        (Command.WRITE, _PLACE.pack(nowhere, 0, 4) + bytes(4)),
        (Command.READ_WRITE, struct.pack("<4I", nowhere, 0, 4, 0)),
        (Command.ADD_NOTIFICATION, struct.pack("<6I16x", nowhere, 0, 4, 4, 0, 0)),
        (Command.DELETE_NOTIFICATION, struct.pack("<I", 0x7777)),
        (Command.WRITE_CONTROL, struct.pack("<HHI", 0xFFFF, 0, 0)),
        *((command, b"\1\2\3") for command in Command if command != Command.NOTIFICATION),
    ):
        answer = client.request(command, data)
        size = 4 + len(ERROR_PADDING[Command(command)])
        if not any(answer.data[:4]):
            yield f"{command.name} with {data.hex(' ')} is not refused"
        elif len(answer.data) != size:
            yield f"a refused {command.name} has {len(answer.data)} bytes, expected {size}"
    parts = b"".join(_PLACE.pack(group, 0, 2) for group in (ReservedGroup.DEVICE, nowhere))
    sum_data = struct.pack("<4I", ReservedGroup.SUM_READ, 2, 12, len(parts)) + parts
    answer = client.request(Command.READ_WRITE, sum_data)
    if len(answer.data) != 20 or answer.data[8:12] != bytes(4) or answer.data[12:16] == bytes(4):
        yield f"a sum read of a good and a bad part answers {answer.data.hex(' ')}"


def _notifications(client: _Client) -> Iterator[str]:
    body = struct.pack("<6I16x", ReservedGroup.DEVICE, 0, 4, 4, 0, 100_000)
    answer = client.request(Command.ADD_NOTIFICATION, body)
    samples = [frame for frame in client.frames if frame.command == Command.NOTIFICATION]
    if len(answer.data) != 8 or any(answer.data[:4]):
        yield f"Add Notification of the state (0xF100) answers {answer.data.hex(' ')}"
        return
    if not samples:
        yield "the first sample does not come after the Add"
    elif client.frames.index(samples[0]) < client.frames.index(answer):
        yield "the first sample comes before the answer to the Add"
    handle = answer.data[4:8]
    if client.result(Command.DELETE_NOTIFICATION, handle):
        yield "Delete Notification is refused"
    code = client.result(Command.DELETE_NOTIFICATION, handle)
    if code != ReturnCode.NOTIFICATION_HANDLE_INVALID.number:
        yield f"a deleted notification handle is answered 0x{code:X}, expected 0x714"


def _rows(client: _Client, rows: list[RowFacts]) -> Iterator[str]:
    for row in rows:
        group, offset = row.index_group, row.index_offset
        where = f"{row.name} (0x{group:X}:0x{offset:X})"
        for length in _READ_LENGTHS:
            answer = client.request(Command.READ, _PLACE.pack(group, offset, length))
            if len(answer.data) < 8:
                yield f"{where}: an answer to a read has {len(answer.data)} bytes, 8 are the least"
                break
            code, size = struct.unpack_from("<II", answer.data)
            if code == _INTERNAL:
                yield f"{where}: a read of {length} bytes fails inside"
            elif size > length or len(answer.data) != 8 + size:
                yield f"{where}: a read of {length} bytes answers {len(answer.data) - 8}"
            elif READ not in row.access and not code:
                yield f"{where}: can be read, its row says {row.access}"
        if row.access & (READ | READ_WRITE) and WRITE not in row.access:
            request = _PLACE.pack(group, offset, 1) + b"\0"
            if not client.result(Command.WRITE, request):
                yield f"{where}: can be written, its row says {row.access}"


class TransportEnd(Protocol):
    """One end of a transport: sends frames, and keeps what came."""

    @property
    def frames(self) -> list[Frame]: ...

    def deliver(self, frame: Frame) -> bool: ...


Ends = tuple[TransportEnd, TransportEnd]


async def check_transport(
    open_pair: Callable[[], AbstractAsyncContextManager[Ends]],
    settle: Callable[[], Any] | None = None,
) -> None:
    """Demand of a transport that frames arrive whole, once and in order, in both directions.

    `open_pair()` gives two connected ends; `settle()` is called, and awaited if it can be, until
    what was sent has arrived. Raises ConformanceError.
    """
    faults: list[str] = []
    sizes = [0, 1, 31, 32, 33, 1459, 1460, 65_535, 65_536, 1 << 20]
    async with open_pair() as ends:
        for number, (sender, receiver) in enumerate((ends, ends[::-1])):
            direction = ("there", "back")[number]
            frames = [_frame(number, i, sizes[i % len(sizes)]) for i in range(3 * len(sizes))]
            taken = [sender.deliver(frame) for frame in frames]
            if not all(taken):
                faults.append(f"{direction}: an open end did not take a frame")
            deadline = asyncio.get_running_loop().time() + 10
            while len(receiver.frames) < len(frames):
                waited = settle() if settle is not None else None
                if asyncio.iscoroutine(waited):
                    await waited
                await asyncio.sleep(0)
                if asyncio.get_running_loop().time() > deadline:
                    break
            came = receiver.frames
            if len(came) != len(frames):
                faults.append(f"{direction}: {len(frames)} frames sent, {len(came)} arrived")
            elif wrong := [i for i, frame in enumerate(frames) if came[i] != frame]:
                faults.append(f"{direction}: frame {wrong[0]} is another one or out of order")
    if faults:
        raise ConformanceError("\n".join(faults))


def _frame(direction: int, number: int, size: int) -> Frame:
    source, target = AmsAddress("5.0.0.1.1.1:30000"), AmsAddress("5.0.0.2.1.1:30001")
    if direction:
        source, target = target, source
    data = bytes((number + i) & 0xFF for i in range(min(size, 251)))
    data = (data * (size // max(len(data), 1) + 1))[:size]
    return Frame(target, source, Command.READ_WRITE, 4, 0, number, data)
