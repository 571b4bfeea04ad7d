"""Stations that tools run in virtual time, their recordings, and the target that they may reach."""

import time
from collections import OrderedDict
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from anyio import Lock, to_thread

from achse.client import Client, connect
from achse.mcp.folder import ProjectFolder
from achse.mcp.recordings import RunRecording
from achse.mcp.results import PlcReport, RunReport
from achse.scope import ScopeChannel
from achse.station import Station, StationConfig
from achse.station.configuration.station_file import load, parse

TARGET = "target"
"""Handle of the controller that --connect names."""

WALL_S = 60.0
"""Seconds on the clock on the wall that a call may take."""

_MOST_STATIONS = 8
_MOST_RECORDINGS = 16
_SHORT_S, _LONG_S = 0.02, 0.1
"""A slice takes about as long: between two of them a call can be cancelled."""

Progress = Callable[[float], Awaitable[None]]


class HandleError(ValueError):
    """No station or recording has this handle."""


class OpenStation:
    """A station in virtual time and a client of it, without sockets."""

    def __init__(self, handle: str, station: Station | None, client: Client) -> None:
        self.handle = handle
        self.client = client
        self.calls = 0
        """Calls that use it or wait for it; meanwhile it is not closed."""
        self._lock = Lock()
        self._station = station

    @asynccontextmanager
    async def in_use(self) -> AsyncIterator[None]:
        """Use the station alone."""
        self.calls += 1
        try:
            async with self._lock:
                yield
        finally:
            self.calls -= 1

    @property
    def station(self) -> Station:
        """The station. Raises HandleError for the target of --connect."""
        if self._station is None:
            raise HandleError(f"{self.handle}: expected a station of open_station, got a target")
        return self._station

    @property
    def is_simulated(self) -> bool:
        """False for the target of --connect."""
        return self._station is not None

    async def run(
        self,
        seconds: float,
        channels: Sequence[ScopeChannel],
        report: Progress,
        wall: float = WALL_S,
    ) -> tuple[RunReport, RunRecording | None]:
        """Let time pass, in slices; a PLC that stops ends it. Raises ScopeError, AdsError."""
        station = self.station
        before = station.time_ns
        if not channels:
            reason = await self._pass(seconds, report, wall)
            return self._report(before, reason), None
        with station.scope(channels, length=seconds + station.tick_ns / 1e9, name="mcp") as scope:
            reason = await self._pass(seconds, report, wall)
            scope.stop()
            recording = RunRecording(scope.data(), station.digest())
        return self._report(before, reason), recording

    async def _pass(self, seconds: float, report: Progress, wall: float) -> str:
        station = self.station
        stopped = {port for port, plc in station.plcs.items() if plc.failure}
        end, begin = station.time_ns + round(seconds * 1e9), station.time_ns
        deadline, part = time.monotonic() + wall, 0.01
        while (left := end - station.time_ns) >= station.tick_ns:
            began = time.monotonic()
            await to_thread.run_sync(station.advance, min(part, left / 1e9))
            took = time.monotonic() - began
            if took < _SHORT_S:
                part *= 2
            elif took > _LONG_S:
                part = max(part / 2, station.tick_ns / 1e9)
            await report((station.time_ns - begin) / 1e9)
            if any(plc.failure for port, plc in station.plcs.items() if port not in stopped):
                return "plc stopped"
            if time.monotonic() > deadline:
                return "time limit"
        return "done"

    def _report(self, before: int, reason: str) -> RunReport:
        now = self.station.time_ns
        return RunReport(
            time_s=now / 1e9,
            passed_s=(now - before) / 1e9,
            reason=reason,
            plcs=plc_reports(self.station),
        )


def plc_reports(station: Station) -> list[PlcReport]:
    """Return the PLCs of a station, each with the cause of its stop."""
    return [
        PlcReport(
            port=port,
            name=plc.name,
            state=plc.state.name.lower(),
            fault=str(plc.fault) if plc.fault is not None else plc.complaint,
        )
        for port, plc in station.plcs.items()
    ]


class OpenStations:
    """Stations and recordings by handle, between calls; the oldest idle ones are closed first."""

    def __init__(self, folder: ProjectFolder, target: str | None = None) -> None:
        self._folder = folder
        self._target = target
        self._by_handle: OrderedDict[str, OpenStation] = OrderedDict()
        self._recordings: OrderedDict[str, RunRecording] = OrderedDict()
        self._connected: OpenStation | None = None
        self._stations = self._runs = 0

    async def __aenter__(self) -> "OpenStations":
        return self

    async def __aexit__(self, *_: object) -> None:
        for opened in self._by_handle.values():
            await opened.client.close()
        if self._connected is not None:
            await self._connected.client.close()

    async def start(self, path: Path) -> OpenStation:
        """Start a station of a station.toml or of PLC sources.

        Raises ConfigError, FolderError, and HandleError if calls use all stations.
        """
        station = await to_thread.run_sync(self._create_station, path)
        client = await connect(
            station.router,
            advance=self._advance_of(station),
            reconnect=False,
            keep_alive=None,
            watch_symbols=False,
        )
        while len(self._by_handle) >= _MOST_STATIONS:
            idle = next((each for each in self._by_handle.values() if not each.calls), None)
            if idle is None:
                await client.close()
                raise HandleError(f"{_MOST_STATIONS} stations are in use, which is the most")
            del self._by_handle[idle.handle]
            await idle.client.close()
        self._stations += 1
        opened = OpenStation(f"s{self._stations}", station, client)
        self._by_handle[opened.handle] = opened
        return opened

    @staticmethod
    def _advance_of(station: Station) -> Callable[[float], Awaitable[None]]:
        async def advance(seconds: float) -> None:
            await to_thread.run_sync(station.advance, seconds)

        return advance

    def _create_station(self, path: Path) -> Station:
        if path.suffix.lower() == ".toml":
            config, base = load(path), path.parent
        else:
            config, base = self._of_sources(path), path.parent
        return Station(self._folder.confined(config, base), base=base)

    def _of_sources(self, path: Path) -> StationConfig:
        libraries = [str(library) for library in self._folder.libraries]
        plc = {"sources": str(path), "libraries": libraries, "code": "plain"}
        return parse({"plc": [plc]}, path.name)

    async def station(self, handle: str) -> OpenStation:
        """Return a station, or the target of --connect. Raises HandleError, AdsError."""
        if handle == TARGET and self._target is not None:
            if self._connected is None:
                self._connected = OpenStation(TARGET, None, await connect(self._target))
            return self._connected
        if handle not in self._by_handle:
            known = ", ".join(self._by_handle) or "none; open_station gives one"
            raise HandleError(f"no station {handle!r:.40}, there are: {known}")
        self._by_handle.move_to_end(handle)
        return self._by_handle[handle]

    def keep(self, recording: RunRecording) -> str:
        """Keep a recording; return its handle."""
        self._runs += 1
        handle = f"r{self._runs}"
        self._recordings[handle] = recording
        while len(self._recordings) > _MOST_RECORDINGS:
            self._recordings.popitem(last=False)
        return handle

    def recording(self, handle: str) -> RunRecording:
        """Return a recording. Raises HandleError."""
        if handle not in self._recordings:
            known = ", ".join(self._recordings) or "none; run with `record` gives one"
            raise HandleError(f"no recording {handle!r:.40}, there are: {known}")
        return self._recordings[handle]

    @property
    def runs(self) -> list[str]:
        """Handles of recordings."""
        return list(self._recordings)
