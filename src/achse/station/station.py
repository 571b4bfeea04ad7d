"""The station: router, devices and domain put together, and the one cycle that drives them.

Time belongs to the station: integer nanoseconds that only `step` moves. Nothing below reads a
clock; `advance` is virtual time, `running` lets a pacer call the same step by the wall clock.
Time stamps are those of `Station.clock`, see `achse.station.clocks.clock`.
"""

import asyncio
import hashlib
import logging
import math
import time
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from achse.ams import AdsState
from achse.devices.scope import ScopeDevice
from achse.devices.station import SERVICE_PORT, StationService
from achse.devices.system import SystemDevice
from achse.faults.active import Faults
from achse.faults.fault import FaultError
from achse.motion import Nc
from achse.plc import PlcRuntime
from achse.router import Router
from achse.router.tap import Taps
from achse.scope import ScopeChannel, ScopeTrigger
from achse.scope.definition import DEFAULT_LENGTH
from achse.server import Device, Usage
from achse.station.building.assembly import assemble, idle, permanent
from achse.station.building.building import Ground, Parts
from achse.station.building.nc import velocity_warnings
from achse.station.building.scope import StationScope
from achse.station.clocks.agenda import Agenda
from achse.station.clocks.clock import StationClock
from achse.station.clocks.cycle import Cycle, Phase
from achse.station.clocks.pacing import Pace, Pacer, run_unpaced
from achse.station.clocks.phases import ChangePhase
from achse.station.clocks.priority import (
    MASTER_PRIORITY,
    OrdinaryProcess,
    StarvationGuard,
    run_first,
)
from achse.station.collection import collect_remains
from achse.station.configuration.station_file import ConfigError, StationConfig, load
from achse.station.persistence.persistent_data import PersistentData
from achse.station.persistence.persistent_image import PersistentImage
from achse.station.routes.addresses import net_id_at
from achse.station.routes.network import Network
from achse.station.routes.route_file import RouteFile
from achse.station.running.metrics import MetricsPort
from achse.station.running.statistics import statistics
from achse.station.state_requests import StateRequests
from achse.transport.tcp import TcpListener

if TYPE_CHECKING:
    from achse.ethercat.terminals import AnalogTerminal, DigitalTerminal
    from achse.faults.drive_list import DriveFaults
    from achse.station.buses.axis_bus import AxisBus
    from achse.station.buses.ethercat_bus import EthercatBus
    from achse.station.buses.interface_bus import InterfaceBus

__all__ = ["RunningStation", "Station"]

log = logging.getLogger("achse.station")

DEMO = Path(__file__).with_name("demo.toml")
"""The demo station's configuration."""

DEFAULT_EPOCH_NS = 1_767_225_600_000_000_000
"""Station time 0 unless told otherwise: 2026-01-01 UTC, so that equal runs give equal stamps."""


_STRETCH = 64
"""Ticks that an unpaced station does before it looks whether to go on."""


