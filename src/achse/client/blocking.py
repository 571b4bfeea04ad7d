"""The client without asyncio: the same core, on a loop of its own in a background thread.

    with achse.blocking.connect("127.0.0.1", net_id="127.0.0.1.1.1") as plc:
        value = plc.read("MAIN.nCounter")
        with plc.subscribe("MAIN.nCounter", cycle_time=0.1) as samples:
            for sample in samples:
                ...

Any thread may use a client; requests of several threads are under way at the same time.
"""

import asyncio
from collections.abc import Iterable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, overload

from achse.ams import AdsError, AmsAddress, NetId
from achse.client import client, subscription, target
from achse.client.link import Mode
from achse.client.loop import LoopThread
from achse.client.raw import DeviceInfo, DeviceState
from achse.client.secure_link import SecureTarget
from achse.client.session import Advance, Backoff
from achse.client.subscription import Sample
from achse.client.target import SendWhen
from achse.iec import IecType, Method, Typelike
from achse.iec.symbols import SymbolEntry
from achse.iec.typetable import TypeTable

if TYPE_CHECKING:
    from achse.client.nc.blocking import RemoteNc
    from achse.client.scope import Channels, Triggers
    from achse.client.scope_blocking import BlockingScope

__all__ = ["Client", "Subscription", "Target", "connect"]


class Target:
    """One ADS device; see `achse.client.Target`, whose methods these are."""

    def __init__(self, loop: LoopThread, inner: target.Target) -> None:
        self._loop = loop
        self._inner = inner

    def __repr__(self) -> str:
        return repr(self._inner)

    @property
    def address(self) -> AmsAddress:
        return self._inner.address

    def at_port(self, port: int, net_id: str | NetId | None = None) -> "Target":
        """Another device, over the same connection."""
        return Target(self._loop, self._inner.at_port(port, net_id))

    def within(self, seconds: float) -> "Target":
        """The same device, with another time limit for each request."""
        return Target(self._loop, self._inner.within(seconds))

    @property
    def nc(self) -> "RemoteNc":
        """The NC beside this device: `client.nc.axis("X").move_to(300, velocity=200)`."""
        from achse.client.nc.blocking import RemoteNc  # loaded when axes are used

        return RemoteNc(self._loop, self._inner.nc)

    def scope(
        self,
        channels: "Channels",
        *,
        length: float = 10.0,
        triggers: "Triggers" = (),
        pretrigger: float = 0.0,
        combine: str = "any",
        name: str = "client",
    ) -> "BlockingScope":
        """A scope at the achse station behind this target; `with` makes and starts it."""
        from achse.client.scope_blocking import BlockingScope  # loaded when scopes are used

        inner = self._inner.scope(
            channels,
            length=length,
            triggers=triggers,
            pretrigger=pretrigger,
            combine=combine,
            name=name,
        )
        return BlockingScope(self._loop, inner)

    def device_info(self) -> DeviceInfo:
        """Name and version."""
        return self._loop.run(self._inner.device_info())

    def state(self) -> DeviceState:
        """ADS state and device state."""
        return self._loop.run(self._inner.state())

    def write_control(self, ads_state: int, device_state: int = 0, data: bytes = b"") -> None:
        """Ask for another state."""
        self._loop.run(self._inner.write_control(ads_state, device_state, data))

    def read_raw(self, group: int, offset: int, length: int) -> bytes:
        """Read up to `length` bytes."""
        return self._loop.run(self._inner.read_raw(group, offset, length))

    def write_raw(self, group: int, offset: int, data: bytes) -> None:
        """Write `data`."""
        self._loop.run(self._inner.write_raw(group, offset, data))

    def read_write_raw(self, group: int, offset: int, read_length: int, data: bytes) -> bytes:
        """Write `data` and read up to `read_length` bytes in one call."""
        return self._loop.run(self._inner.read_write_raw(group, offset, read_length, data))

    def read(self, name: str) -> Any:
        """The value of symbol `name`."""
        return self._loop.run(self._inner.read(name))

    def write(self, name: str, value: object) -> None:
        """Set symbol `name`."""
        self._loop.run(self._inner.write(name, value))

    @overload
    def read_many(self, names: Iterable[str]) -> dict[str, Any]: ...
    @overload
    def read_many(self, names: Iterable[str], *, strict: bool) -> dict[str, Any | AdsError]: ...
    def read_many(self, names: Iterable[str], *, strict: bool = True) -> dict[str, Any]:
        """The values of many symbols, by name."""
        return self._loop.run(self._inner.read_many(names, strict=strict))

    def write_many(
        self, values: Mapping[str, object], *, strict: bool = True
    ) -> dict[str, AdsError]:
        """Set many symbols."""
        return self._loop.run(self._inner.write_many(values, strict=strict))

    def symbols(self) -> list[SymbolEntry]:
        """Every symbol the device lists."""
        return self._loop.run(self._inner.symbols())

    def type_of(self, name: str) -> IecType[Any]:
        """The type of symbol `name`."""
        return self._loop.run(self._inner.type_of(name))

    def types(self) -> TypeTable:
        """The types the device declares."""
        return self._loop.run(self._inner.types())

    def call(self, name: str, method: str | Method, /, **inputs: object) -> Any:
        """Call a method of the function block `name`."""
        return self._loop.run(self._inner.call(name, method, **inputs))

    def read_as(self, group: int, offset: int, type: Typelike) -> Any:
        """A value of `type` at a place."""
        return self._loop.run(self._inner.read_as(group, offset, type))

    def write_as(self, group: int, offset: int, type: Typelike, value: object) -> None:
        """Write `value` as `type` to a place."""
        self._loop.run(self._inner.write_as(group, offset, type, value))

    def subscribe(
        self,
        names: str | Iterable[str],
        *,
        cycle_time: float = 0.1,
        max_delay: float = 0.0,
        mode: SendWhen = "change",
        depth: int = 10_000,
    ) -> "Subscription":
        """Samples of one symbol or of many; iterate in a `with` block."""
        inner = self._inner.subscribe(
            names, cycle_time=cycle_time, max_delay=max_delay, mode=mode, depth=depth
        )
        return Subscription(self._loop, inner)

    def subscribe_as(
        self,
        group: int,
        offset: int,
        type: Typelike | int,
        *,
        cycle_time: float = 0.1,
        max_delay: float = 0.0,
        mode: SendWhen = "change",
        depth: int = 10_000,
    ) -> "Subscription":
        """Samples of a place, as a type or as so many bytes."""
        inner = self._inner.subscribe_as(
            group,
            offset,
            type,
            cycle_time=cycle_time,
            max_delay=max_delay,
            mode=mode,
            depth=depth,
        )
        return Subscription(self._loop, inner)


