"""A station while it is put together: what each of its parts is made from, and adds.

A part is a function that gets the `Building` and adds devices, phases and states; the row in
`achse.station.building.assembly.PARTS` names it.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, Protocol

from achse.ams import RouterError
from achse.devices.plc import PlcDevice
from achse.motion import Nc
from achse.plc import PlcRuntime
from achse.router import Router
from achse.server import Device, Usage
from achse.station.clocks.clock import StationClock
from achse.station.clocks.cycle import IDLE_TICK_NS, Phase
from achse.station.clocks.pacing import Pace
from achse.station.clocks.phases import NcPhase, NotificationPhase, upkeep
from achse.station.configuration.station_file import StationConfig
from achse.station.configuration.types import ConfigError
from achse.station.plcs.sources import PlcSource

if TYPE_CHECKING:
    from achse.station.buses.axis_bus import AxisBus
    from achse.station.buses.ethercat_bus import EthercatBus
    from achse.station.buses.interface_bus import InterfaceBus
    from achse.station.buses.plan import TerminalDevice
    from achse.station.plants.plant import Plant

_SHORTEST_TICK_NS = 10_000
"""All cycles are multiples of one tick; a shorter one would only burn time."""


class NcExchange(Protocol):
    """Exchange of the inputs of axes before a cycle of the NC, of their outputs after it."""

    def before(self) -> None: ...

    def after(self) -> None: ...

    def many(self, count: int) -> int:
        """Up to `count` cycles with the NC in one go; how many were done."""

    def missing_condition(self, axis_id: int) -> str:
        """Return the reason why an axis is not ready, empty if it is or belongs to another."""


class Ground(NamedTuple):
    """Environment of a station, whatever parts it has."""

    config: StationConfig
    router: Router
    base: Path
    """Folder that relative names in the configuration refer to."""
    clock: StationClock
    """The Unix time of the present cycle, and station time."""
    usage: Usage
    """Resources that clients use at all devices together."""
    pace: Callable[[], Pace | None]
    """Returns the pace that follows the wall clock; None in virtual time."""

    def attach(self, device: Device, *ports: int) -> None:
        """Let a device answer at these ports, within the limits. Raises ConfigError."""
        self.share(device)
        for port in ports:
            device.limit(self.config.limits.limits())
            self.router.release(port)
            try:
                device.attach(self.router, port)
            except RouterError as taken:
                raise ConfigError(f"port {port} for {device.name}: {taken}") from taken

    def share(self, device: Device) -> None:
        """Count what a device's clients hold with the others, and tick it in station time."""
        device.share(self.usage, self.epoch)

    def epoch(self) -> int:
        """Unix time at station time 0, as the present mapping has it."""
        return self.clock.epoch_ns

    def leave(self, devices: Iterable[Device]) -> None:
        """Take devices off their ports, which stay reserved for those that come after them."""
        for device in devices:
            self.router.reserve(address.port for address in device.addresses)
            device.detach()


class Parts(NamedTuple):
    """Parts of a station."""

    nc: Nc | None
    plcs: Mapping[int, PlcRuntime]
    sources: Mapping[int, PlcSource]
    """Source of the declarations of each PLC, by port."""
    devices: Sequence[Device]
    phases: Sequence[Phase]
    tick_ns: int
    digests: Sequence[Callable[[], bytes]]
    buses: "Sequence[AxisBus]" = ()
    terminals: "Mapping[str, TerminalDevice]" = MappingProxyType({})
    ends: Sequence[Callable[[], None]] = ()
    """Functions to call when the station drops these parts."""
    fieldbuses: "Mapping[str, EthercatBus | InterfaceBus]" = MappingProxyType({})
    """The buses by name."""
    exchanges: Sequence[NcExchange] = ()
    """Exchanges before and after each cycle of the NC."""
    plants: "Mapping[str, Plant]" = MappingProxyType({})
    """The units of [[fmu]] by name."""


