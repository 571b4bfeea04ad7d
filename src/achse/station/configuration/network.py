"""Tables that a station.toml and a router.toml share: address, routes, ways to other routers."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from achse.router.rights import rights_named
from achse.router.routes import Route
from achse.station.configuration.bridge import BridgeConfig
from achse.station.configuration.mqtt import MqttConfig
from achse.station.configuration.secure import RouteTlsConfig, SecureConfig
from achse.station.configuration.types import (
    ALL_RIGHT_NAMES,
    ConfigTable,
    ConfiguredHash,
    ConfiguredNetId,
    ConfiguredRights,
    DurationNs,
)
from achse.transport.connections.send_budget import DEFAULT_SEND_BUDGET
from achse.transport.serial.port import Parity, SerialPort

_ANY_CASE = frozenset({"axis.name", "route.name"})
"""Names of which the case does not count."""


class RouterConfig(ConfigTable):
    """[router]: the address others see."""

    net_id: ConfiguredNetId | None = None
    """Without this key 127.0.0.1.1.1 on loopback; else the IP address that others reach with .1.1
    behind it: that of `host`, or for 0.0.0.0 that of this computer's default route."""
    host: str = Field(default="127.0.0.1", min_length=1)
    tcp_port: int = Field(default=48898, ge=0, le=65535)
    strict: bool = False
    """True for the behaviour of the original: one TCP connection per remote host, and clients need
    a route."""
    max_connections: int = Field(default=4096, ge=1)
    max_connections_per_host: int = Field(default=2048, ge=1)
    """Of these, those of one host; a further one replaces an idle one, or is refused with 0x508."""
    udp_port: int | None = Field(default=None, ge=0, le=65535)
    """Port that answers searches; 0 takes a free one. Without this key 48899 if it is free, and
    none if the TCP port is not 48898."""
    static_routes: str | None = None
    """A StaticRoutes.xml (relative to the station.toml): read at the start, kept up to date."""
    users: Mapping[str, ConfiguredHash] = {}
    """Users that may change routes by a UDP request with a password: name = "hash as `achse
    hash-password` prints it"."""
    routes_over_ads: bool = False
    """True if port 10000 may change routes (groups 801 and 802). These requests carry no password:
    any client may send them."""
    let_everybody_in: bool = False
    """Listen beyond this computer without `strict`: any client may do anything."""
    rights: ConfiguredRights = ALL_RIGHT_NAMES
    """Rights of clients that have no route, where they may connect; programs on this computer with
    a port of this router have every right."""
    user_rights: Mapping[str, ConfiguredRights] = {}
    """Rights of the routes that a user adds: name = ["read", …]; without it every right."""
    listen: Literal["plain", "secure", "both"] = "plain"
    """Plain AMS/TCP, Secure ADS as [secure] says, or both. With `secure` nothing listens at
    `tcp_port`, and searches are answered only if there is a `udp_port`."""


class RouteConfig(ConfigTable):
    """[[route]]: where the router of another NetId is."""

    name: str
    net_id: ConfiguredNetId
    host: str
    """Name or IP address, with `:port` if it is not 48898."""
    one_way: bool = False
    """True if requests from there are refused."""
    nat: ConfiguredNetId | None = None
    """The NetId it has itself, if `net_id` is only ours for it."""
    timeout: DurationNs = 5_000_000_000
    max_fragment: int = Field(default=0, ge=0, le=0xFFFF_FFFF)
    """Longest AMS packet, bytes; 0 for any."""
    tls: RouteTlsConfig | None = None
    """It goes by Secure ADS; the port is 8016 then."""
    rights: ConfiguredRights = ALL_RIGHT_NAMES
    """Rights of clients that come over this route: `read`, `write`, `state`, `files`, `methods`."""

    @model_validator(mode="after")
    def _can_be(self) -> "RouteConfig":
        self.route()
        return self

    def route(self) -> Route:
        """Return the entry of the router's table; raises RouteError."""
        return Route(
            name=self.name,
            net_id=self.net_id,
            host=self.host,
            one_way=self.one_way,
            nat_net_id=self.nat,
            timeout=self.timeout / 1e9,
            max_fragment=self.max_fragment,
            tls=None if self.tls is None else self.tls.tls(),
            rights=rights_named(self.rights),
        )


class SerialConfig(ConfigTable):
    """[[serial]]: a serial port to a client or a target of the station (extra `serial`).

    A packet on it has 255 bytes at most.
    """

    port: str
    """`/dev/ttyUSB0`, `COM3`, or `socket://host:port` of a serial server."""
    baud: int = 38_400
    parity: Parity = "none"
    stop_bits: int = 1
    net_id: ConfiguredNetId | None = None
    """NetId of the other end: requests for it are sent there."""

    @model_validator(mode="after")
    def _can_be(self) -> "SerialConfig":
        self.serial_port()
        return self

    def serial_port(self) -> SerialPort:
        """Return the port with its settings; raises SerialPortError."""
        return SerialPort(self.port, self.baud, self.parity, self.stop_bits)


class ConnectionLimitsConfig(ConfigTable):
    """[limits]: how many bytes clients may leave unread."""

    unread_bytes: int = Field(default=64 * 1024 * 1024, ge=65_536)
    """Bytes of answers and samples on a connection that is not read; beyond, it is cut off."""
    buffered_bytes: int = Field(default=DEFAULT_SEND_BUDGET, ge=1024 * 1024)
    """Bytes that all connections together leave unread, or send of packets without their end, and
    that wait for a route; beyond, those with the most of them are cut off until an eighth of it is
    free."""


class NetworkConfig(ConfigTable):
    """The tables of a router: its address, its routes and the ways to it."""

    name: str = "achse"
    router: RouterConfig = RouterConfig.model_construct()
    secure: SecureConfig = SecureConfig.model_construct()
    mqtt: Sequence[MqttConfig] = ()
    bridge: Sequence[BridgeConfig] = ()
    route: Sequence[RouteConfig] = ()
    serial: Sequence[SerialConfig] = ()
    limits: ConnectionLimitsConfig = ConnectionLimitsConfig.model_construct()

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        for what, keys in self._unique_keys().items():
            folded = [key.casefold() if what in _ANY_CASE else key for key in keys]
            times = Counter(folded)
            twice = sorted(
                {str(key) for key, fold in zip(keys, folded, strict=True) if times[fold] > 1}
            )
            if twice:
                raise ValueError(f"{what}: each once, got {', '.join(twice)} more than once")
        return self

    def _unique_keys(self) -> dict[str, list[Any]]:
        """Return the values of each key that may not occur twice."""
        return {
            "serial.port": [serial.port for serial in self.serial],
            "route.name": [route.name for route in self.route],
            "route.net_id": [
                *(str(route.net_id) for route in self.route),
                *(str(serial.net_id) for serial in self.serial if serial.net_id),
            ],
        }
