"""A device whose answers the test writes: variables, services, and misbehaviour on request."""

import contextlib
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from enum import StrEnum
from typing import Any, NamedTuple

from achse.ams import Command, DecodeError, DeviceError, Frame, NetId
from achse.ams.commands import ERROR_PADDING, RESULT, Request, decode_request
from achse.codes import ReturnCode
from achse.devices.plc import PlcDevice
from achse.iec import GlobalVariables, Typelike, var
from achse.plc import PlcRuntime, Task
from achse.router import Router
from achse.server import IndexGroup
from achse.server.table import Reader
from achse.testing.addresses import free_host
from achse.testing.clock import ManualClock
from achse.testing.live import Live
from achse.transport.tcp.listener import TCP_PORT, TcpListener

Answer = bytes | Callable[[], bytes]


class MisdeedKind(StrEnum):
    """Fault of a `FakeDevice` in its answers."""

    NO_REPLY = "no_reply"
    WRONG_INVOKE_ID = "wrong_invoke_id"
    TRUNCATE = "truncate"
    """The answer lacks its last bytes."""
    ERROR = "error"
    """The result has an error."""
    ROUTER_ERROR = "router_error"
    """The AMS header has an error."""


class _Misdeed(NamedTuple):
    kind: MisdeedKind
    code: int
    size: int
    command: int | None


class FakeDevice(PlcDevice):
    """A PLC without a program, for tests of clients.

        fake = FakeDevice({"MAIN.nCount": (UDINT, 7)})
        fake.answer(0x4020, 0, b"\\1\\2")           # a service; a function is called each time
        fake.misbehave("error", code=0x706)         # the next request is refused
        with fake.serving() as live:                # or fake.attach(router, 851)
            client_under_test(live.host)
        assert fake.requests[0].index_group == 0xF003

    `fake["MAIN.nCount"]` reads and sets a variable. `clock` moves only when the test says so;
    `tick(seconds)` moves it and sends the notifications that are due.
    """

    def __init__(
        self,
        variables: Mapping[str, tuple[Typelike, Any] | Typelike] | None = None,
        *,
        clock: ManualClock | None = None,
    ) -> None:
        self.clock = clock or ManualClock()
        self.requests: list[Request] = []
        """Every request, decoded, in order."""
        self.received: list[Frame] = []
        """The same as frames."""
        self._misdeeds: deque[_Misdeed] = deque()
        self._now: _Misdeed | None = None
        self._scripted: dict[int, _ScriptedGroup] = {}
        super().__init__(
            PlcRuntime([Task()], _units(variables or {}), name="Fake"), clock=self.clock
        )

    # values ----------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> Any:
        """Return the value of a variable. KeyError if there is none."""
        symbol = self._symbol(name)
        return symbol.type.decode(symbol.read())

    def __setitem__(self, name: str, value: Any) -> None:
        symbol = self._symbol(name)
        symbol.write(symbol.type.encode(value))

    def _symbol(self, name: str) -> Any:
        assert self.symbols is not None
        symbol = self.symbols.source.resolve(name)
        if symbol is None:
            raise KeyError(name)
        return symbol

    def answer(self, group: int, offset: int, answer: Answer) -> None:
        """Answer Read and ReadWrite of this service. A function may raise DeviceError."""
        self._group(group).answers[offset] = answer

    def on_write(self, group: int, offset: int, take: Callable[[bytes], None]) -> None:
        """Hand what Write and ReadWrite bring for this service to `take`."""
        self._group(group).takers[offset] = take

    def _group(self, index_group: int) -> "_ScriptedGroup":
        group = self._scripted.get(index_group)
        if group is None:
            group = self._scripted[index_group] = _ScriptedGroup()
            group.behind = self.replace(index_group, group)
        return group

    def tick(self, seconds: float = 0.01) -> None:
        """Let time pass and send the notifications that are due then."""
        now = self.clock.advance(seconds)
        self.notifications.tick(now)
        self.sweep(now)

    def online_change(self) -> None:
        """Raise the symbol version: handles are stale."""
        self.plc.online_change()

    # misbehaviour ----------------------------------------------------------------------------

    def misbehave(
        self,
        kind: str,
        count: int = 1,
        *,
        code: int = ReturnCode.DEVICE_ERROR.number,
        size: int = 1,
        command: Command | None = None,
    ) -> None:
        """Disturb the next `count` requests (of one command, if given), in this order.

        "no_reply", "wrong_invoke_id", "truncate" (the answer lacks its last `size` bytes), "error"
        (`code` in the result), "router_error" (`code` in the header).
        """
        if kind not in set(MisdeedKind):
            raise ValueError(f"kind: expected one of {', '.join(MisdeedKind)}; got {kind!r}")
        self._misdeeds.extend([_Misdeed(MisdeedKind(kind), int(code), size, command)] * count)

    def deliver(self, frame: Frame) -> bool:
        if frame.is_response:
            return True
        self.received.append(frame)
        with contextlib.suppress(DecodeError):
            self.requests.append(decode_request(frame))
        misdeed = self._take(frame.command)
        if misdeed is None:
            return super().deliver(frame)
        if misdeed.kind is MisdeedKind.NO_REPLY:
            return True
        if misdeed.kind is MisdeedKind.ERROR:
            padding = ERROR_PADDING[Command(frame.command)]
            self._reply(frame.reply(RESULT.pack(misdeed.code) + padding))
        elif misdeed.kind is MisdeedKind.ROUTER_ERROR:
            self._reply(frame.reply(error=misdeed.code))
        else:
            self._now = misdeed
            super().deliver(frame)
            self._now = None
        return True

    def _take(self, command: int) -> _Misdeed | None:
        for number, misdeed in enumerate(self._misdeeds):
            if misdeed.command in (None, command):
                del self._misdeeds[number]
                return misdeed
        return None

    def _reply(self, response: Frame) -> None:
        if self._now is not None:
            if self._now.kind is MisdeedKind.TRUNCATE:
                response.data = response.data[: -self._now.size]
            else:
                response.invoke_id ^= 0x8000_0000
        super()._reply(response)

    # on the network --------------------------------------------------------------------------

    @contextlib.contextmanager
    def serving(self, port: int = 851, host: str | None = None) -> Iterator[Live]:
        """Listen on a loopback address of its own, at TCP port 48898, in another thread.

        The NetId is the address with .1.1 behind it. Notifications go out at `live.run(fake.tick)`.
        """
        where = free_host() if host is None else host

        @contextlib.asynccontextmanager
        async def open() -> AsyncIterator[tuple[str, int]]:
            router = Router(NetId(f"{where}.1.1"))
            self.attach(router, port)
            listener = TcpListener(router)
            await listener.open(where, TCP_PORT)
            try:
                yield listener.host, listener.port
            finally:
                await listener.close()

        with Live(open) as live:
            yield live


