"""A loop with virtual time, and a scripted target: tests of the client neither sleep nor dial."""

import asyncio
import struct
from collections.abc import Callable, Coroutine, Iterator
from functools import partial
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, DeviceError, Frame, NetId
from achse.ams.commands import (
    AddNotificationRequest,
    AddNotificationResponse,
    DataResponse,
    DeleteNotificationRequest,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ReadWriteRequest,
    ResultResponse,
    WriteControlRequest,
    WriteRequest,
    decode_request,
)
from achse.ams.notification import encode_stream
from achse.testing import VirtualTimeLoop

ADDRESS = AmsAddress("5.4.3.2.1.1:851")


@pytest.fixture
def run() -> Iterator[Callable[[Coroutine[Any, Any, Any]], Any]]:
    """Run a coroutine in virtual time; whatever it leaves behind is an error."""
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:

        def run_it(main: Coroutine[Any, Any, Any]) -> Any:
            async def checked() -> Any:
                result = await main
                left = asyncio.all_tasks() - {asyncio.current_task()}
                assert not left, f"left running: {left}"
                return result

            return runner.run(checked())

        yield run_it


@pytest.fixture
def run_for_real() -> Callable[[Coroutine[Any, Any, Any]], Any]:
    """Run a coroutine in an ordinary loop: for sockets and threads."""
    return asyncio.run


class PeerLink:
    """A link whose other end is a `Peer`; frames cross at the next turn of the loop."""

    max_packet = None

    def __init__(self, peer: "Peer", user: Any, port: int) -> None:
        self.peer = peer
        self.user = user
        self.address = AmsAddress.of(NetId("9.9.9.9.1.1"), port)
        self.peer_net_id = ADDRESS.net_id
        self.open = True
        self.loop = asyncio.get_running_loop()

    def send(self, frame: Frame) -> None:
        self.loop.call_soon(self._cross, Frame.decode(frame.encode()))

    def _cross(self, frame: Frame) -> None:
        if self.open:
            self.peer.receive(frame)

    def close(self) -> None:
        self.open = False
        self.peer.link = None

    async def wait_closed(self) -> None:
        """Return at once."""

    def abort(self) -> None:
        self.lose("aborted")

    def lose(self, reason: str = "cut") -> None:
        """End as a broken cable does."""
        if self.open:
            self.close()
            self.peer.forget_client()
            self.loop.call_soon(self.user.lost, self, reason)