class Station:
    """A motion station.

    Build one from a `StationConfig`, a file (`Station.load`) or the demo (`Station.demo`). In a
    test: `station.advance(0.5)`. As a server: `async with station.running() as listener`.
    """

    def __init__(
        self,
        config: StationConfig | None = None,
        *,
        base: Path | None = None,
        epoch_ns: int = DEFAULT_EPOCH_NS,
    ) -> None:
        """`base` is where relative names in the configuration begin; `epoch_ns` is the Unix time
        at station time 0, for time stamps, until the station runs at the wall clock's pace.
        Raises ConfigError."""
        if not isinstance(config, StationConfig | None):
            raise TypeError(
                f"a StationConfig expected, got {config!r:.80}; Station.load(file) reads a file"
            )
        self.config = config or StationConfig()
        self.cycle: Cycle = Cycle()
        """Cycle of the station; others may add phases of their own, which stay through restarts."""
        self.clock: StationClock = StationClock(self.cycle, epoch_ns)
        """Calling it returns the time stamp of the present cycle, Unix ns."""
        self._agenda = Agenda(self.cycle)
        self.router = Router(self.config.router.net_id or net_id_at(self.config.router.host))
        self._base = base or Path()
        RouteFile(self.config, self.router, self._base)
        self.devices: Sequence[Device] = ()
        limits = self.config.limits
        taps = Taps(
            *(self.router, time.time_ns),
            spared=SERVICE_PORT,
            limit=limits.tap_bytes,
            most=limits.taps,
        )
        self.usage = Usage(limits.limits())
        """Resources that clients use at all devices together."""
        self.service = StationService(self, taps)
        self.service.limit(limits.limits())
        self._ground = Ground(
            config=self.config,
            router=self.router,
            base=self._base,
            clock=self.clock,
            usage=self.usage,
            pace=lambda: self.pace,
        )
        self._ground.share(self.service)
        self.service.attach(self.router, SERVICE_PORT)
        self._requests = StateRequests(self)
        self._kept = (*permanent(self._ground, self._requests, lambda: self.devices), self.service)
        """Devices that stay through restarts, the system service first."""
        self.pace: Pace | None = None
        """Pace by which the running station follows the wall clock; None in virtual time."""
        self._persistent = PersistentData(self.config, self._base)
        parts = assemble(self._ground, self._kept)
        self._persistent.load(parts.nc, parts.plcs, self.save)
        self.nc: Nc | None
        self.buses: Sequence[AxisBus]
        """Buses that have drives."""
        self.fieldbuses: Mapping[str, EthercatBus | InterfaceBus]
        """All by name: their masters, slaves and figures."""
        self.terminals: Mapping[str, DigitalTerminal | AnalogTerminal] = {}
        """Virtual terminals by name: what is at their inputs, what their outputs do."""
        self.plcs: Mapping[int, PlcRuntime]
        self.cycle.tick_ns = parts.tick_ns
        self._changes = ChangePhase()
        self.cycle.add(self._changes)
        self._phases: Sequence[Phase] = ()
        self._digests: Sequence[Callable[[], bytes]] = ()
        self._ends: Sequence[Callable[[], None]] = ()
        self._take(parts)
        self.ended = False
        """True after a shutdown: no device answers any more."""
        self._on_end: Callable[[], None] | None = None
        self._owed_ns = 0
        """Time requested of `advance` beyond whole ticks."""
        self.listeners: Sequence[TcpListener] = ()
        """Listeners of the running station."""
        self.faults = Faults(self)
        """Faults to inject, now and later."""
        for number, planned in enumerate(self.config.fault, 1):
            try:
                self.faults.add(planned.fault())
            except FaultError as failure:
                raise ConfigError(f"fault[{number}].{failure}") from None

    @classmethod
    def load(
        cls,
        path: str | Path,
        *,
        net_id: str | None = None,
        host: str | None = None,
        interfaces: Mapping[str, str] | None = None,
        redundant: Mapping[str, str] | None = None,
        epoch_ns: int = DEFAULT_EPOCH_NS,
    ) -> Self:
        """A station from a station.toml; `net_id` and `host` replace those in there, `interfaces`
        (by name of the bus, "" for the only one) where the slaves of buses are, `redundant` where
        the other ends of their lines are.

        Raises ConfigError, OSError.
        """
        file = Path(path)
        config = load(file, net_id=net_id, host=host, interfaces=interfaces, redundant=redundant)
        try:
            return cls(config, base=file.parent, epoch_ns=epoch_ns)
        except ConfigError as fault:
            raise ConfigError(f"{file}: {fault}") from fault

    @classmethod
    def demo(cls, *, net_id: str | None = None, epoch_ns: int = DEFAULT_EPOCH_NS) -> Self:
        """The station that `achse run` starts without a file: PLC 851, axes X, Y and C."""
        return cls.load(DEMO, net_id=net_id, epoch_ns=epoch_ns)

    @property
    def base(self) -> Path:
        """The folder that paths of the configuration begin at."""
        return self._base

    @property
    def time_ns(self) -> int:
        """Station time, from 0 on."""
        return self.cycle.now_ns

    @property
    def tick_ns(self) -> int:
        """The grid of station time: the greatest common divisor of all cycles."""
        return self.cycle.tick_ns

    @property
    def epoch_ns(self) -> int:
        """Unix time at station time 0, as time stamps have it now."""
        return self.clock.epoch_ns

    def step(self) -> None:
        """One tick of `tick_ns`: every phase that is due, in order."""
        self.cycle.step()

    # state of the whole station ----------------------------------------------------------------

    def restart(self) -> None:
        """Restart in RUN: PLC and NC go with the next cycle and come again after `restart_time`.

        Their ports, notifications and handles go with them; what `nc`, `plcs` and `devices` name
        is another then. A change that is under way goes on, and ends in RUN.
        """
        self._change_to(AdsState.RUN)

    def configure(self) -> None:
        """Go to CONFIG: PLC and NC go with the next cycle; `restart` brings them back."""
        self._change_to(AdsState.CONFIG)

    def shut_down(self, delay_s: float = 0.0, restart: bool = False) -> None:
        """After a delay in station time end, or restart. A running station is finished then.

        Of two shutdowns the earlier one counts, of two restarts too.
        """
        due = self.time_ns + round(delay_s * 1e9)
        end = self._planned_restart if restart else self._end
        dues = [moment for moment, change in self._changes.plans if change == end]
        others = [plan for plan in self._changes.plans if plan[1] != end]
        self._changes.plan(*others, (min(due, *dues) if dues else due, end))

    def _planned_restart(self) -> None:
        wait_ns = self._requests.free_at_ns - self.time_ns
        if wait_ns > 0:
            self.shut_down(wait_ns * 1e-9, restart=True)
        else:
            self.restart()

    @property
    def state(self) -> AdsState:
        """RUN, CONFIG, or STOP while it changes to one of them."""
        return self._system.ads_state

    @property
    def _system(self) -> SystemDevice:
        system = self._kept[0]
        assert isinstance(system, SystemDevice)
        return system

    def _change_to(self, state: AdsState) -> None:
        enter = self._run if state is AdsState.RUN else self._enter_config
        enters = (self._run, self._enter_config)
        arrivals = [due for due, change in self._changes.plans if change in enters]
        others = [plan for plan in self._changes.plans if plan[1] not in enters]
        if arrivals:
            self._changes.plan(*others, (arrivals[0], enter))
        else:
            now = self.time_ns
            arrival = now + self.config.system.restart_time
            self._changes.plan((now, self._leave), (arrival, enter), *others)
        # Who asked for it reads the state as soon as it is answered, and must not find RUN.
        self._system.ads_state = AdsState.STOP

    def _leave(self) -> None:
        self.save()
        for plc in self.plcs.values():
            plc.drop_debugger()
        gone = [device for device in self.devices if device not in self._kept]
        self._ground.leave(gone)
        self._end_parts()
        self._take(idle(self._ground, self._kept, self.tick_ns))
        self._system.ads_state = AdsState.STOP

    def _end_parts(self) -> None:
        for end in self._ends:
            end()
        self._ends = ()

    def _enter_config(self) -> None:
        self._system.ads_state = AdsState.CONFIG

    def _run(self) -> None:
        collect_remains()
        try:
            parts = assemble(self._ground, self._kept)
        except ConfigError as fault:
            log.error("the station cannot start and stays in CONFIG: %s", fault)
            self._enter_config()
            return
        self._persistent.load(parts.nc, parts.plcs, self.save)
        for plc in parts.plcs.values():
            plc.begin(self.time_ns)
        self._take(parts)
        self.faults.renew()
        if self.pace is not None and self.pace.speed == 1:
            self.clock.align()
        self._system.restart_index += 1
        self._system.ads_state = AdsState.RUN
        self._requests.entered_run(self.config.system.restart_time)

    def save(self) -> bool:
        """Keep persistent data as they are now, in the file that `system.persistent_data` names.

        Whatever ends a running station does that too: a restart, a shutdown, the end of `running`.
        Returns False if they cannot be written, which is logged.
        """
        if self.nc is None and not self.plcs:
            return True
        return self._persistent.save(self.nc, self.plcs, self.time_ns)

    def _capture(self) -> PersistentImage | None:
        """Return the persistent data between two cycles; None within one, or without any."""
        if (self.nc is None and not self.plcs) or any(plc.is_held for plc in self.plcs.values()):
            return None
        return self._persistent.capture(self.nc, self.plcs, self.time_ns)

    def _end(self) -> None:
        self.save()
        for plc in self.plcs.values():
            plc.drop_debugger()
        for device in self.devices:
            device.detach()
        self._end_parts()
        self._take(idle(self._ground, (), self.tick_ns))
        self._changes.plan()
        self.ended = True
        self.cycle.halt()
        if self._on_end is not None:
            self._on_end()

    @property
    def warnings(self) -> list[str]:
        """Parts of PLC sources that need a running program; velocities that an axis refuses."""
        found = [f"plc {port}: {text}" for port, plc in self.plcs.items() for text in plc.warnings]
        return found if self.nc is None else [*found, *velocity_warnings(self.nc)]

    def statistics(self) -> dict[str, Any]:
        """Figures about connections, subscriptions, handles, queues and the cycle."""
        return statistics(self)

    def scope(
        self,
        channels: str | ScopeChannel | Iterable[str | ScopeChannel | dict[str, Any]],
        *,
        length: float = DEFAULT_LENGTH,
        triggers: str | ScopeTrigger | Iterable[str | ScopeTrigger] = (),
        pretrigger: float = 0.0,
        combine: str = "any",
        name: str = "python",
    ) -> StationScope:
        """A scope: `with station.scope(["MAIN.fLevel", "500:Axes.X.ActPos"]) as scope:` records.

        `length` in seconds is what its rings hold, `pretrigger` the share of it before the trigger
        (0 to below 1). Channels and triggers are words or objects, see `achse.scope`. Raises
        ScopeError; RuntimeError in CONFIG.
        """
        device = next((each for each in self.devices if isinstance(each, ScopeDevice)), None)
        if device is None:
            raise RuntimeError(f"the station is in {self.state.name}: it has no scope server")
        return StationScope.of(
            *(device, channels),
            length=length,
            triggers=triggers,
            pretrigger=pretrigger,
            combine=combine,
            name=name,
        )

    def online_change(self, port: int | None = None) -> dict[int, int]:
        """Read the declarations of PLC `port` (of all) again, and go on with them.

        Variables that keep name and type keep their values. Clients see another symbol version,
        their handles are out of date. Returns how often each PLC, by its port, has changed so far.
        Raises ConfigError for sources with faults or a port that
        is not a PLC; that PLC then goes on as it was.
        """
        if port is not None and port not in self._sources:
            raise ConfigError(f"port {port} is not a PLC of this station")
        for number, source in self._sources.items():
            if port in (None, number):
                source.reload(self.plcs[number])
        self.faults.renew()
        for warning in self.warnings:
            log.warning("%s", warning)
        return {number: plc.online_changes for number, plc in self.plcs.items()}

    @property
    def drive_faults(self) -> "Sequence[DriveFaults | None]":
        """Faults of the drives of each bus; None for drives in another process.

        A restart builds the buses again and ends their faults.
        """
        return [bus.faults for bus in self.fieldbuses.values()]

    def missing_condition(self, axis_id: int) -> str:
        """Return the reason why an axis on a bus is not ready for operation, empty if it is."""
        return next((told for bus in self.buses if (told := bus.missing_condition(axis_id))), "")

    def source_files(self, port: int) -> Mapping[str, str]:
        """Return the paths of a PLC's own source files, by the names they have in faults."""
        source = self._sources.get(port)
        return {} if source is None else source.files()

    def _take(self, parts: Parts) -> None:
        """Consist of `parts`; phases that others added stay."""
        self.nc = parts.nc
        self.buses = parts.buses
        self.fieldbuses = parts.fieldbuses
        self.terminals = parts.terminals
        self.plcs = parts.plcs
        self._sources = parts.sources
        self.devices = parts.devices
        self._digests = parts.digests
        self._ends = parts.ends
        self.cycle.replace(self._phases, parts.phases)
        self._phases = parts.phases

    def at(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` at a station time, before the NC; with the next tick if that is over."""
        self._agenda.add(due_ns, action)

    def forget(self, action: Callable[[], None]) -> None:
        """Do not call an action of `at` any more. Unknown is not an error."""
        self._agenda.forget(action)

    @property
    def strict(self) -> bool:
        """True if each remote host has one TCP connection, as the configuration says."""
        return self.config.router.strict

    def advance(self, seconds: float) -> None:
        """Let `seconds` of station time pass, in whole ticks; a rest is kept for the next call."""
        if not 0 <= seconds < math.inf:
            raise ValueError(f"time goes forward and ends, got {seconds} s")
        ticks, self._owed_ns = divmod(self._owed_ns + round(seconds * 1e9), self.tick_ns)
        self.cycle.go_to(self.time_ns + ticks * self.tick_ns)

    def digest(self) -> str:
        """Hash over all state of all devices; equal histories give equal digests."""
        state = hashlib.blake2b(digest_size=16)
        state.update(self.time_ns.to_bytes(8, "little"))
        for part in self._digests:
            state.update(part())
        return state.hexdigest()

    @asynccontextmanager
    async def running(
        self,
        host: str | None = None,
        tcp_port: int | None = None,
        *,
        udp_port: int | None = None,
        speed: float = 1.0,
        until: float | None = None,
        let_everybody_in: bool | None = None,
    ) -> AsyncIterator["RunningStation"]:
        """Serve clients over AMS/TCP while the station runs `speed` times the wall clock.

        At speed 1 the time stamp of a cycle is the wall clock at the moment it was due; at others
        it goes on from `epoch_ns` in station time.

        `speed` may be `math.inf`: as fast as the machine can; with 0 time stands, until `advance`
        is called in the station's loop. `until` ends the cycle at that station time (s).

        `host` does not change the NetId, which was derived from the configuration's. Searches are
        answered at `udp_port`, see `RouterConfig`; routes are dialled when needed.
        Raises OSError if a port is taken, ConfigError for an address beyond this computer without
        `strict` and without `let_everybody_in` (None: as the configuration says), and for a bus on
        an interface at another `speed` than 1 or 0.
        """
        for name, bus in _on_interfaces(self.fieldbuses).items():
            if speed not in (0, 1):
                where = f"bus {name}: slaves on {bus.interface}"
                raise ConfigError(f"{where} need speed 1, got {speed:g}")
        if speed == 1:
            self.clock.align()
        network = Network(self.config, self.router, self._system.version, self._base)
        await network.open(host, tcp_port, udp_port, let_everybody_in)
        metrics = MetricsPort(self.statistics, lambda: self.pace)
        try:
            metrics.open(self.config.metrics)
        except BaseException:
            await network.close()
            raise
        opened = network.listeners
        self.listeners = (*self.listeners, *opened)
        self.faults.renew()
        cycle = asyncio.create_task(self._go_on(speed, until), name="the station's cycle")
        snapshots = asyncio.create_task(
            self._persistent.write_snapshots(self._capture), name="writing of snapshots"
        )
        for task in (cycle, snapshots):
            task.add_done_callback(_tell_failure)
        try:
            with self._system.files_beside(asyncio.get_running_loop()):
                yield RunningStation(network, metrics, cycle)
        finally:
            cycle.cancel()
            snapshots.cancel()
            await asyncio.gather(cycle, snapshots, return_exceptions=True)
            for each in self.fieldbuses.values():
                each.close()
            self.save()
            await metrics.close()
            await network.close()
            self._system.files.close_all()
            self.listeners = tuple(each for each in self.listeners if each not in opened)

    def _promptly(self) -> StarvationGuard | None:
        """Run before other programs, if a bus on an interface asks for it and the system allows."""
        buses = _on_interfaces(self.fieldbuses).values()
        if any(bus.plan.bus.real_time for bus in buses) and run_first(MASTER_PRIORITY):
            return StarvationGuard(MASTER_PRIORITY, "cycles of the station", OrdinaryProcess())
        return None

    async def _go_on(self, speed: float, until: float | None) -> None:
        end_ns = math.inf if until is None else round(until * 1e9)
        ended = asyncio.Event()
        self._on_end = ended.set
        if self.ended:
            return
        if speed == 0:
            await ended.wait()
            return
        if math.isinf(speed):
            stretch = _STRETCH * self.tick_ns
            await run_unpaced(
                lambda: self.cycle.go_to(int(min(end_ns, self.time_ns + stretch))),
                lambda: self.ended or self.time_ns >= end_ns,
            )
            return

        guard = self._promptly()

        def step() -> None:
            if guard is not None:
                guard.look()
            if self.time_ns < end_ns:
                self.step()
            if self.time_ns >= end_ns:
                ended.set()

        async with Pacer(step, self.tick_ns, speed, self.clock) as pacer:
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


def _on_interfaces(
    buses: "Mapping[str, EthercatBus | InterfaceBus]",
) -> "Mapping[str, InterfaceBus]":
    """Return the buses whose slaves are on an interface, by name."""
    if not buses:
        return {}
    from achse.station.buses.interface_bus import (
        InterfaceBus,  # without a bus nothing of it is loaded
    )

    return {name: bus for name, bus in buses.items() if isinstance(bus, InterfaceBus)}


def _tell_failure(task: "asyncio.Task[None]") -> None:
    """A broken cycle leaves clients connected to a station that stands: say so at once."""
    if not task.cancelled() and (failure := task.exception()) is not None:
        log.error("%s broke: %r", task.get_name(), failure)


class RunningStation:
    """A station in operation: where it listens, and its end."""

    def __init__(self, network: Network, metrics: MetricsPort, cycle: "asyncio.Task[None]") -> None:
        self.network = network
        self.metrics = metrics
        self.listener = network.listener
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