class Building:
    """Station under construction; `permanent_devices` stay through restarts."""

    def __init__(self, ground: Ground, permanent_devices: Sequence[Device] = ()) -> None:
        self.ground = ground
        self.nc: Nc | None = None
        self.buses: list[AxisBus] = []
        """Buses that have drives of axes."""
        self.fieldbuses: dict[str, EthercatBus | InterfaceBus] = {}
        self.terminals: dict[str, TerminalDevice] = {}
        self.plcs: dict[int, PlcRuntime] = {}
        self.plc_devices: dict[int, PlcDevice] = {}
        self.sources: dict[int, PlcSource] = {}
        self.exchanges: list[NcExchange] = []
        """Exchanges before and after each cycle of the NC: buses, then plants."""
        self.plants: Mapping[str, Plant] = MappingProxyType({})
        self._permanent_devices = tuple(permanent_devices)
        self._devices: list[Device] = []
        self._attached: list[Sequence[Device]] = []
        self._finished: tuple[list[Device], NotificationPhase] | None = None
        self._phases: list[Phase] = []
        self._cycles: dict[str, int] = {}
        self._digests: list[Callable[[], bytes]] = []
        self._ends: list[Callable[[], None]] = []

    def attach(self, device: Device, *ports: int) -> None:
        """Add a device that answers at these ports. Raises ConfigError."""
        self._devices.append(device)
        self.ground.attach(device, *ports)

    def add_phase(self, phase: Phase, cycle_ns: int = 0) -> None:
        """Add a phase of the cycle; the tick divides `cycle_ns`, if there is one."""
        self._phases.append(phase)
        if cycle_ns:
            self._cycles[phase.name] = cycle_ns

    def add_attached(self, devices: Sequence[Device], end: Callable[[], None]) -> None:
        """Add devices that are at their ports already, and what takes them off again.

        The sequence may get others while the station runs: `devices_changed`.
        """
        self._attached.append(devices)
        self._ends.append(end)

    def devices_changed(self) -> None:
        """Note that attached devices came or went."""
        if self._finished is not None:
            devices, notify = self._finished
            devices[:] = self.devices
            notify.watch(devices)

    def shift_pace(self, by_ns: int) -> None:
        """Let the cycles to come begin later by this; nothing in virtual time."""
        pace = self.ground.pace()
        if pace is not None and by_ns:
            pace.shift(by_ns)

    def add_end(self, end: Callable[[], None]) -> None:
        """Add what is done when the station leaves its parts."""
        self._ends.append(end)

    def add_interface(self, bus: "InterfaceBus") -> None:
        """Add a bus that lets go of its interface when the station leaves its parts."""
        self._ends.append(bus.close)

    def add_state(self, digest: Callable[[], bytes]) -> None:
        """Add state that the hash of the station is about."""
        self._digests.append(digest)

    @property
    def devices(self) -> Sequence[Device]:
        """Permanent devices, and the devices added so far."""
        return (
            *self._permanent_devices,
            *self._devices,
            *(each for some in self._attached for each in some),
        )

    @property
    def tick_ns(self) -> int:
        """The tick that the cycles so far have in common."""
        return math.gcd(*self._cycles.values()) or IDLE_TICK_NS

    def finish(self, tick_ns: int | None = None) -> Parts:
        """Return all that was added; `tick_ns` is that of the cycles if not given. Raises
        ConfigError."""
        ground = self.ground
        tick_ns = tick_ns or self.tick_ns
        if tick_ns < _SHORTEST_TICK_NS:
            cycles = ", ".join(f"{name} {cycle_ns} ns" for name, cycle_ns in self._cycles.items())
            raise ConfigError(
                f"cycles: expected multiples of a tick of {_SHORTEST_TICK_NS} ns or more,"
                f" got {cycles}"
            )
        devices = list(self.devices)
        nc = None
        if self.nc is not None and self.nc.compiled:
            nc = next(phase for phase in self._phases if isinstance(phase, NcPhase))
        notify = NotificationPhase(
            *(devices, ground.usage.budget, ground.pace, nc), epoch=ground.epoch
        )
        sweep = upkeep(devices, tick_ns, ground.clock)
        self._finished = devices, notify
        return Parts(
            nc=self.nc,
            plcs=self.plcs,
            sources=self.sources,
            devices=devices,
            phases=[*self._phases, notify, sweep],
            tick_ns=tick_ns,
            digests=self._digests,
            buses=self.buses,
            terminals=self.terminals,
            ends=self._ends,
            fieldbuses=self.fieldbuses,
            exchanges=self.exchanges,
            plants=self.plants,
        )

    def abandon(self) -> None:
        """Undo what was attached."""
        self.ground.leave(self.devices[len(self._permanent_devices) :])
        for end in self._ends:
            end()
