"""The station on a network: where it listens, how it is found, and which routers it dials."""

import asyncio
import logging
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from achse.ams import NetId
from achse.ams.discovery import UDP_PORT, OsVersion, RouterInfo
from achse.ams.mqtt import RouterNote
from achse.router import Router
from achse.router.access import Users
from achse.router.rights import rights_named
from achse.station.configuration.network import NetworkConfig
from achse.station.configuration.types import ConfigError
from achse.station.routes.addresses import check_own_address, is_reachable_from_outside
from achse.station.routes.identity import StationIdentity
from achse.transport.connections.send_budget import SendBudget
from achse.transport.mqtt.network import MqttError
from achse.transport.reason import reason
from achse.transport.serial.port import SerialPortError
from achse.transport.serial.ports import ServedPort, ServedSerialPorts
from achse.transport.tcp.listener import TCP_PORT, TcpListener
from achse.transport.udp import DiscoveryEndpoint
from achse.transport.uplinks.host_names import HostNames
from achse.transport.uplinks.uplinks import Uplinks

if TYPE_CHECKING:
    from achse.station.routes.symbol_topics import SymbolTopics
    from achse.transport.mqtt.routes import MqttRoutes
    from achse.transport.secure.listener import SecureListener

log = logging.getLogger("achse.station")

_JOINED_WITHIN = 2.0
"""Seconds that brokers have until the station is ready without them; they are dialled on."""

_NAMES_KNOWN_WITHIN = 2.0
"""Seconds that the first look-up of the routes' host names may delay start and answers."""


def host_system() -> OsVersion:
    """Return the operating system below us; of those that have a number a Unix is nearest to
    BSD."""
    release = platform.release().partition("-")[0].split(".")
    major, minor, build, *_ = (
        int(part) if part.isdecimal() else 0 for part in (*release, "", "", "")
    )
    system = platform.system()
    return OsVersion(major, minor, build, 2 if system == "Windows" else 0, system)


def _users(config: NetworkConfig) -> Users:
    """Return the users of a station, and what the routes may that they add."""
    rights = {name: rights_named(each) for name, each in config.router.user_rights.items()}
    return Users(config.router.users, rights)


