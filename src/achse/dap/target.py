"""Target of an editor: a station that the adapter runs itself, or one that runs already."""

import asyncio
from collections.abc import Mapping
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

from achse.ams import NetId
from achse.ams.host_port import host_and_port
from achse.client import connect
from achse.client.links.link import TcpDialer
from achse.codes.station import SERVICE_PORT
from achse.dap.link import DebugLink
from achse.st.files.forms import has_station
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.transport.tcp.listener import TCP_PORT


class TargetError(Exception):
    """The editor's settings do not lead to a station."""


class Target:
    """A station with its debugging service, from `launch` or `attach` to `close`."""

    def __init__(self, settings: Mapping[str, Any], *, launch: bool) -> None:
        self.is_own = launch
        self._settings = settings
        self._stack = AsyncExitStack()
        self._station: Station | None = None
        self.link: DebugLink
        self.message = ""
        """Message for the user once the station runs."""
        self.ended: asyncio.Event = asyncio.Event()

    async def open(self) -> None:
        """Reach the station. Raises TargetError, AdsError, ConfigError, OSError."""
        plc = self._number("plc", 0)
        if self.is_own:
            self._station = self._create_station()
            client = connect(self._station.router, port=SERVICE_PORT)
        else:
            net_id = self._text("netId", "")
            client = connect(
                TcpDialer(*self._endpoint()),
                net_id=NetId(net_id) if net_id else None,
                port=SERVICE_PORT,
            )
        self.link = DebugLink(await self._stack.enter_async_context(client), plc)
        await self.link.state()

    def _create_station(self) -> Station:
        program = self._text("program", "")
        if not program:
            raise TargetError("launch: `program` is a station.toml, a folder of sources or a file")
        path = Path(program)
        if not path.exists():
            raise TargetError(f"launch: {path} does not exist")
        if has_station(path):
            return Station.load(path)
        libraries = self._settings.get("libraries", [])
        if not isinstance(libraries, list) or not all(isinstance(one, str) for one in libraries):
            raise TargetError("launch: `libraries` is a list of paths")
        plc = {
            "sources": str(path.resolve()),
            "libraries": [str(Path(one).resolve()) for one in libraries],
        }
        return Station(parse({"plc": [plc]}, str(path)))

    async def start(self) -> None:
        """Let the time of a station of its own begin. Raises OSError if its port is taken."""
        station = self._station
        if station is None:
            return
        speed = self._settings.get("speed", 1.0)
        if isinstance(speed, bool) or not isinstance(speed, int | float) or not 0 < speed < 1e6:
            raise TargetError(f"launch: `speed` is a number above 0, got {speed!r}")
        running = await self._stack.enter_async_context(
            station.running(
                self._text("host", "127.0.0.1"),
                self._number("tcpPort", TCP_PORT),
                speed=float(speed),
            )
        )
        self.message = f"station {station.router.net_id} at {running.host}:{running.tcp_port}\n"
        task = asyncio.create_task(running.finished())
        task.add_done_callback(lambda _: self.ended.set())
        self._stack.callback(task.cancel)

    async def close(self) -> None:
        """Leave the station; one of its own ends."""
        await self._stack.aclose()

    def _endpoint(self) -> tuple[str, int]:
        """Return host and TCP port to attach to; a port in `host` comes before `tcpPort`."""
        try:
            return host_and_port(self._text("host", "127.0.0.1"), self._number("tcpPort", TCP_PORT))
        except ValueError as fault:
            raise TargetError(str(fault)) from None

    def _text(self, name: str, default: str) -> str:
        value = self._settings.get(name, default)
        if not isinstance(value, str):
            raise TargetError(f"`{name}` is a text, got {value!r:.80}")
        return value

    def _number(self, name: str, default: int) -> int:
        value = self._settings.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 0xFFFF:
            raise TargetError(f"`{name}` is a number, 0 to 65535, got {value!r:.80}")
        return value
