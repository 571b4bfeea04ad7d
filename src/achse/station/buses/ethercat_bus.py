"""An EtherCAT bus of a station in one process: our master, and virtual drives and terminals.

Frames go through their segment in virtual time, and nothing else is different from a bus on a
network interface.
"""

import hashlib
import logging
from collections.abc import Sequence

from achse.codes import AlState
from achse.drive import Drive
from achse.drive.compiled import Bank
from achse.ethercat import Segment, Slave, describe
from achse.ethercat.master import BusEvent, BusEventKind, BusSlave, Master, Ring, from_description
from achse.ethercat.ring_segment import RingSegment
from achse.ethercat.virtual import VirtualDevice, VirtualSlave
from achse.faults.drive_list import DriveFaults
from achse.station.buses.frame_link import RoundTrips
from achse.station.buses.plan import (
    BusPlan,
    TerminalDevice,
    described_terminal,
    make_terminal,
)
from achse.station.buses.virtual_drives import digest_of, make_drives, torque_per_acceleration
from achse.station.configuration.bus import DriveConfig
from achse.station.configuration.terminal import TerminalConfig

log = logging.getLogger("achse.bus")

_WARNINGS = {
    BusEventKind.LINK_LOST,
    BusEventKind.SLAVE_LOST,
    BusEventKind.WRONG_SLAVE,
    BusEventKind.STATE_LEFT,
    BusEventKind.STATE_FAILED,
    BusEventKind.EMERGENCY,
    BusEventKind.RING_OPEN,
    BusEventKind.CLOCK,
    BusEventKind.REFERENCE,
}


class EthercatBus:
    """One bus; `slaves` are in the order of the drives of `plan`, `terminal_slaves` of terminals.

    Raises MachineError for a machine that cannot be.
    """

    interface = second_interface = trouble = ""

    def __init__(self, plan: BusPlan, *, compiled: bool = False) -> None:
        self.cycle_ns = plan.cycle_ns
        self.now_ns = 0
        self.round_trips = RoundTrips()
        """None: frames take no time here."""
        configs = [each.device for each in plan.slots if isinstance(each.device, DriveConfig)]
        self.bank = Bank(len(configs)) if compiled and configs else None
        """The memory of the drives, where they run as machine code."""
        drives = make_drives(configs, self.bank)
        self.drives: Sequence[Drive] = drives
        self.terminals: Sequence[TerminalDevice] = [
            make_terminal(each.device, each.folder)
            for each in plan.slots
            if isinstance(each.device, TerminalConfig)
        ]
        places = [slot.place for slot in plan.slots]
        devices: dict[int, Drive | TerminalDevice] = dict(
            zip(places, (*drives, *self.terminals), strict=True)
        )
        line = [_slave(devices[place]) for place in sorted(places)]
        self.segment = RingSegment(line) if plan.bus.redundant else Segment(line)
        known = {
            place: from_description(describe(each))
            if isinstance(each, Drive)
            else described_terminal(each)
            for place, each in devices.items()
        }
        self.master = Master(plan.in_process(known))
        self.master.on_event = log_event
        self.faults = DriveFaults(self.segment)
        """Faults injected on this bus."""
        self._ring = Ring(self.master, self.segment)
        slaves = [self.master.slaves[sorted(places).index(place)] for place in places]
        self.slaves: Sequence[BusSlave] = slaves[: len(drives)]
        self.terminal_slaves: Sequence[BusSlave] = slaves[len(drives) :]
        self.master.request(AlState.OP)

    def take(self) -> None:
        """Do nothing: inputs come with `exchange`."""

    def exchange(self) -> None:
        """Run one cycle: outputs go out, inputs of this moment come in."""
        self.now_ns += self.cycle_ns
        if self.faults:
            self.faults.tick()
        self._ring.exchange(self.now_ns)

    def absent(self, slave: BusSlave) -> bool:
        """Return True if the bus was searched, and the slave does not answer."""
        return self.master.absent(slave)

    def on_renewal(self, renewed: object) -> None:
        """Do nothing: the slaves of this process stay."""

    def close(self) -> None:
        """Do nothing: this bus has no network interface."""

    def torque_per_acceleration(self, number: int) -> float:
        """‰ for an increment a second² at drive `number`, 0 if unknown."""
        return torque_per_acceleration(self.drives[number])

    def digest(self) -> bytes:
        """States of slaves and drives, and the process data."""
        state = hashlib.blake2b(self.now_ns.to_bytes(8, "little"))
        state.update(slaves_digest(self.master.slaves))
        for drive in self.drives:
            state.update(digest_of(drive))
        return state.digest()


def _slave(device: Drive | TerminalDevice) -> Slave:
    return VirtualSlave(device) if isinstance(device, VirtualDevice) else Slave(device)


def slaves_digest(slaves: Sequence[BusSlave]) -> bytes:
    """States and process data of slaves."""
    return b"".join(
        bytes((slave.state, slave.operational)) + bytes(slave.outputs) + bytes(slave.inputs)
        for slave in slaves
    )


def log_event(event: BusEvent) -> None:
    """Write an event of a bus as a line of the log."""
    level = logging.WARNING if event.kind in _WARNINGS else logging.INFO
    log.log(level, "%s: %s", event.kind.value, event.text)