class Network:
    """The sockets of a running station, or of a router without devices.

    `any_client_may` lists, for the log, what every client may where all are let in.
    """

    def __init__(
        self,
        config: NetworkConfig,
        router: Router,
        version: tuple[int, int, int],
        base: Path,
        any_client_may: Sequence[str] = (),
    ) -> None:
        self._any_client_may = any_client_may
        self._config = config
        self.identity = StationIdentity(config.secure, base, config.name)
        self._base = base
        self.secure: SecureListener | None = None
        self.mqtt: tuple[MqttRoutes, ...] = ()
        self.bridges: tuple[SymbolTopics, ...] = ()
        self._router = router
        self._version = version
        self.listener = TcpListener(
            router,
            strict=config.router.strict,
            routes_required=config.router.strict,
            max_connections=config.router.max_connections,
            max_backlog=config.limits.unread_bytes,
            max_per_host=config.router.max_connections_per_host,
            send_budget=SendBudget(config.limits.buffered_bytes),
        )
        self.discovery: DiscoveryEndpoint | None = None
        self.uplinks: Uplinks | None = None
        self.serial = ServedSerialPorts(
            router,
            [ServedPort(item.serial_port(), item.net_id) for item in config.serial],
            send_budget=self.listener.send_budget,
            fair_queue=self.listener.fair_queue,
        )
        self._names = HostNames(router.routes)

    @property
    def name(self) -> str:
        """Name of the station, or of this computer."""
        return self.identity.name

    def info(self) -> RouterInfo:
        """Return the answer to a search."""
        net_id = NetId(self._router.net_id)
        shown = "" if self.secure is None else self.identity.identity.fingerprint
        return RouterInfo(net_id, self.name, self._version, host_system(), shown)

    @property
    def listeners(self) -> tuple[TcpListener, ...]:
        """Listeners of TCP, plain and secure."""
        return (self.listener,) if self.secure is None else (self.listener, self.secure)

    async def open(
        self,
        host: str | None,
        tcp_port: int | None,
        udp_port: int | None,
        let_everybody_in: bool | None = None,
    ) -> None:
        """Listen; None takes the configuration's.

        Raises OSError if a port is taken, ConfigError for a serial port that cannot be opened and
        for an address that lets others than this computer in without `strict` and without
        `let_everybody_in`.
        """
        config = self._config.router
        where = config.host if host is None else host
        everybody = config.let_everybody_in if let_everybody_in is None else let_everybody_in
        plain = config.listen != "secure"
        if plain and not config.strict and await is_reachable_from_outside(where):
            await check_own_address(where)
            if not everybody:
                raise ConfigError(
                    f"{where} can be reached from other computers, and without strict = true in"
                    " [router] this station lets everybody in. To allow that:"
                    " --let-everybody-in, or let_everybody_in = true in [router]"
                )
            log.warning(
                "this station listens at %s and lets everybody in."
                " Any client that reaches it may, without a password:",
                where,
            )
            for item in self._any_client_may:
                log.warning("- %s", item)
        self._names.start()
        try:
            await self._names.known(_NAMES_KNOWN_WITHIN)
            if plain:
                await self.listener.open(where, config.tcp_port if tcp_port is None else tcp_port)
            await self._open_discovery(where, config.udp_port if udp_port is None else udp_port)
            if config.listen != "plain":
                await self._open_secure(where)
            await self._open_serial_ports()
            self._join_networks()
            await asyncio.gather(*(each.settled(_JOINED_WITHIN) for each in self.mqtt))
        except BaseException:
            self._names.close()
            for network in self.mqtt:
                await network.close()
            await self.serial.close()
            if self.discovery is not None:
                await self.discovery.close()
            if self.secure is not None:
                await self.secure.close()
            await self.listener.close()
            raise
        self.uplinks = Uplinks(
            self._router,
            local_host=self.listener.host or where,
            send_budget=self.listener.send_budget,
            fair_queue=self.listener.fair_queue,
            credentials=self.identity.credentials,
            strict=config.strict,
        )
        self.uplinks.start()
        for bridge in self.bridges:
            bridge.start()

    async def _open_secure(self, host: str) -> None:
        from achse.transport.secure.listener import SecureListener

        config, limits = self._config.router, self._config.limits
        self.secure = SecureListener(
            self._router,
            await asyncio.get_running_loop().run_in_executor(None, self.identity.server),
            _users(self._config),
            name=self.identity.name,
            ignore_names=self._config.secure.ignore_names,
            max_connections=config.max_connections,
            max_backlog=limits.unread_bytes,
            max_per_host=config.max_connections_per_host,
            send_budget=self.listener.send_budget,
            fair_queue=self.listener.fair_queue,
        )
        await self.secure.open(host, self._config.secure.port)

    def _join_networks(self) -> None:
        """Join the networks over MQTT; an unreachable broker is dialled again and again."""
        system = host_system()
        note = RouterNote(
            online=True,
            name=self.name,
            os_version=".".join(map(str, system[:3])),
            os_platform=system.platform,
            tc_version=".".join(map(str, self._version)),
        )
        try:
            self.mqtt = self._brokers(note)
            self.bridges = self._made_bridges()
        except MqttError as fault:
            raise ConfigError(f"mqtt: {fault}") from None
        for network in self.mqtt:
            network.start()

    def _brokers(self, note: RouterNote) -> "tuple[MqttRoutes, ...]":
        """Return the routes of [[mqtt]], without which their module is not loaded. Raises
        MqttError."""
        if not self._config.mqtt:
            return ()
        from achse.transport.mqtt.routes import MqttRoutes

        return tuple(
            MqttRoutes(
                self._router,
                settings,
                note,
                max_backlog=self._config.limits.unread_bytes,
                send_budget=self.listener.send_budget,
                fair_queue=self.listener.fair_queue,
            )
            for item in self._config.mqtt
            for settings in item.networks(self._base)
        )

    def _made_bridges(self) -> "tuple[SymbolTopics, ...]":
        """Return the bridges of [[bridge]], without which no client is loaded. Raises MqttError."""
        if not self._config.bridge:
            return ()
        from achse.station.routes.symbol_topics import SymbolTopics

        return tuple(SymbolTopics(item, self._router, self._base) for item in self._config.bridge)

    async def _open_serial_ports(self) -> None:
        try:
            await self.serial.start()
        except SerialPortError as fault:
            raise ConfigError(str(fault)) from None

    async def _open_discovery(self, host: str, port: int | None) -> None:
        """Answer searches. Without a port that was asked for only where it does no harm."""
        if port is None and self.listener.port != TCP_PORT:
            return
        endpoint = DiscoveryEndpoint(
            self.info,
            self._router.routes,
            _users(self._config),
            lambda: self._names.known(_NAMES_KNOWN_WITHIN),
        )
        try:
            await endpoint.open(self.listener.host or host, UDP_PORT if port is None else port)
        except OSError as taken:
            if port is not None:
                raise OSError(f"UDP port {port}: {reason(taken)}") from taken
            log.info("searches are not answered, UDP port %d: %s", UDP_PORT, reason(taken))
            return
        self.discovery = endpoint

    async def close(self) -> None:
        """Close everything."""
        for bridge in self.bridges:
            await bridge.close()
        if self.uplinks is not None:
            await self.uplinks.close()
        self._names.close()
        if self.discovery is not None:
            await self.discovery.close()
        for network in self.mqtt:
            await network.close()
        await self.serial.close()
        if self.secure is not None:
            await self.secure.close()
        await self.listener.close()
