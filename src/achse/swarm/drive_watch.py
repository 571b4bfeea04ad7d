"""The watch over drives: an axis whose drive cannot work is not in control any longer."""

from collections.abc import Callable, Sequence

from achse.faults.drives import AlarmFault, Hang, SlaveFault, Sto
from achse.faults.fault import FaultState
from achse.station import Station
from achse.station.clocks.cycle import Phase, PhasePlace

_EVERY_NS = 10_000_000
_NOTICED_NS = 100_000_000
"""Time after which drive, master and NC have noticed a fault."""

_DISABLING = (AlarmFault, Sto)
"""Faults that take the torque from a drive, as long as they are active."""


class DriveWatch(Phase):
    """Phase that compares the faults of drives with the states of their axes."""

    place, name = PhasePlace.SCOPE, "swarm drives"
    due_ns: float = 0

    def __init__(
        self, station: Station, axes: Sequence[str], report: Callable[[str, str], None]
    ) -> None:
        self._station = station
        self._axes = axes
        self._report = report
        self._since: dict[str, int] = {}
        self.looks = 0
        """Looks at an axis whose drive had no torque for long."""

    def begin(self, earliest_ns: int) -> None:
        """Look from the first cycle on."""
        self.due_ns = earliest_ns

    def step(self, now_ns: int) -> None:
        """Look at the axes whose drives have a fault."""
        self.due_ns = now_ns + _EVERY_NS
        disabled = self._disabled()
        self._since = {name: self._since.get(name, now_ns) for name in disabled}
        nc = self._station.nc
        if nc is None:
            return
        for axis in nc:
            since = self._since.get(axis.name, now_ns)
            if now_ns - since <= _NOTICED_NS:
                continue
            self.looks += 1
            if axis.loop_closed and not axis.error_code:
                self._report(
                    "drive-error",
                    f"axis {axis.name} at {now_ns / 1e9:.3f} s is in control, without an error,"
                    f" its drive without torque for {(now_ns - since) / 1e9:.3f} s",
                )

    def _disabled(self) -> set[str]:
        """Return the axes whose drives have no torque by a fault, and can say so."""
        names: set[str] = set()
        silent: set[str] = set()
        for faults in self._station.drive_faults:
            for active in faults or ():
                fault = active.fault
                if active.state is not FaultState.ACTIVE or not isinstance(fault, SlaveFault):
                    continue
                drive = fault.drive
                axes = self._axes if drive is None else self._axes[drive - 1 : drive]
                if isinstance(fault, _DISABLING):
                    names |= set(axes)
                elif isinstance(fault, Hang):
                    silent |= set(axes)
        return names - silent
