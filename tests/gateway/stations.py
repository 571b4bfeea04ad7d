"""Stations over loopback that are the targets of a gateway."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

from achse.gateway.configuration import GatewayConfig
from achse.gateway.gateway import Gateway
from achse.station import RunningStation, Station
from achse.station.configuration.station_file import parse
from achse.station.configuration.validation import validated

NET_ID = "5.1.2.3.1.1"
OWN = "5.7.7.7.1.1"


@asynccontextmanager
async def running_target(tcp_port: int = 0, **document: Any) -> AsyncIterator[RunningStation]:
    """Run a station without devices of its own; it answers searches."""
    router = {"net_id": NET_ID, **document.pop("router", {})}
    station = Station(parse({"router": router, **document}, "a.toml"))
    async with station.running("127.0.0.1", tcp_port, udp_port=0, speed=0) as running:
        yield running


def gateway(*targets: dict[str, Any], **document: Any) -> Gateway:
    """Return a gateway that is known by OWN."""
    router = {"net_id": OWN, **document.pop("router", {})}
    config = validated(
        GatewayConfig, {"router": router, "target": list(targets), **document}, "router.toml"
    )
    return Gateway(config)


def target_at(running: RunningStation, **keys: Any) -> dict[str, Any]:
    """Return the table of a target."""
    where = {"host": f"127.0.0.1:{running.tcp_port}", "udp_port": running.udp_port}
    return {**where, "name": "press", **keys}


async def until(condition: Callable[[], object]) -> None:
    """Give the loop turns until the condition holds."""
    while not condition():  # noqa: ASYNC110 - sockets tell nobody
        await asyncio.sleep(0.001)
