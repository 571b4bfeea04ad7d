"""A device with memory and symbols on a real router, driven by a clock that tests own."""

import struct
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import pytest

from achse.ams import AdsState, AmsAddress, Command, DeviceError, Frame, NetId
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteRequest,
    decode_response,
)
from achse.ams.notification import NotificationStream
from achse.router import Router
from achse.server import (
    READ,
    WRITE,
    AreaGroup,
    ClientLimits,
    Device,
    Group,
    Layout,
    Service,
    TableSizes,
)

MS = 1_000_000
START = 1_800_000_000_000_000_000
TASK = 10 * MS


class Variable:
    """A symbol with its own bytes; a method if `call` is given."""

    index_group = 0x4040

    def __init__(
        self,
        size: int,
        offset: int = 0,
        read_only: bool = False,
        context: int = 0,
        call: Callable[[bytes], bytes] | None = None,
    ) -> None:
        self.memory = bytearray(size)
        self.index_offset = offset
        self.size = size
        self.read_only = read_only
        self.context = context
        self.call = call
        self.fault: Exception | None = None

    def read(self) -> bytes:
        if self.fault is not None:
            raise self.fault
        return bytes(self.memory)

    def write(self, data: bytes) -> None:
        self.memory[: len(data)] = data

    def entry(self) -> bytes:
        """A symbol entry of a `DINT` called `x`, without comment and GUID."""
        head = (40, self.index_group, self.index_offset, self.size, 3, 0, 0, 1, 4, 0)
        return struct.pack("<5I5H", *head) + b"x\0DINT\0\0" + bytes(2)

    @property
    def number(self) -> int:
        return int.from_bytes(self.memory, "little")

    @number.setter
    def number(self, value: int) -> None:
        self.memory[:] = value.to_bytes(self.size, "little")


class Source:
    """Symbols by lower-case name."""

    def __init__(self) -> None:
        self.version = 7
        self.symbols = {
            "main.ncounter": Variable(4, 16),
            "main.text": Variable(81, 32),
            "main.fixed": Variable(2, read_only=True),
            "main.fast": Variable(4, context=1),
            "main.fb#sum": Variable(0, call=lambda data: bytes([sum(data) & 0xFF])),
        }

    def resolve(self, name: str) -> Variable | None:
        if name == "MAIN.a[9]":
            raise DeviceError(0x721)
        return self.symbols.get(name.lower())

    def upload_info(self) -> TableSizes:
        return TableSizes(symbol_count=2, type_count=1)

    def symbol_table(self) -> bytes:
        return bytes(range(160))

    def type_table(self) -> bytes:
        return b"type" * 24

    def type_entry(self, name: str) -> bytes | None:
        return b"DINT entry" if name.lower() == "dint" else None


class Machine:
    """What the rows of the bench refer to."""

    def __init__(self) -> None:
        self.velocity = 1.5
        self.override = 100


