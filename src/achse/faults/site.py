"""Site of a station's faults: its frames, its services, its settings."""

from collections.abc import Callable, Collection
from typing import NamedTuple

from achse.faults.fault import ActiveFault, Fault, FaultError, Undo
from achse.faults.fault_filter import FaultFilter, Later
from achse.faults.refusals import Refusals
from achse.faults.selection import devices_at
from achse.faults.target import FaultyStation
from achse.plc import PlcRuntime
from achse.server import Device


class Setting(NamedTuple):
    """Settings of the station that a fault demands while it lasts."""

    strict: bool = False
    """One TCP connection per remote host."""
    closed: bool = False
    """No new TCP connection."""
    slow_plcs: Collection[int] = ()
    """Ports of the PLCs that are slowed down."""
    factor: int = 1
    """Cycle times that their cycles take."""


class Site:
    """The place where faults begin and end."""

    def __init__(
        self, target: FaultyStation, later: Later, finish: Callable[[ActiveFault], None]
    ) -> None:
        self.target = target
        self.fault_filter = FaultFilter(target.router, later, finish)
        self.refusals = Refusals()
        self.finish = finish
        """Ends a fault that has hit as often as it should."""
        self._settings: list[Setting] = []

    def set(self, setting: Setting) -> Undo:
        """Let the station be so, beside what other faults want."""
        self._settings.append(setting)
        self._settle()

        def undo() -> None:
            self._settings.remove(setting)
            self._settle()

        return undo

    def _settle(self) -> None:
        """Make listeners and tasks as the configuration and all settings want them."""
        target, settings = self.target, self._settings
        for listener in target.listeners:
            listener.strict = target.strict or any(each.strict for each in settings)
            listener.accepting = not any(each.closed for each in settings)
        for port, plc in target.plcs.items():
            factors = [each.factor for each in settings if port in each.slow_plcs]
            for task in plc.tasks:
                task.stretch = max(factors, default=1)

    def plcs(self, only: int | None) -> list[tuple[PlcRuntime, Device]]:
        """Return the PLC at port `only`, or all, each with its device; raises FaultError."""
        matches = [
            (plc, device)
            for port, plc in self.target.plcs.items()
            for device in devices_at(only, self.target)
            if any(address.port == port for address in device.addresses)
        ]
        if not matches:
            raise FaultError("port: expected that of a PLC of the station")
        return matches


class StationFault(Fault):
    """A fault of a station."""

    def check(self, site: Site) -> None:
        """Raise FaultError for what this station cannot do."""

    def begin(self, site: Site, active: ActiveFault) -> Undo | None:
        """Do it; what ends it, None for an event. Raises FaultError where there is nothing to hit.

        `active` counts the hits.
        """
        raise NotImplementedError
