"""Operation of a station: its cycle follows the wall clock while clients are served."""

import asyncio
import logging
import math
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from achse.station.building.building import Ground
from achse.station.clocks.cycle import Cycle
from achse.station.clocks.pacing import Pace, Pacer, run_unpaced
from achse.station.clocks.priority import (
    MASTER_PRIORITY,
    OrdinaryProcess,
    StarvationGuard,
    run_first,
)
from achse.station.configuration.station_file import StationConfig
from achse.station.configuration.types import ConfigError
from achse.station.routes.network import Network
from achse.station.running.metrics import station_families
from achse.station.running.metrics_port import MetricsPort
from achse.station.running.states import StationStates
from achse.transport.tcp.listener import TcpListener

if TYPE_CHECKING:
    from achse.station.buses.interface_bus import InterfaceBus

log = logging.getLogger("achse.station")

_STRETCH = 64
"""Ticks that an unpaced station does before it looks whether to go on."""


class RunningStation:
    """A station in operation: where it listens, and its end."""

    def __init__(self, network: Network, metrics: MetricsPort, cycle: "asyncio.Task[None]") -> None:
        self.network = network
        self.metrics = metrics
        self.listener = network.listener
        self.is_saved = True
        """False if persistent data could not be written at the end, which is logged."""
        self._cycle = cycle

    @property
    def host(self) -> str:
        return self.listener.host

    @property
    def tcp_port(self) -> int:
        return self.listener.port

    @property
    def udp_port(self) -> int | None:
        """UDP port that answers searches, None without one."""
        discovery = self.network.discovery
        return None if discovery is None else discovery.port

    async def finished(self) -> None:
        """Wait until the cycle ends (`until` reached); raises what broke it."""
        await asyncio.shield(self._cycle)


class Operation:
    """The cycle of a station in real time, and all that works beside it."""

    def __init__(
        self,
        cycle: Cycle,
        ground: Ground,
        states: StationStates,
        figures: Callable[[], Mapping[str, Any]],
        renewed: Callable[[], None],
    ) -> None:
        """`figures()` returns the statistics; `renewed` is called when there are more listeners."""
        self._cycle = cycle
        self._ground = ground
        self._states = states
        self._figures = figures
        self._renewed = renewed
        self.pace: Pace | None = None
        """Pace by which the cycle follows the wall clock; None in virtual time."""
        self.listeners: Sequence[TcpListener] = ()
        """Open listeners."""

    @asynccontextmanager
    async def run(
        self,
        host: str | None,
        tcp_port: int | None,
        udp_port: int | None,
        *,
        speed: float,
        until: float | None,
        let_everybody_in: bool | None,
    ) -> AsyncIterator[RunningStation]:
        """Serve clients, see `Station.running`. Raises OSError, ConfigError."""
        ground, states = self._ground, self._states
        for name, bus in self._interfaces.items():
            if speed not in (0, 1):
                where = f"bus {name}: slaves on {bus.interface}"
                raise ConfigError(f"{where} need speed 1, got {speed:g}")
        if speed == 1:
            ground.clock.align()
        system = states.system
        network = Network(
            *(ground.config, ground.router, system.version, ground.base),
            any_client_may=any_client_may(ground.config),
        )
        await network.open(host, tcp_port, udp_port, let_everybody_in)
        metrics = MetricsPort(lambda: station_families(self._figures(), self.pace))
        try:
            metrics.open(ground.config.metrics)
        except BaseException:
            await network.close()
            raise
        opened = network.listeners
        self.listeners = (*self.listeners, *opened)
        self._renewed()
        cycle = asyncio.create_task(self._go_on(speed, until), name="the station's cycle")
        snapshots = asyncio.create_task(
            states.persistent.write_snapshots(states.capture), name="writing of snapshots"
        )
        for task in (cycle, snapshots):
            task.add_done_callback(_log_failure)
        running = RunningStation(network, metrics, cycle)
        try:
            with system.files_beside(asyncio.get_running_loop()):
                yield running
        finally:
            cycle.cancel()
            snapshots.cancel()
            await asyncio.gather(cycle, snapshots, return_exceptions=True)
            for each in states.parts.fieldbuses.values():
                each.close()
            running.is_saved = states.save()
            await metrics.close()
            await network.close()
            system.files.close_all()
            self.listeners = tuple(each for each in self.listeners if each not in opened)

    @property
    def _interfaces(self) -> "Mapping[str, InterfaceBus]":
        """The buses whose slaves are on an interface, by name."""
        buses = self._states.parts.fieldbuses
        if not buses:
            return {}
        # Without a bus nothing of EtherCAT is loaded.
        from achse.station.buses.interface_bus import InterfaceBus

        return {name: bus for name, bus in buses.items() if isinstance(bus, InterfaceBus)}

    def _promptly(self) -> StarvationGuard | None:
        """Run before other programs, if a bus on an interface asks for it and the system allows."""
        buses = self._interfaces.values()
        if any(bus.plan.bus.real_time for bus in buses) and run_first(MASTER_PRIORITY):
            return StarvationGuard(MASTER_PRIORITY, "cycles of the station", OrdinaryProcess())
        return None

    async def _go_on(self, speed: float, until: float | None) -> None:
        end_ns = math.inf if until is None else round(until * 1e9)
        ended = asyncio.Event()
        states, station_cycle = self._states, self._cycle
        states.on_end = ended.set
        if states.ended:
            return
        if speed == 0:
            await ended.wait()
            return
        if math.isinf(speed):
            stretch = _STRETCH * station_cycle.tick_ns
            await run_unpaced(
                lambda: station_cycle.go_to(int(min(end_ns, station_cycle.now_ns + stretch))),
                lambda: states.ended or station_cycle.now_ns >= end_ns,
            )
            return

        guard = self._promptly()

        def step() -> None:
            if guard is not None:
                guard.look()
            if station_cycle.now_ns < end_ns:
                station_cycle.step()
            if station_cycle.now_ns >= end_ns:
                ended.set()

        async with Pacer(step, station_cycle.tick_ns, speed, self._ground.clock) as pacer:
            self.pace = pacer.pace
            ends = [asyncio.create_task(pacer.failed()), asyncio.create_task(ended.wait())]
            try:
                done, _ = await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
                for end in done:
                    await end
            finally:
                if guard is not None:
                    guard.close()
                self.pace = None
                for end in ends:
                    end.cancel()


def _log_failure(task: "asyncio.Task[None]") -> None:
    """Log a broken cycle at once: clients stay connected to a station that is halted."""
    if not task.cancelled() and (failure := task.exception()) is not None:
        log.error("%s broke: %r", task.get_name(), failure)


def any_client_may(config: StationConfig) -> list[str]:
    """Return what every client may at a station that lets all clients in."""
    may = [
        "read and write variables, parameters and process data, and move axes",
        "stop, restart and shut down the station",
        "record the traffic of others, and add and clear faults (port 26000)",
    ]
    if config.system.root is not None:
        may.append(f"read, write and delete files below {config.system.root}")
    if config.router.routes_over_ads:
        may.append("add and remove routes")
    if config.system.programs:
        may.append(f"start programs of this computer: {', '.join(config.system.programs)}")
    return may
