"""The client without asyncio: the same core, on a loop of its own in a background thread.

    with achse.blocking.connect("127.0.0.1", net_id="127.0.0.1.1.1") as plc:
        value = plc.read("MAIN.nCounter")
        with plc.subscribe("MAIN.nCounter", cycle_time=0.1) as samples:
            for sample in samples:
                ...

Any thread may use a client; requests of several threads are under way at the same time.
"""

import asyncio
from types import TracebackType
from typing import TYPE_CHECKING, Self

from achse.ams import AmsAddress, NetId
from achse.client import client, target
from achse.client.links.link import Mode
from achse.client.links.secure_link import SecureTarget
from achse.client.loop import LoopThread
from achse.client.session import subscription
from achse.client.session.session import Advance, Backoff
from achse.client.session.subscription import Sample
from achse.client.wrapper import ContextWrapper, Wrapper, blocking, wrapping

if TYPE_CHECKING:
    from achse.client.nc.blocking import RemoteNc
    from achse.client.scope import RemoteScope
    from achse.client.scope_blocking import BlockingScope

__all__ = ["Client", "Subscription", "Target", "connect"]


class Subscription(ContextWrapper[subscription.Subscription]):
    """Samples as an iterator, and one at a time with a time limit."""

    @property
    def dropped(self) -> int:
        """Number of samples dropped because the client did not fetch them in time."""
        return self._inner.dropped

    @property
    def interruptions(self) -> int:
        """Number of times that the subscription had to be set up again."""
        return self._inner.interruptions

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Sample:
        sample = self.next()
        if sample is None:
            raise StopIteration
        return sample

    def next(self, timeout: float | None = None) -> Sample | None:
        """Return the next sample; None after the end. TimeoutError if none comes in `timeout`
        seconds."""
        return self._loop.run(self._next(timeout))

    async def _next(self, seconds: float | None) -> Sample | None:
        try:
            async with asyncio.timeout(seconds):
                return await anext(self._inner, None)
        except TimeoutError:
            raise TimeoutError(f"no sample within {seconds:g} s") from None


def _target(loop: LoopThread, inner: target.Target) -> "Target":
    return Target(loop, inner)


def _scope(loop: LoopThread, inner: "RemoteScope") -> "BlockingScope":
    from achse.client.scope_blocking import BlockingScope  # loaded when scopes are used

    return BlockingScope(loop, inner)


class Target(Wrapper[target.Target]):
    """One ADS device; see `achse.client.Target`, whose methods these are."""

    @property
    def address(self) -> AmsAddress:
        return self._inner.address

    @property
    def nc(self) -> "RemoteNc":
        """The NC beside this device: `client.nc.axis("X").move_to(300, velocity=200)`."""
        from achse.client.nc.blocking import RemoteNc  # loaded when axes are used

        return RemoteNc(self._loop, self._inner.nc)

    at_port = wrapping(target.Target.at_port, _target)
    within = wrapping(target.Target.within, _target)
    scope = wrapping(target.Target.scope, _scope)
    device_info = blocking(target.Target.device_info)
    state = blocking(target.Target.state)
    write_control = blocking(target.Target.write_control)
    read_raw = blocking(target.Target.read_raw)
    write_raw = blocking(target.Target.write_raw)
    read_write_raw = blocking(target.Target.read_write_raw)
    read = blocking(target.Target.read)
    write = blocking(target.Target.write)
    read_many = blocking(target.Target.read_many)
    write_many = blocking(target.Target.write_many)
    symbols = blocking(target.Target.symbols)
    type_of = blocking(target.Target.type_of)
    types = blocking(target.Target.types)
    call = blocking(target.Target.call)
    read_as = blocking(target.Target.read_as)
    write_as = blocking(target.Target.write_as)
    subscribe = wrapping(target.Target.subscribe, Subscription)
    subscribe_as = wrapping(target.Target.subscribe_as, Subscription)


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
            if self._loop.is_running and not self._client.session.closed:
                self._loop.run(self._client.close())
        finally:
            self._loop.stop()


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

    Raises `ConnectionLost` if the router does not answer.
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