class Client:
    """An endpoint that keeps what it gets; `congested` as a connection would say it."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.congested = False
        self.open = True

    def deliver(self, frame: Frame) -> bool:
        if self.open:
            self.frames.append(frame)
        return self.open


class PlcLike(Device):
    """Two tasks, and states like a PLC."""

    accepted_states: ClassVar[Mapping[int, AdsState]] = {
        AdsState.RUN: AdsState.RUN,
        AdsState.STOP: AdsState.STOP,
        AdsState.RESET: AdsState.STOP,
    }

    def task_cycle(self, context: int) -> int:
        return 2 * MS if context == 1 else self.task_cycle_ns


class Bench:
    """One device, one registered client, and the station's clock."""

    def __init__(self, limits: ClientLimits | None = None, **options: Any) -> None:
        self.now = START
        self.machine = Machine()
        self.memory = bytearray(range(64))
        self.source = Source()
        self.router = Router(NetId("5.1.2.3.1.1"))
        self.device = PlcLike(
            "Plc30 App",
            (3, 1, 4024),
            (
                Group(
                    0x1000,
                    (
                        Service(
                            1,
                            "velocity",
                            READ | WRITE,
                            Layout("<d"),
                            "Velocity.",
                            "mm/s",
                            field="velocity",
                            minimum=0.0,
                            maximum=100.0,
                            code=0x4221,
                        ),
                        Service(2, "override", READ, Layout("<H"), field="override"),
                        Service(3, "broken", READ, Layout("<H"), read=lambda machine: 1 // 0),
                    ),
                    self.machine,
                ),
                AreaGroup(0x4020, self._read, self._write, name="memory"),
            ),
            self.source,
            clock=lambda: self.now,
            task_cycle_ns=TASK,
            limits=limits,
            **options,
        )
        self.address = self.device.attach(self.router, 851)
        self.client = Client()
        self.me = self.router.register(0, self.client)
        self.invoke_id = 0

    def _read(self, offset: int, length: int) -> bytes:
        if offset >= 64:
            raise DeviceError(0x703)
        return bytes(self.memory[offset : offset + min(length, 64)])

    def _write(self, offset: int, data: bytes) -> None:
        if offset + len(data) > 64:
            raise DeviceError(0x705)
        self.memory[offset : offset + len(data)] = data

    def send(
        self, command: int, data: bytes, source: bytes = b"", origin: Client | None = None
    ) -> None:
        self.invoke_id += 1
        frame = Frame(self.address, source or self.me, command, 4, 0, self.invoke_id, data)
        frame.origin = origin or self.client
        self.router.deliver(frame)

    def raw(self, command: int, data: bytes, **way: Any) -> bytes:
        """The data of the answer; notifications that come behind it stay in the client."""
        client: Client = way.get("origin") or self.client
        before = len(client.frames)
        self.send(command, data, **way)
        answer = client.frames.pop(before)
        assert answer.invoke_id == self.invoke_id
        assert answer.flags == 5
        assert answer.error == 0
        return answer.data

    def ask(self, request: Any, **way: Any) -> Any:
        """The decoded answer to a request."""
        command = {
            ReadRequest: Command.READ,
            WriteRequest: Command.WRITE,
            ReadWriteRequest: Command.READ_WRITE,
            AddNotificationRequest: Command.ADD_NOTIFICATION,
            DeleteNotificationRequest: Command.DELETE_NOTIFICATION,
        }[type(request)]
        data = self.raw(command, request.encode(), **way)
        return decode_response(Frame(self.me, self.address, command, 5, data=data))

    def read(self, group: int, offset: int, length: int, **way: Any) -> tuple[int, bytes]:
        return tuple(self.ask(ReadRequest(group, offset, length), **way))

    def write(self, group: int, offset: int, data: bytes, **way: Any) -> int:
        return int(self.ask(WriteRequest(group, offset, data), **way).result)

    def exchange(
        self, group: int, offset: int, length: int, data: bytes, **way: Any
    ) -> tuple[int, bytes]:
        return tuple(self.ask(ReadWriteRequest(group, offset, length, data), **way))

    def handle(self, name: str, **way: Any) -> int:
        result, data = self.exchange(0xF003, 0, 4, name.encode(), **way)
        assert result == 0
        return int.from_bytes(data, "little")

    def subscribe(
        self,
        name: str,
        mode: int = 4,
        *,
        cycle_ms: float = 0,
        delay_ms: float = 0,
        length: int = 4,
        **way: Any,
    ) -> int:
        request = AddNotificationRequest(
            0xF005,
            self.handle(name, **way),
            length,
            mode,
            round(delay_ms * 10_000),
            round(cycle_ms * 10_000),
        )
        answer = self.ask(request, **way)
        assert answer.result == 0
        return int(answer.handle)

    def tick(self, milliseconds: float = 2, until: Callable[[], None] | None = None) -> None:
        """Run base ticks of 2 ms; `until` is called before each, as a cycle would be."""
        for _ in range(round(milliseconds / 2)):
            self.now += 2 * MS
            if until is not None:
                until()
            self.device.notifications.tick(self.now)
            self.device.sweep(self.now)

    def samples(self, client: Client | None = None) -> list[tuple[int, int, bytes]]:
        """(ms since the start, handle, data) of all notifications since the last call."""
        client = client or self.client
        frames, client.frames = client.frames, []
        samples = []
        for frame in frames:
            assert frame.command == Command.NOTIFICATION
            assert (frame.flags, frame.invoke_id, frame.error) == (4, 0, 0)
            for filetime, stamped in NotificationStream.decode(frame.data).stamps:
                unix_ns = (filetime - 116_444_736_000_000_000) * 100
                samples += [((unix_ns - START) // MS, *sample) for sample in stamped]
        return samples

    def join(self, port: int = 0) -> tuple[Client, AmsAddress]:
        """Another client of the same router."""
        client = Client()
        return client, self.router.register(port, client)


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture(scope="session")
def make_bench() -> Callable[..., Bench]:
    return Bench