def _units(variables: Mapping[str, Any]) -> list[type[GlobalVariables]]:
    """One variable list per first part of the names."""
    lists: dict[str, dict[str, Any]] = {}
    for name, declared in variables.items():
        unit, dot, member = name.partition(".")
        if not dot or "." in member:
            raise ValueError(f"a variable is named LIST.NAME, got {name!r}")
        type, *initial = declared if isinstance(declared, tuple) else (declared,)
        lists.setdefault(unit, {})[member] = var(type, *initial)
    return [_declared(unit, members) for unit, members in lists.items()]


def _declared(unit: str, members: dict[str, Any]) -> type[GlobalVariables]:
    return type(unit, (GlobalVariables,), members)


class _ScriptedGroup(IndexGroup):
    """Answers what the test wrote down, and hands on the rest."""

    def __init__(self) -> None:
        self.behind: IndexGroup | None = None
        self.answers: dict[int, Answer] = {}
        self.takers: dict[int, Callable[[bytes], None]] = {}

    def _beyond(self, group: int) -> IndexGroup:
        if self.behind is None:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"0x{group:X}")
        return self.behind

    def reader(self, group: int, offset: int, length: int, client: bytes) -> Reader:
        answer = self.answers.get(offset)
        if answer is None:
            return self._beyond(group).reader(group, offset, length, client)
        if callable(answer):
            ask = answer
            return lambda: ask()[:length]
        return lambda: self.answers[offset][:length]  # type: ignore[index]

    def write(self, group: int, offset: int, data: bytes, client: bytes) -> None:
        take = self.takers.get(offset)
        if take is None:
            self._beyond(group).write(group, offset, data, client)
        else:
            take(data)

    def read_write(
        self, group: int, offset: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        known = offset in self.answers or offset in self.takers
        if not known:
            return self._beyond(group).read_write(group, offset, read_length, data, client)
        if offset in self.takers:
            self.takers[offset](data)
        if offset not in self.answers:
            return b""
        return self.reader(group, offset, read_length, client)()
