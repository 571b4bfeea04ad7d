"""Faults of PLCs and of the whole station: other programs, slow cycles, restarts."""

from typing import Annotated, Literal

from achse.faults.fault import ActiveFault, FieldUnit, LastingFault, Undo, number
from achse.faults.selection import PortNumber
from achse.faults.site import Setting, Site, StationFault


class _PlcFault(StationFault):
    port: PortNumber | None = None
    """The AMS port of the PLC."""

    def check(self, site: Site) -> None:
        site.plcs(self.port)


class OnlineChange(_PlcFault):
    """The PLC has a new symbol version: handles are stale, values stay."""

    kind: Literal["online_change"] = "online_change"

    def begin(self, site: Site, active: ActiveFault) -> None:
        for plc, _ in site.plcs(self.port):
            plc.online_change()


class Download(_PlcFault):
    """A new PLC program: initial values, new symbol version, all handles and notifications gone."""

    kind: Literal["download"] = "download"

    def begin(self, site: Site, active: ActiveFault) -> None:
        for plc, device in site.plcs(self.port):
            plc.reset()
            plc.online_change()
            device.end_notifications()
            plc.run()


class Restart(StationFault):
    """The whole station restarts in RUN."""

    kind: Literal["restart"] = "restart"

    def begin(self, site: Site, active: ActiveFault) -> None:
        site.target.restart()


class Config(LastingFault, StationFault):
    """The station is in CONFIG: no PLC, no NC."""

    kind: Literal["config"] = "config"

    def begin(self, site: Site, active: ActiveFault) -> Undo:
        site.target.configure()
        return site.target.restart


class SlowCycle(_PlcFault, LastingFault):
    """PLC cycles take `factor` times their cycle time (2), those in between are lost."""

    kind: Literal["slow_cycle"] = "slow_cycle"
    factor: Annotated[int, number(int, 2, 1000), FieldUnit("cycles")] | None = None
    """Cycle times that one cycle takes; empty: 2."""

    def begin(self, site: Site, active: ActiveFault) -> Undo:
        ports = [plc.port for plc, _ in site.plcs(self.port)]
        return site.set(Setting(slow_plcs=ports, factor=self.factor or 2))
