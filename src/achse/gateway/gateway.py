"""The gateway: a router, its listeners and its targets, without devices of a station.

It answers at three ports itself: 1 (its figures), 10000 (the state and the routes) and 26000 (the
traffic).
"""

import asyncio
import contextlib
import logging
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from achse.ams import NetId
from achse.codes.ports import ROUTER_PORT, SYSTEM_PORT
from achse.codes.station import SERVICE_PORT
from achse.devices.router import RouterDevice
from achse.devices.system.device import VERSION, SystemDevice
from achse.gateway.choices import resubscribe_group
from achse.gateway.configuration import GatewayConfig, TargetConfig
from achse.gateway.figures import statistics, statistics_group
from achse.gateway.journal_file import opened_journal
from achse.gateway.metrics import gateway_families
from achse.gateway.registration import register
from achse.gateway.requests import OwnRequests
from achse.gateway.target import Target
from achse.gateway.traffic import TrafficDevice
from achse.router import LOOPBACK_NET_ID, Router
from achse.router.forwarding.resubscription import Resubscription
from achse.server import Device
from achse.station.routes.addresses import net_id_at
from achse.station.routes.network import Network
from achse.station.routes.route_file import RouteFile
from achse.station.running.metrics_port import MetricsPort
from achse.transport.own_address import address_for_others, address_towards
from achse.transport.tcp.listener import TcpListener
from achse.transport.uplinks.uplink import Uplink

log = logging.getLogger("achse.gateway")

_TICK = 0.1
"""Seconds between two looks at the subscriptions of the router's own devices."""

_SWEEP_TICKS = 10
"""Ticks between two sweeps of clients that are gone."""

_SETTLED_WITHIN = 2.0
"""Seconds that targets have to be found and reached until the router is ready without them."""


class Gateway:
    """A router that many programs use to reach targets; a target sees one connection.

    `base` is where relative names in the configuration begin. In `state`, a folder, a router that
    is killed leaves the names of the handles that the next one releases. Raises ConfigError.
    """

    def __init__(
        self, config: GatewayConfig, *, base: Path | None = None, state: Path | None = None
    ) -> None:
        self.config = config
        self._state = state
        self._base = base or Path()
        self.router = Router(config.router.net_id or _own_net_id(config), source_nat=True)
        choices = self.router.resubscription = Resubscription([each.rule for each in config.client])
        RouteFile(config, self.router, self._base)
        self.network = Network(
            *(config, self.router, VERSION, self._base),
            any_client_may=("do at the targets what the targets let this router do",),
        )
        self.targets: Sequence[Target] = ()
        """Targets with their states, while it runs."""
        self.metrics = MetricsPort(lambda: gateway_families(statistics(self)))
        self._start_ns = time.time_ns() - time.monotonic_ns()
        routes, clock = self.router.routes, self._clock
        self.devices: Sequence[Device] = (
            SystemDevice(
                clock=clock,
                routes=routes,
                routes_writable=config.router.routes_over_ads,
                name=self.network.name,
            ),
            RouterDevice(
                self.router,
                lambda: self.devices,
                clock=clock,
                further=(
                    statistics_group(self),
                    resubscribe_group(choices, lambda: self.devices[1].request_way),
                ),
            ),
            TrafficDevice(self.router, SERVICE_PORT, clock=clock),
        )
        ports = (SYSTEM_PORT, ROUTER_PORT, SERVICE_PORT)
        for device, port in zip(self.devices, ports, strict=True):
            device.attach(self.router, port)

    @property
    def listeners(self) -> Sequence[TcpListener]:
        """Listeners of TCP, plain and secure."""
        return self.network.listeners

    def _clock(self) -> int:
        return self._start_ns + time.monotonic_ns()

    @asynccontextmanager
    async def running(
        self,
        host: str | None = None,
        tcp_port: int | None = None,
        *,
        udp_port: int | None = None,
        let_everybody_in: bool | None = None,
    ) -> AsyncIterator["Gateway"]:
        """Serve clients and keep the links to the targets. Raises OSError, ConfigError."""
        with opened_journal(NetId(self.router.net_id), self._state) as journal:
            self.router.journal = journal
            async with self._open(host, tcp_port, udp_port, let_everybody_in):
                yield self

    @asynccontextmanager
    async def _open(
        self,
        host: str | None,
        tcp_port: int | None,
        udp_port: int | None,
        let_everybody_in: bool | None,
    ) -> AsyncIterator[None]:
        self.metrics.open(self.config.metrics)
        try:
            await self.network.open(host, tcp_port, udp_port, let_everybody_in)
        except BaseException:
            await self.metrics.close()
            raise
        requests = OwnRequests(self.router)
        self.targets = [
            Target(each, self.router, requests, self._uplink, self._register)
            for each in self.config.target
        ]
        tasks = [asyncio.create_task(self._serve_devices(), name="devices of the router")]
        tasks += [
            asyncio.create_task(each.run(), name=f"target {each.config.title}")
            for each in self.targets
        ]
        for task in tasks:
            task.add_done_callback(_report_failure)
        try:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_SETTLED_WITHIN):
                    await asyncio.gather(*(each.settled.wait() for each in self.targets))
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self.metrics.close()
            await self.network.close()
            requests.close()

    async def _serve_devices(self) -> None:
        ticks = 0
        while True:
            await asyncio.sleep(_TICK)
            ticks += 1
            now = self._clock()
            for device in self.devices:
                device.notifications.tick(now)
                if ticks % _SWEEP_TICKS == 0:
                    device.sweep(now)

    def _uplink(self, net_id: NetId) -> Uplink | None:
        uplinks = self.network.uplinks
        return None if uplinks is None else uplinks.get(net_id)

    async def _register(self, target: TargetConfig, password: str) -> None:
        net_id = NetId(self.router.net_id)
        loop = asyncio.get_running_loop()
        host = target.endpoint[0]
        await register(
            *(target, password),
            name=self.network.name,
            net_id=net_id,
            address=await loop.run_in_executor(None, address_towards, host),
            identity=self.network.identity,
        )


def _own_net_id(config: GatewayConfig) -> NetId:
    """Return the NetId by which targets know the router: its address towards the first, with .1.1.

    With .1.2 where the target is on this computer: 127.0.0.1.1.1 is each router's name for itself.
    """
    host = address_for_others(config.router.host)
    if config.target:
        target = config.target[0].endpoint[0]
        with contextlib.suppress(OSError):
            host = address_towards(target)
    net_id = net_id_at(host)
    return NetId("127.0.0.1.1.2") if net_id == LOOPBACK_NET_ID else net_id


def _report_failure(task: "asyncio.Task[None]") -> None:
    if not task.cancelled() and (failure := task.exception()) is not None:
        log.error("%s broke: %r", task.get_name(), failure)
