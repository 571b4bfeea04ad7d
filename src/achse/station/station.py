"""The station: router, devices and domain put together, and the one cycle that drives them.

Time belongs to the station: integer nanoseconds that only `step` moves. Nothing below reads a
clock; `advance` is virtual time, `running` lets a pacer call the same step by the wall clock.
Time stamps are those of `Station.clock`, see `achse.station.clocks.clock`.
"""

import hashlib
import logging
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from achse.ams import AdsState
from achse.codes.station import SERVICE_PORT
from achse.devices.scope import ScopeDevice
from achse.devices.station import StationService
from achse.faults.active import Faults
from achse.faults.fault import FaultError
from achse.motion import Nc
from achse.plc import PlcRuntime
from achse.router import Router
from achse.router.tap import Taps
from achse.scope import ScopeChannel, ScopeTrigger
from achse.scope.definition import DEFAULT_LENGTH
from achse.server import Device, Usage
from achse.station.building.assembly import permanent
from achse.station.building.building import Ground
from achse.station.building.nc import velocity_warnings
from achse.station.building.scope import StationScope
from achse.station.clocks.clock import StationClock
from achse.station.clocks.cycle import Cycle, PhasePlace
from achse.station.clocks.pacing import Pace
from achse.station.clocks.timer_queue import TimerQueue
from achse.station.configuration.station_file import StationConfig, load
from achse.station.configuration.types import STATION_FILE, ConfigError
from achse.station.persistence.file_port import DISK, FilePort
from achse.station.persistence.persistent_data import PersistentData
from achse.station.routes.addresses import net_id_at
from achse.station.routes.route_file import RouteFile
from achse.station.running.operation import Operation, RunningStation
from achse.station.running.state_requests import StateRequests
from achse.station.running.states import StationStates
from achse.station.running.statistics import statistics
from achse.transport.tcp.listener import TcpListener

if TYPE_CHECKING:
    from achse.faults.drive_list import DriveFaults
    from achse.station.buses.axis_bus import AxisBus
    from achse.station.buses.ethercat_bus import EthercatBus
    from achse.station.buses.interface_bus import InterfaceBus
    from achse.station.buses.plan import TerminalDevice
    from achse.station.plants.plant import Plant

log = logging.getLogger("achse.station")

DEMO = Path(__file__).with_name("demo.toml")
"""The demo station's configuration."""

