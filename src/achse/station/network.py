"""The station on a network: where it listens, how it is found, and which routers it dials."""

import logging
import platform
from pathlib import Path

from achse.ams import NetId
from achse.ams.discovery import UDP_PORT, OsVersion, SystemInfo
from achse.router import Router
from achse.router.access import Users
from achse.router.routes import Route, RouteError
from achse.router.static_routes import parse_static_routes, static_routes
from achse.station.config import ConfigError, StationConfig
from achse.station.state_file import StateFile
from achse.transport.reason import reason
from achse.transport.tcp import TCP_PORT, TcpListener
from achse.transport.udp import DiscoveryEndpoint
from achse.transport.uplink import Uplinks

__all__ = ["Network", "RouteFile", "host_system"]

log = logging.getLogger("achse.station")


def host_system() -> OsVersion:
    """The operating system below us; of those that have a number a Unix is nearest to BSD."""
    release = platform.release().partition("-")[0].split(".")
    major, minor, build, *_ = (
        int(part) if part.isdecimal() else 0 for part in (*release, "", "", "")
    )
    system = platform.system()
    return OsVersion(major, minor, build, 2 if system == "Windows" else 0, system)


class RouteFile:
    """The routes of a station: those of its configuration, and those in its StaticRoutes.xml."""

    def __init__(self, config: StationConfig, router: Router, base: Path) -> None:
        """Fill the router's table and follow it. Raises ConfigError, OSError."""
        self._configured = [item.route() for item in config.route]
        self._routes = router.routes
        self._file: StateFile | None = None
        name = config.router.static_routes
        routes = list(self._configured)
        if name is not None:
            self._file = StateFile(base / name)
            routes = [*self._read(self._file), *routes]
        try:
            for route in routes:
                self._routes.add(route)
        except RouteError as fault:
            raise ConfigError(f"route: {fault}") from None
        if self._file is not None:
            self._routes.on_change(self._changed)

    def _read(self, file: StateFile) -> list[Route]:
        try:
            text = file.read()
            return [] if text is None else parse_static_routes(text)
        except (RouteError, UnicodeDecodeError) as fault:
            raise ConfigError(f"router.static_routes: {file.path}: {fault}") from None

    def _changed(self, old: Route | None, new: Route | None) -> None:
        assert self._file is not None
        kept = [route for route in self._routes if route not in self._configured]
        try:
            self._file.write(static_routes(kept))
        except OSError as failure:
            log.error("%s cannot be written: %s", self._file.path, failure.strerror)


class Network:
    """The sockets of a running station."""

    def __init__(
        self, config: StationConfig, router: Router, version: tuple[int, int, int]
    ) -> None:
        self._config = config
        self._router = router
        self._version = version
        self.listener = TcpListener(
            router,
            strict=config.router.strict,
            routes_required=config.router.strict,
            max_length=config.router.max_length,
            max_connections=config.router.max_connections,
            max_backlog=config.limits.unread_bytes,
            max_held=config.limits.held_bytes,
        )
        self.discovery: DiscoveryEndpoint | None = None
        self.uplinks: Uplinks | None = None

    def info(self) -> SystemInfo:
        """What a search is told."""
        net_id = NetId(self._router.net_id)
        return SystemInfo(net_id, self._config.name, self._version, host_system())

    async def open(self, host: str | None, tcp_port: int | None, udp_port: int | None) -> None:
        """Listen; None takes the configuration's. Raises OSError if a port is taken."""
        config = self._config.router
        await self.listener.open(
            config.host if host is None else host,
            config.tcp_port if tcp_port is None else tcp_port,
        )
        try:
            await self._open_discovery(config.udp_port if udp_port is None else udp_port)
        except OSError:
            await self.listener.close()
            raise
        self.uplinks = Uplinks(
            self._router, local_host=self.listener.host, max_length=config.max_length
        )
        self.uplinks.start()

    async def _open_discovery(self, port: int | None) -> None:
        """Answer searches. Without a port that was asked for only where it does no harm."""
        if port is None and self.listener.port != TCP_PORT:
            return
        endpoint = DiscoveryEndpoint(
            self.info, self._router.routes, Users(self._config.router.users)
        )
        try:
            await endpoint.open(self.listener.host, UDP_PORT if port is None else port)
        except OSError as taken:
            if port is not None:
                raise OSError(f"UDP port {port}: {reason(taken)}") from taken
            log.info("searches are not answered, UDP port %d: %s", UDP_PORT, reason(taken))
            return
        self.discovery = endpoint

    async def close(self) -> None:
        """Close everything."""
        if self.uplinks is not None:
            await self.uplinks.close()
        if self.discovery is not None:
            await self.discovery.close()
        await self.listener.close()
