"""router.toml: the tables of a station.toml that concern its router, and `[[target]]`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from achse.ams import NetId
from achse.ams.discovery import UDP_PORT
from achse.router.forwarding.resubscription import ClientRule
from achse.router.routes import Route
from achse.station.configuration.http import MetricsConfig, PagesConfig
from achse.station.configuration.network import NetworkConfig
from achse.station.configuration.secure import RouteTlsConfig
from achse.station.configuration.types import (
    ConfigError,
    ConfigTable,
    ConfiguredNetId,
    DurationNs,
    MomentNs,
)
from achse.station.configuration.validation import document_of, validated

_ANY_NET_ID = NetId("1.0.0.0.1.1")
"""NetId of a route that is made for its host alone."""


class TargetConfig(ConfigTable):
    """[[target]]: a router with devices that clients reach through this one."""

    host: str = Field(min_length=1)
    """Name or IP address, with `:port` if it is not 48898."""
    net_id: ConfiguredNetId | None = None
    """Without this key the target is queried over UDP."""
    name: str = ""
    """Name in logs and figures; `host` unless given."""
    udp_port: int = Field(default=UDP_PORT, ge=1, le=65535)
    """UDP port at which the target answers searches and adds routes."""
    user: str = ""
    """User at the target for adding a route to this router where the target refuses it."""
    password: str = ""
    """Password of `user`; ACHSE_PASSWORD unless given."""
    tls: RouteTlsConfig | None = None
    """Secure ADS; the port is 8016 then. With `user` the target learns our certificate."""
    timeout: DurationNs = 5_000_000_000
    """Time to connect, and to answer a query of the router itself."""
    keep_alive: MomentNs = 5_000_000_000
    """Interval between queries of the target's state; 0: none. A target that answers none within
    `timeout` is dialled again."""
    max_fragment: int = Field(default=0, ge=0, le=0xFFFF_FFFF)
    """Longest AMS packet, bytes; 0 for any."""
    resubscribe: bool = False
    """Make subscriptions and symbol handles of programs again when a lost connection is back; else
    the connections of these programs end. For programs that neither choose by themselves nor have
    a [[client]]."""

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        self.route(self.net_id or _ANY_NET_ID)
        return self

    @property
    def title(self) -> str:
        """Name in logs and figures."""
        return self.name or self.host

    @property
    def endpoint(self) -> tuple[str, int]:
        """Host and TCP port to dial."""
        return self.route(_ANY_NET_ID).endpoint()

    def route(self, net_id: NetId) -> Route:
        """Return the entry of the router's table; raises RouteError."""
        return Route(
            name=self.title,
            net_id=net_id,
            host=self.host,
            timeout=self.timeout / 1e9,
            max_fragment=self.max_fragment,
            resubscribe=self.resubscribe,
            tls=None if self.tls is None else self.tls.tls(),
        )


class ClientConfig(ConfigTable):
    """[[client]]: programs at a host, with a NetId, or both."""

    host: str = ""
    """IP address from which they connect; any unless given."""
    net_id: ConfiguredNetId | None = None
    """NetId that they give as theirs; any unless given."""
    resubscribe: bool
    """As in [[target]], for these programs at all targets. The first table that matches applies; a
    program may choose for its connection by itself."""

    @model_validator(mode="after")
    def _is_limited(self) -> Self:
        if not self.host and self.net_id is None:
            raise ValueError("expected host, net_id or both")
        return self

    @property
    def rule(self) -> ClientRule:
        """The rule for the router."""
        return ClientRule(self.resubscribe, self.host, self.net_id)


class GatewayConfig(NetworkConfig):
    """A router without devices."""

    name: str = ""
    """Name of the routes to this router, and of its answer to searches; the host name unless
    given."""
    target: Sequence[TargetConfig] = Field(default=(), max_length=256)
    client: Sequence[ClientConfig] = Field(default=(), max_length=256)
    web: PagesConfig = PagesConfig.model_construct()
    metrics: MetricsConfig = MetricsConfig.model_construct()

    def _unique_keys(self) -> dict[str, list[Any]]:
        return {
            **super()._unique_keys(),
            "target.name": [target.title for target in self.target],
            "target.net_id": [str(target.net_id) for target in self.target if target.net_id],
        }


def configuration_of(
    path: Path | None,
    targets: Sequence[str] = (),
    *,
    net_id: str | None = None,
    host: str | None = None,
    user: str | None = None,
    password: str | None = None,
) -> GatewayConfig:
    """Return the configuration of a router.toml, of further targets (`HOST` or `HOST=NETID`), or of
    both.

    `net_id` and `host` replace those of the file; `user` and `password` are for targets without a
    user. Raises ConfigError; OSError if the file cannot be read.
    """
    document = {} if path is None else document_of(path)
    for key, value in (("net_id", net_id), ("host", host)):
        if value is not None and isinstance(document.setdefault("router", {}), dict):
            document["router"][key] = value
    tables = document.setdefault("target", [])
    if isinstance(tables, list):
        tables += map(_target_table, targets)
        for table in tables:
            if user and isinstance(table, dict) and not table.get("user"):
                table.update({"user": user, "password": password or ""})
    if not tables:
        raise ConfigError("no target: expected --to HOST, or [[target]] in a router.toml")
    return validated(GatewayConfig, document, "--to" if path is None else str(path))


def _target_table(text: str) -> dict[str, str]:
    host, _, net_id = text.partition("=")
    return {"host": host} | ({"net_id": net_id} if net_id else {})