DEFAULT_EPOCH_NS = 1_767_225_600_000_000_000
"""Station time 0 unless calls otherwise: 2026-01-01 UTC, so that equal runs give equal stamps."""


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
        disk: FilePort = DISK,
    ) -> None:
        """`base` is where relative names in the configuration begin; `epoch_ns` is the Unix time
        at station time 0, for time stamps, until the station runs at the wall clock's pace;
        `disk` has the files of persistent data. Raises ConfigError."""
        if not isinstance(config, StationConfig | None):
            raise TypeError(
                f"a StationConfig expected, got {config!r:.80}; Station.load(file) reads a file"
            )
        self.config = config or StationConfig()
        self.cycle: Cycle = Cycle()
        """Cycle of the station; others may add phases of their own, which stay through restarts."""
        self.clock: StationClock = StationClock(self.cycle, epoch_ns)
        """Calling it returns the time stamp of the present cycle, Unix ns."""
        self._timer_queue = TimerQueue(self.cycle)
        self._behind_cycles = TimerQueue(self.cycle, PhasePlace.UPKEEP, "delayed frames")
        self.router = Router(self.config.router.net_id or net_id_at(self.config.router.host))
        self._base = base or Path()
        RouteFile(self.config, self.router, self._base)
        limits = self.config.limits
        taps = Taps(self.router, time.time_ns, spared=SERVICE_PORT)
        self.usage = Usage(limits.limits())
        """Resources that clients use at all devices together."""
        self.service = StationService(self, taps)
        self.service.limit(limits.limits())
        ground = Ground(
            config=self.config,
            router=self.router,
            base=self._base,
            clock=self.clock,
            usage=self.usage,
            pace=lambda: self.pace,
        )
        ground.share(self.service)
        self.service.attach(self.router, SERVICE_PORT)
        requests = StateRequests(self)
        permanent_devices = (*permanent(ground, requests, lambda: self.devices), self.service)
        persistent = PersistentData(self.config, self._base, disk, document_port=disk)
        self._states = StationStates(
            *(self.cycle, ground, permanent_devices, persistent, requests),
            lambda: self.faults.renew(),
        )
        self._operation = Operation(
            *(self.cycle, ground, self._states, self.statistics), lambda: self.faults.renew()
        )
        self._owed_ns = 0
        """Time requested of `advance` beyond whole ticks."""
        self.faults: Faults = Faults(self)
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
        """Return a station from a station.toml or its folder, or what a solution (`.sln`,
        `.tsproj`), a PLC project, a source or a folder of them has.

        `net_id` and `host` replace those in there, `interfaces` (by name of the bus, "" for the
        only one) where the slaves of buses are, `redundant` where the other ends of their lines
        are. Raises ConfigError, OSError.
        """
        file = Path(path)
        if (file / STATION_FILE).is_file():
            file /= STATION_FILE
        config = load(file, net_id=net_id, host=host, interfaces=interfaces, redundant=redundant)
        try:
            return cls(config, base=file.parent, epoch_ns=epoch_ns)
        except ConfigError as fault:
            raise ConfigError(f"{file}: {fault}") from fault

    @classmethod
    def demo(cls, *, net_id: str | None = None, epoch_ns: int = DEFAULT_EPOCH_NS) -> Self:
        """Return the station that `achse run` starts without a file: PLC 851, axes X, Y and C."""
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
        """Run one tick of `tick_ns`: every phase that is due, in order."""
        self.cycle.step()

    # parts

    @property
    def devices(self) -> Sequence[Device]:
        """All devices, the system service first."""
        return self._states.parts.devices

    @property
    def nc(self) -> Nc | None:
        """The NC; None in CONFIG and without axes."""
        return self._states.parts.nc

    @property
    def plcs(self) -> Mapping[int, PlcRuntime]:
        """The PLCs by port."""
        return self._states.parts.plcs

    @property
    def buses(self) -> "Sequence[AxisBus]":
        """Buses that have drives."""
        return self._states.parts.buses

    @property
    def fieldbuses(self) -> "Mapping[str, EthercatBus | InterfaceBus]":
        """All buses by name: their masters, slaves and figures."""
        return self._states.parts.fieldbuses

    @property
    def terminals(self) -> "Mapping[str, TerminalDevice]":
        """Virtual terminals by name: what is at their inputs, what their outputs do."""
        return self._states.parts.terminals

    @property
    def plants(self) -> "Mapping[str, Plant]":
        """Units of [[fmu]] by name: their inputs, outputs and failures."""
        return self._states.parts.plants

    # state of the whole station

    @property
    def state(self) -> AdsState:
        """RUN, CONFIG, or STOP while it changes to one of them."""
        return self._states.system.ads_state

    @property
    def ended(self) -> bool:
        """True after a shutdown: no device answers any more."""
        return self._states.ended

    def restart(self) -> None:
        """Restart in RUN: PLC and NC go with the next cycle and come again after `restart_time`.

        Their ports, notifications and handles go with them; what `nc`, `plcs` and `devices` name
        is another then. A change that is under way goes on, and ends in RUN.
        """
        self._states.restart()

    def configure(self) -> None:
        """Go to CONFIG: PLC and NC go with the next cycle; `restart` brings them back."""
        self._states.configure()

    def shut_down(self, delay_s: float = 0.0, restart: bool = False) -> None:
        """End or restart after a delay in station time. A running station is finished then.

        Of two shutdowns the earlier one counts, of two restarts too.
        """
        self._states.shut_down(delay_s, restart)

    def save(self) -> bool:
        """Keep persistent data as they are now, in the file that `system.persistent_data` names.

        Whatever ends a running station does that too: a restart, a shutdown, the end of `running`.
        Returns False if they cannot be written, which is logged.
        """
        return self._states.save()

    # what clients and users ask of it

    @property
    def warnings(self) -> list[str]:
        """Parts of PLC sources that need a running program; velocities that an axis refuses."""
        warnings = [
            f"plc {port}: {text}" for port, plc in self.plcs.items() for text in plc.warnings
        ]
        return warnings if self.nc is None else [*warnings, *velocity_warnings(self.nc)]

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
        """Return a scope: `with station.scope(["MAIN.fLevel", "500:Axes.X.ActPos"]) as scope:`
        records.

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
        sources = self._states.parts.sources
        if port is not None and port not in sources:
            raise ConfigError(f"port {port} is not a PLC of this station")
        for number, source in sources.items():
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
        """Return why an axis on a bus or a plant is not ready for operation, empty if it is."""
        exchanges = self._states.parts.exchanges
        return next((why for each in exchanges if (why := each.missing_condition(axis_id))), "")

    def source_files(self, port: int) -> Mapping[str, str]:
        """Return the paths of a PLC's own source files, by the names they have in faults."""
        source = self._states.parts.sources.get(port)
        return {} if source is None else source.files()

    def at(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` at a station time, before the NC; with the next tick if that is over."""
        self._timer_queue.add(due_ns, action)

    def after(self, due_ns: int, action: Callable[[], None]) -> None:
        """Call `action` behind the cycle at a station time, as what clients send is done."""
        self._behind_cycles.add(due_ns, action)

    def forget(self, action: Callable[[], None]) -> None:
        """Do not call an action of `at` any more. Unknown is not an error."""
        self._timer_queue.forget(action)

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
        for part in self._states.parts.digests:
            state.update(part())
        return state.hexdigest()

    def running(
        self,
        host: str | None = None,
        tcp_port: int | None = None,
        *,
        udp_port: int | None = None,
        speed: float = 1.0,
        until: float | None = None,
        let_everybody_in: bool | None = None,
    ) -> AbstractAsyncContextManager[RunningStation]:
        """Serve clients over AMS/TCP while the station runs `speed` times the wall clock.

        At speed 1 the time stamp of a cycle is the wall clock at the moment it was due; at others
        it goes on from `epoch_ns` in station time.

        `speed` may be `math.inf`: as fast as the machine can; with 0 time is halted, until
        `advance` is called in the station's loop. `until` ends the cycle at that station time (s).

        `host` does not change the NetId, which was derived from the configuration's. Searches are
        answered at `udp_port`, see `RouterConfig`; routes are dialled when needed.
        Raises OSError if a port is taken, ConfigError for an address beyond this computer without
        `strict` and without `let_everybody_in` (None: as the configuration says), and for a bus on
        an interface at another `speed` than 1 or 0.
        """
        return self._operation.run(
            *(host, tcp_port, udp_port),
            speed=speed,
            until=until,
            let_everybody_in=let_everybody_in,
        )

    @property
    def pace(self) -> Pace | None:
        """Pace by which the running station follows the wall clock; None in virtual time."""
        return self._operation.pace

    @property
    def listeners(self) -> Sequence[TcpListener]:
        """Listeners of the running station, and those that were admitted."""
        return self._operation.listeners

    def admit(self, listener: TcpListener) -> None:
        """Count a listener that others serve, without sockets, among those of the station."""
        self._operation.listeners = (*self._operation.listeners, listener)
        self.faults.renew()
