"""State of the whole station: RUN, CONFIG, the way between them, and its end.

    state    what there is                  ends by                    then
    RUN      all parts                      `restart`, `configure`     STOP
    STOP     permanent devices alone        `system.restart_time`      RUN or CONFIG
    CONFIG   permanent devices alone        `restart`                  STOP
    any                                     `shut_down`                RUN by STOP, or the end
    ended    no device answers              -                          -

A station that cannot be built again goes from STOP to CONFIG. All changes happen in the phase
CHANGES of the cycle.
"""

import logging
from collections.abc import Callable, Sequence

from achse.ams import AdsState
from achse.devices.system import SystemDevice
from achse.server import Device
from achse.station.building.assembly import assemble, idle
from achse.station.building.building import Ground, Parts
from achse.station.clocks.cycle import Cycle
from achse.station.clocks.phases import ChangePhase
from achse.station.configuration.types import ConfigError
from achse.station.persistence.persistent_data import PersistentData
from achse.station.persistence.persistent_image import PersistentImage
from achse.station.running.collection import collect_remains
from achse.station.running.state_requests import StateRequests

log = logging.getLogger("achse.station")


class StationStates:
    """The parts that a station has now, and the changes of its state."""

    def __init__(
        self,
        cycle: Cycle,
        ground: Ground,
        permanent_devices: Sequence[Device],
        persistent: PersistentData,
        requests: StateRequests,
        renewed: Callable[[], None],
    ) -> None:
        """Build the parts, and read their persistent data. Raises ConfigError.

        `permanent_devices` stay through restarts, the system service first; `renewed` is
        called when a restart has built other parts.
        """
        self._cycle = cycle
        self._ground = ground
        self._permanent_devices = tuple(permanent_devices)
        self._requests = requests
        self._renewed = renewed
        self.persistent = persistent
        """Data that outlive the parts."""
        self.ended = False
        """True after a shutdown: no device answers any more."""
        self.on_end: Callable[[], None] | None = None
        """Called at the shutdown."""
        self.parts = assemble(ground, self._permanent_devices)
        persistent.load(self.parts.nc, self.parts.plcs, self.save)
        cycle.tick_ns = self.parts.tick_ns
        self._changes = ChangePhase()
        cycle.add(self._changes)
        cycle.replace((), self.parts.phases)

    @property
    def system(self) -> SystemDevice:
        """The system service, whose ADS state is that of the station."""
        system = self._permanent_devices[0]
        assert isinstance(system, SystemDevice)
        return system

    def restart(self) -> None:
        """Go to RUN by STOP. A change that is under way goes on, and ends in RUN."""
        self._change_to(AdsState.RUN)

    def configure(self) -> None:
        """Go to CONFIG by STOP."""
        self._change_to(AdsState.CONFIG)

    def shut_down(self, delay_s: float, restart: bool) -> None:
        """End or restart after a delay in station time.

        Of two shutdowns the earlier one counts, of two restarts too.
        """
        due = self._cycle.now_ns + round(delay_s * 1e9)
        end = self._planned_restart if restart else self._end
        dues = [moment for moment, change in self._changes.plans if change == end]
        others = [plan for plan in self._changes.plans if plan[1] != end]
        self._changes.plan(*others, (min(due, *dues) if dues else due, end))

    def _planned_restart(self) -> None:
        wait_ns = self._requests.free_at_ns - self._cycle.now_ns
        if wait_ns > 0:
            self.shut_down(wait_ns * 1e-9, restart=True)
        else:
            self.restart()

    def _change_to(self, state: AdsState) -> None:
        enter = self._enter_run if state is AdsState.RUN else self._enter_config
        enters = (self._enter_run, self._enter_config)
        arrivals = [due for due, change in self._changes.plans if change in enters]
        others = [plan for plan in self._changes.plans if plan[1] not in enters]
        if arrivals:
            self._changes.plan(*others, (arrivals[0], enter))
        else:
            now = self._cycle.now_ns
            arrival = now + self._ground.config.system.restart_time
            self._changes.plan((now, self._leave), (arrival, enter), *others)
        # The requester reads the state as soon as it is answered, and must not read RUN.
        self.system.ads_state = AdsState.STOP

    def _leave(self) -> None:
        self.save()
        for plc in self.parts.plcs.values():
            plc.drop_debugger()
        self._ground.leave(
            [each for each in self.parts.devices if each not in self._permanent_devices]
        )
        self._end_parts()
        self._consist_of(idle(self._ground, self._permanent_devices, self._cycle.tick_ns))
        self.system.ads_state = AdsState.STOP

    def _enter_config(self) -> None:
        self.system.ads_state = AdsState.CONFIG

    def _enter_run(self) -> None:
        collect_remains()
        try:
            parts = assemble(self._ground, self._permanent_devices)
        except ConfigError as fault:
            log.error("the station cannot start and stays in CONFIG: %s", fault)
            self._enter_config()
            return
        self.persistent.load(parts.nc, parts.plcs, self.save)
        for plc in parts.plcs.values():
            plc.begin(self._cycle.now_ns)
        self._consist_of(parts)
        self._renewed()
        pace = self._ground.pace()
        if pace is not None and pace.speed == 1:
            self._ground.clock.align()
        self.system.restart_index += 1
        self.system.ads_state = AdsState.RUN
        self._requests.entered_run(self._ground.config.system.restart_time)

    def _end(self) -> None:
        self.save()
        for plc in self.parts.plcs.values():
            plc.drop_debugger()
        for device in self.parts.devices:
            device.detach()
        self._end_parts()
        self._consist_of(idle(self._ground, (), self._cycle.tick_ns))
        self._changes.plan()
        self.ended = True
        self._cycle.halt()
        if self.on_end is not None:
            self.on_end()

    def _end_parts(self) -> None:
        for end in self.parts.ends:
            end()

    def _consist_of(self, parts: Parts) -> None:
        """Replace the parts; phases that others added stay."""
        self._cycle.replace(self.parts.phases, parts.phases)
        self.parts = parts

    # persistent data

    def save(self) -> bool:
        """Write the persistent data as they are now.

        Return False if they cannot be written, which is logged.
        """
        nc, plcs = self.parts.nc, self.parts.plcs
        return (nc is None and not plcs) or self.persistent.save(nc, plcs, self._cycle.now_ns)

    def capture(self) -> PersistentImage | None:
        """Return the persistent data between two cycles; None within one, or without any."""
        nc, plcs = self.parts.nc, self.parts.plcs
        if (nc is None and not plcs) or any(plc.is_halted for plc in plcs.values()):
            return None
        return self.persistent.capture(nc, plcs, self._cycle.now_ns)
