"""A station in a background thread, for tests whose client blocks."""

import asyncio
import concurrent.futures
import contextlib
import threading
import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any, Literal, Self, TypeVar

from achse.ams import NetId
from achse.client import blocking
from achse.faults.fault import ActiveFault
from achse.faults.site import StationFault
from achse.station import Station, StationConfig
from achse.station.configuration.station_file import parse
from achse.testing.addresses import free_host
from achse.transport.tcp.listener import TCP_PORT

V = TypeVar("V")

_PATIENCE = 30.0
"""Seconds; whatever takes longer in the other thread hangs."""

Time = Literal["real", "virtual"] | float


class Live:
    """Something that serves on a loop of its own, in a thread of its own.

    `open` makes an async context manager; it is entered and left in that loop, and gives the host
    and the port at which it listens.
    """

    def __init__(self, open: Callable[[], AbstractAsyncContextManager[tuple[str, int]]]) -> None:
        self._open = open
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._leave: asyncio.Event
        self.host = ""
        self.tcp_port = 0

    def start(self) -> Self:
        """Serve; returns once clients can connect, raises what prevents it."""
        ready: concurrent.futures.Future[tuple[str, int]] = concurrent.futures.Future()
        self._thread = threading.Thread(
            target=asyncio.run, args=(self._serve(ready),), name="achse live", daemon=True
        )
        self._thread.start()
        self.host, self.tcp_port = ready.result(_PATIENCE)
        return self

    async def _serve(self, ready: "concurrent.futures.Future[tuple[str, int]]") -> None:
        self._loop = asyncio.get_running_loop()
        self._leave = asyncio.Event()
        try:
            async with self._open() as where:
                ready.set_result(where)
                await self._leave.wait()
        except BaseException as failure:
            if ready.done():
                raise
            ready.set_exception(failure)

    def stop(self) -> None:
        """End; connections are closed. Again is not an error."""
        thread, self._thread = self._thread, None
        if thread is not None and self._loop is not None:
            with contextlib.suppress(RuntimeError):  # it has ended by itself
                self._loop.call_soon_threadsafe(self._leave.set)
            thread.join(_PATIENCE)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()

    def run(self, function: Callable[..., V], *arguments: Any, **fields: Any) -> V:
        """Call a function in the serving thread, between two cycles; its result or exception."""
        if self._loop is None or self._thread is None:
            raise RuntimeError("it is not running: use `with`, or start()")

        async def call() -> V:
            return function(*arguments, **fields)

        return asyncio.run_coroutine_threadsafe(call(), self._loop).result(_PATIENCE)


_TURNS = 2
"""Turns of the event loop in which a connection is aborted and its socket closed."""


class LiveStation(Live):
    """A station at a loopback address of its own, ready within milliseconds.

        with LiveStation() as station:
            plc = pyads.Connection(station.net_id, 851, station.host)

    - `config`: a station.toml, a dict of what would be in it, a `StationConfig`, a function that
      makes a `Station`; None is the demo station.
    - `time`: "real" (the wall clock), "virtual" (stopped until `advance`), or a speed.
    - `host`, `tcp_port`: a free loopback address and 48898 unless given; the NetId is the address
      with .1.1 behind it, unless a function makes the station.
    """

    def __init__(
        self,
        config: str | Path | dict[str, Any] | StationConfig | Callable[[], Station] | None = None,
        *,
        time: Time = "real",
        host: str | None = None,
        tcp_port: int = TCP_PORT,
    ) -> None:
        super().__init__(self._serving)
        self._config = config
        self.speed = {"real": 1.0, "virtual": 0.0}.get(time, time)  # type: ignore[arg-type]
        if not isinstance(self.speed, int | float) or self.speed < 0:
            raise ValueError(f'time: expected "real", "virtual" or a speed, got {time!r}')
        self._address = (free_host(tcp_port) if host is None else host, tcp_port)
        self.station: Station
        """The station itself; touch it through `run` only."""
        self._broke: BaseException | None = None

    def _make(self) -> Station:
        net_id = f"{self._address[0]}.1.1"
        config = self._config
        if config is None:
            return Station.demo(net_id=net_id)
        if callable(config):
            return config()
        if isinstance(config, dict):
            config = parse(config, "config")
        if isinstance(config, StationConfig):
            router = config.router.model_copy(update={"net_id": NetId(net_id)})
            return Station(config.model_copy(update={"router": router}))
        if isinstance(config, str | Path):
            return Station.load(config, net_id=net_id)
        raise TypeError(
            "config: expected a station.toml, a dict, a StationConfig or a function,"
            f" got {config!r:.80}"
        )

    @contextlib.asynccontextmanager
    async def _serving(self):  # type: ignore[no-untyped-def]
        self.station = self._make()
        async with self.station.running(*self._address, speed=self.speed) as running:
            watch = asyncio.create_task(running.finished())
            yield running.host, running.tcp_port
            if watch.done():
                self._broke = watch.exception()
            else:
                watch.cancel()

    def stop(self) -> None:
        """End. Raises what broke the station's cycle, if anything did."""
        super().stop()
        broke, self._broke = self._broke, None
        if broke is not None:
            raise broke

    def restart(self) -> None:
        """Switch power off and on: connections break, everything has its initial value again.

        It comes back at the same address, with its time at 0 and without faults.
        """
        self._address = (self.host, self.tcp_port)
        self.stop()
        self.start()

    @property
    def net_id(self) -> str:
        return str(self.station.router.net_id)

    @property
    def time(self) -> float:
        """Station time, s."""
        return self.run(lambda: self.station.time_ns) / 1e9

    def advance(self, seconds: float) -> None:
        """Let station time pass. In virtual time at once, else it is waited for."""
        if self.speed == 0:
            self.run(self.station.advance, seconds)
            return
        end = self.time + seconds
        while self.time < end:
            time.sleep(min(0.05, seconds / self.speed / 10))

    def fault(self, kind: str | StationFault, /, **fields: Any) -> ActiveFault:
        """Make something go wrong, see `achse.faults`; raises FaultError.

        Connections that it breaks are closed when it returns.
        """
        active = self.run(self.station.faults.add, kind, **fields)
        for _ in range(_TURNS):
            self.run(lambda: None)
        return active

    def clear_faults(self) -> None:
        """End all faults."""
        self.run(self.station.faults.clear)

    def connect(self, port: int = 851, **settings: Any) -> blocking.Client:
        """Our own blocking client: `with station.connect() as plc: plc.read("MAIN.nCounter")`.

        In virtual time, what waits for an axis lets time pass: `plc.nc.axis("X").move_to(…)`.
        """
        if self.speed == 0:
            settings = {"advance": self.advance} | settings
        return blocking.connect(
            f"{self.host}:{self.tcp_port}", net_id=self.net_id, port=port, **settings
        )