class Peer:
    """A scripted target, and the dialer to it.

    `variables` maps names to `[type name, ADST id, bytes]`; handles, symbol entries, sums and
    notifications work on them. Switches: `mute` swallows requests, `refuse_dials` makes that many
    connections fail, `not_offered` names index groups that answer 0x701.
    """

    peer = "peer"

    def __init__(self) -> None:
        self.variables: dict[str, list[Any]] = {}
        self.raw: dict[tuple[int, int], bytes] = {}
        self.types: dict[str, bytes] = {}
        self.requests: list[Any] = []
        self.not_offered: set[int] = set()
        self.mute = False
        self.refuse_dials = 0
        self.dials = 0
        self.version = 1
        self.error = 0
        self.link: PeerLink | None = None
        self.handles: dict[int, str] = {}
        self.notifications: dict[int, AddNotificationRequest] = {}
        self.released: list[int] = []
        self.state = (5, 0)
        self._last_handle = 100
        self._last_notification = 0

    async def open(self, user: Any) -> PeerLink:
        self.dials += 1
        if self.refuse_dials:
            self.refuse_dials -= 1
            raise ConnectionRefusedError("nobody there")
        self.link = PeerLink(self, user, 40000 + self.dials)
        return self.link

    def lose(self) -> None:
        assert self.link is not None
        self.link.lose()

    def forget_client(self) -> None:
        self.handles.clear()
        self.notifications.clear()

    def online_change(self) -> None:
        """All handles go stale, and those who watch the version hear of it."""
        self.version += 1
        self.handles.clear()
        for number, request in list(self.notifications.items()):
            if request.index_group == 0xF008:
                self.push((number, bytes([self.version])))
            else:
                del self.notifications[number]

    def requests_of(self, kind: type[Any], group: int | None = None) -> list[Any]:
        """The requests of one kind so far."""
        return [r for r in self.requests if type(r) is kind and group in (None, r[0])]

    # frames ----------------------------------------------------------------------------------

    def receive(self, frame: Frame) -> None:
        request = decode_request(frame)
        self.requests.append(request)
        if self.mute:
            return
        if self.error:
            self.reply(frame.reply(error=self.error))
            return
        kind: type[Any] = type(request)
        first: bytes | None = None
        try:
            if frame.command == Command.READ_DEVICE_INFO:
                payload = ReadDeviceInfoResponse(0, 3, 1, 4024, "Scripted").encode()
            elif frame.command == Command.READ_STATE:
                payload = ReadStateResponse(0, *self.state).encode()
            elif kind is ReadRequest:
                payload = DataResponse(0, self.read(*request)).encode()
            elif kind is WriteRequest:
                self.write(*request)
                payload = ResultResponse(0).encode()
            elif kind is ReadWriteRequest:
                payload = DataResponse(0, self.read_write(*request)).encode()
            elif isinstance(request, AddNotificationRequest):
                number = self.add(request)
                payload = AddNotificationResponse(0, number).encode()
                first = self.first_sample(number)
            elif isinstance(request, DeleteNotificationRequest):
                self.delete(request.handle)
                payload = ResultResponse(0).encode()
            else:
                assert isinstance(request, WriteControlRequest)
                self.state = (request.ads_state, request.device_state)
                payload = ResultResponse(0).encode()
        except DeviceError as error:
            padding = {ReadRequest: 4, ReadWriteRequest: 4, AddNotificationRequest: 4}.get(kind, 0)
            payload = ResultResponse(error.code).encode() + bytes(padding)
        self.reply(frame.reply(payload))
        if first is not None:
            self.push((self._last_notification, first))

    def reply(self, frame: Frame) -> None:
        if self.link is not None:
            self.link.user.received(frame)

    def push(
        self,
        *samples: tuple[int, bytes],
        filetime: int = 133_000_000_000_000_000,
        flags: int = 4,
    ) -> None:
        """Send a notification frame with one stamp."""
        assert self.link is not None
        data = encode_stream([(filetime, list(samples))])
        self.link.user.received(Frame(self.link.address, ADDRESS, 8, flags, 0, 0, data))

    def push_first(self, number: int) -> None:
        """Send the first sample of a subscription."""
        self.push((number, self.first_sample(number)))

    def change(self, name: str, data: bytes) -> None:
        """Give a variable a value and tell its subscribers."""
        self.variables[name][2] = data
        self.push(
            *[
                (number, data)
                for number, request in self.notifications.items()
                if self.handles.get(request.index_offset) == name
            ]
        )

    # services --------------------------------------------------------------------------------

    def read(self, group: int, offset: int, length: int) -> bytes:
        self._offer(group)
        if group == 0xF005:
            return bytes(self._variable(offset)[2][:length])
        if group == 0xF008:
            return bytes([self.version])
        if group == 0xF00C:
            table = self._table()
            return struct.pack("<II", len(self.variables), len(table))
        if group == 0xF00B:
            return self._table()[:length]
        if (group, offset) in self.raw:
            return self.raw[group, offset][:length]
        raise DeviceError(0x702)

    def write(self, group: int, offset: int, data: bytes) -> None:
        self._offer(group)
        if group == 0xF005:
            variable = self._variable(offset)
            if len(data) > len(variable[2]):
                raise DeviceError(0x705)
            variable[2] = data + variable[2][len(data) :]
        elif group == 0xF006:
            number = int.from_bytes(data, "little")
            self.released.append(number)
            if self.handles.pop(number, None) is None:
                raise DeviceError(0x710)
        elif (group, offset) in self.raw:
            self.raw[group, offset] = data
        else:
            raise DeviceError(0x702)

    def read_write(self, group: int, offset: int, length: int, data: bytes) -> bytes:
        self._offer(group)
        match group:
            case 0xF003:
                name = self._name(data)
                self._last_handle += 1
                self.handles[self._last_handle] = name
                return struct.pack("<I", self._last_handle)
            case 0xF009:
                return self.entry(self._name(data))
            case 0xF011:
                name = data.rstrip(b"\0").decode()
                if name not in self.types:
                    raise DeviceError(0x710)
                return self.types[name]
            case 0xF080:
                lengths = [n for _, _, n in struct.iter_unpack("<III", data)]
                outcomes = [
                    self._outcome(self.read, *part) for part in struct.iter_unpack("<III", data)
                ]
                return b"".join(
                    [struct.pack("<I", result) for result, _ in outcomes]
                    + [read.ljust(n, b"\0") for (_, read), n in zip(outcomes, lengths, strict=True)]
                )
            case 0xF081:
                position = 12 * offset
                results = []
                for part_group, part_offset, n in struct.iter_unpack("<III", data[:position]):
                    part = data[position : position + n]
                    results.append(self._outcome(self.write, part_group, part_offset, part)[0])
                    position += n
                return struct.pack(f"<{offset}I", *results)
            case 0xF082:
                position = 16 * offset
                outcomes = []
                for g, o, read_length, n in struct.iter_unpack("<IIII", data[:position]):
                    part = data[position : position + n]
                    outcomes.append(self._outcome(self.read_write, g, o, read_length, part))
                    position += n
                return b"".join(
                    [struct.pack("<II", result, len(read)) for result, read in outcomes]
                    + [read for _, read in outcomes]
                )
            case 0xF085:
                outcomes = []
                for position in range(0, 40 * offset, 40):
                    wanted = AddNotificationRequest.decode(data[position : position + 40])
                    outcomes.append(self._outcome(lambda p: struct.pack("<I", self.add(p)), wanted))
                loop = asyncio.get_running_loop()
                for result, number in outcomes:
                    if result == 0:
                        key = int.from_bytes(number, "little")
                        loop.call_soon(partial(self.push_first, key))
                return b"".join(struct.pack("<I", r) + n.ljust(4, b"\0") for r, n in outcomes)
            case 0xF086:
                return b"".join(
                    struct.pack("<I", self._outcome(self.delete, number)[0])
                    for (number,) in struct.iter_unpack("<I", data)
                )
        raise DeviceError(0x702)

    def _outcome(self, service: Callable[..., Any], *arguments: Any) -> tuple[int, bytes]:
        try:
            return 0, service(*arguments) or b""
        except DeviceError as error:
            return error.code, b""

    def add(self, request: AddNotificationRequest) -> int:
        self._offer(request.index_group)
        if request.index_group == 0xF005:
            self._variable(request.index_offset)
        elif request.index_group != 0xF008 and request[:2] not in self.raw:
            raise DeviceError(0x702)
        self._last_notification += 1
        self.notifications[self._last_notification] = request
        return self._last_notification

    def first_sample(self, number: int) -> bytes:
        return self.read(*self.notifications[number][:3])

    def delete(self, number: int) -> None:
        if self.notifications.pop(number, None) is None:
            raise DeviceError(0x714)

    def _offer(self, group: int) -> None:
        if group in self.not_offered:
            raise DeviceError(0x701)

    def _variable(self, handle: int) -> list[Any]:
        if handle not in self.handles:
            raise DeviceError(0x710)
        return self.variables[self.handles[handle]]

    def _name(self, data: bytes) -> str:
        text = data.rstrip(b"\0").decode("cp1252").casefold()
        for name in self.variables:
            if name.casefold() == text:
                return name
        raise DeviceError(0x710)

    def entry(self, name: str) -> bytes:
        """The symbol entry of a variable, as 0xF009 answers."""
        type_name, adst, data = self.variables[name]
        texts = name.encode() + b"\0" + type_name.encode() + b"\0\0"
        size = (30 + len(texts) + 7) // 8 * 8
        offset = list(self.variables).index(name) * 64
        head = struct.pack(
            "<IIIIIHHHHH",
            size, 0x4040, offset, len(data), adst, 0, 0, len(name), len(type_name), 0,
        )  # fmt: skip
        return (head + texts).ljust(size, b"\0")  # type: ignore[no-any-return]

    def _table(self) -> bytes:
        return b"".join(self.entry(name) for name in self.variables)


@pytest.fixture
def peer() -> Peer:
    """A scripted target with a few variables."""
    target = Peer()
    target.variables["MAIN.nCounter"] = ["UDINT", 19, struct.pack("<I", 7)]
    target.variables["GVL.fValue"] = ["LREAL", 5, struct.pack("<d", 1.5)]
    target.variables["GVL.sText"] = ["STRING(10)", 30, b"hello".ljust(11, b"\0")]
    target.raw[0x4020, 0] = b"\1\2\3\4"
    return target