class Client(Target):
    """The device `connect` was asked for, and the owner of connection and thread."""

    def __init__(self, loop: LoopThread, inner: client.Client) -> None:
        super().__init__(loop, inner)
        self._client = inner

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give everything back and end connection and thread. Again is not an error."""
        try:
            if not self._client.session.closed:
                self._loop.run(self._client.close())
        finally:
            self._loop.stop()


class Subscription:
    """Samples as an iterator, and one at a time with a time limit."""

    def __init__(self, loop: LoopThread, inner: subscription.Subscription) -> None:
        self._loop = loop
        self._inner = inner

    @property
    def dropped(self) -> int:
        """Samples lost so far because nobody fetched them."""
        return self._inner.dropped

    @property
    def interruptions(self) -> int:
        """Number of times that the subscription had to be set up again."""
        return self._inner.interruptions

    def __enter__(self) -> Self:
        self._loop.run(self._inner.__aenter__())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._loop.run(self._inner.close())

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Sample:
        sample = self.next()
        if sample is None:
            raise StopIteration
        return sample

    def next(self, timeout: float | None = None) -> Sample | None:
        """The next sample; None after the end. TimeoutError if none comes in `timeout` seconds."""
        return self._loop.run(self._next(timeout))

    async def _next(self, seconds: float | None) -> Sample | None:
        async with asyncio.timeout(seconds):
            return await anext(self._inner, None)


def connect(
    host: str | SecureTarget | None = None,
    *,
    net_id: str | NetId | None = None,
    port: int = 851,
    source: str | AmsAddress | None = None,
    mode: Mode = "auto",
    timeout: float = 5.0,
    reconnect: Backoff | bool = True,
    keep_alive: float | None = 5.0,
    watch_symbols: bool = True,
    advance: Advance | None = None,
) -> Client:
    """Connect to the device at AMS `port` behind a router; see `achse.connect`.

    Raises `ConnectionLost` if nobody answers there.
    """
    connecting = client.connect(
        host,
        net_id=net_id,
        port=port,
        source=source,
        mode=mode,
        timeout=timeout,
        reconnect=reconnect,
        keep_alive=keep_alive,
        watch_symbols=watch_symbols,
        advance=advance,
    )
    loop = LoopThread()
    try:
        return Client(loop, loop.run(_opened(connecting)))
    except BaseException:
        loop.stop()
        raise


async def _opened(connecting: client.Connecting) -> client.Client:
    return await connecting
