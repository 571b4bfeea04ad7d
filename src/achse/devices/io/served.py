"""A bus as the I/O server shows it: its numbers, names, and states as status bytes."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from achse.ams import AmsAddress, DeviceError, NetId
from achse.codes import AlState, FoeError, ReturnCode, return_code_of
from achse.ethercat.description import MailboxBit
from achse.ethercat.mailbox import MailboxError
from achse.ethercat.master import BusError, BusSlave, Master, SdoRefusal
from achse.ethercat.master.errors import (
    EepromTrouble,
    FrameLost,
    MailboxRefusal,
    MailboxTimeout,
    NoAnswer,
    NoMailbox,
    SlaveNotReady,
    StateTimeout,
)
from achse.ethercat.master.foe_client import FoeRefusal
from achse.ethercat.master.topology import build_tree

ETHERCAT_DEVICE = 111
"""Device type of an EtherCAT master; 94 is the answer of a 2.10 system in direct mode."""

MASTER_PORT = 0xFFFF
"""Port of the master at the NetId of its bus."""

_BOX_TYPE = 9099
_FIRST_SLAVE, _LAST_PART = 2, 254


class DeviceStateBit:
    """Bits of a slave's state byte above the state."""

    ERROR = 0x10
    WRONG_IDENTITY = 0x20
    INIT_COMMAND = 0x40


class LinkBit:
    """Bits of a slave's link byte."""

    NOT_PRESENT = 0x01
    MISSING = 0x04
    ADDITIONAL = 0x08
    PORT_A = 0x10
    PORT_B = 0x20


class DevStateBit:
    """Bits of the state of a bus."""

    LINK = 0x0001
    SECOND_LINK = 0x0004
    ONE_FRAME = 0x0008
    INIT = 0x0100
    PREOP = 0x0200
    SAFEOP = 0x0400
    ERROR = 0x0800
    CLOCK = 0x1000


def default_net_id(station: bytes, number: int) -> NetId:
    """Return the NetId of bus `number`: that of the station with another end (device 1:
    x.x.x.x.2.1)."""
    return NetId(bytes(station[:4]) + bytes((number + 1 & 0xFF, 1)))


class TripFigures(Protocol):
    """Times from sending the cyclic frames to their return, ns; cycles without them."""

    count: int
    missing: int
    last_ns: int
    largest_ns: int

    @property
    def mean_ns(self) -> float: ...

    def within_ns(self, share: float) -> int:
        """Return the bound that such a share (0 to 1) of them did not exceed."""

    def reset(self) -> None:
        """Count from 0."""


class BusWay(Protocol):
    """Link of a bus to slaves outside this process."""

    @property
    def interface(self) -> str:
        """The network interface."""

    @property
    def second_interface(self) -> str:
        """Network interface at the other end of a redundant bus, else empty."""

    @property
    def trouble(self) -> str:
        """Reason why the bus does not work as configured; empty if it does."""

    @property
    def round_trips(self) -> TripFigures: ...


@dataclass
class ServedBus:
    """One bus: its device id (1 on), the NetId it answers at, its master."""

    number: int
    master: Master
    net_id: NetId
    comment: str = ""
    device_type: int = ETHERCAT_DEVICE
    way: BusWay | None = None
    """None where the slaves are in this process."""
    _renewals: list[Callable[[], None]] = field(default_factory=list, repr=False)

    def renew(self, master: Master) -> None:
        """Note that the bus was searched again: it has another master, with other slaves."""
        self.master = master
        for renewed in self._renewals:
            renewed()

    def on_renewal(self, renewed: Callable[[], None]) -> None:
        """Call `renewed` whenever there is another master."""
        self._renewals.append(renewed)

    @property
    def name(self) -> str:
        """Name of the device."""
        return self.master.bus.name

    def address(self, slave: BusSlave | None = None) -> AmsAddress:
        """Return the AMS address of a slave, or of the master."""
        return AmsAddress.of(self.net_id, slave.station if slave else MASTER_PORT)

    def slave_net_id(self, slave: BusSlave) -> NetId | None:
        """Return the NetId of a slave that speaks AoE: that of the bus with another last part
        (first place 2). None for one that does not, and beyond the last number."""
        last = slave.position + _FIRST_SLAVE
        if not slave.configuration.protocols & MailboxBit.AOE or last > _LAST_PART:
            return None
        return NetId(bytes(self.net_id[:5]) + bytes((last,)))

    def slave(self, station: int) -> BusSlave:
        """Return the slave with that station address; DeviceError 0x703 if there is none."""
        slave = self.master.slave(station)
        if slave is None:
            raise DeviceError(ReturnCode.INVALID_OFFSET, f"no slave has the address {station}")
        return slave

    # states

    def state_bytes(self, slave: BusSlave) -> bytes:
        """State byte and link byte of a slave."""
        state = slave.state
        state |= DeviceStateBit.ERROR if slave.error else 0
        state |= DeviceStateBit.WRONG_IDENTITY if slave.mismatch else 0
        state |= DeviceStateBit.INIT_COMMAND if slave.failed_command else 0
        link = 0
        if not slave.present:
            link = LinkBit.NOT_PRESENT
        else:
            slaves = self.master.slaves
            opening = self.master.supervision.slaves_before_opening
            if opening is not None:
                place = sum(each.present for each in slaves[: slave.position])
                if place in (opening - 1, opening):
                    port = LinkBit.PORT_B if place < opening else LinkBit.PORT_A
                    return bytes((state & 0xFF, LinkBit.MISSING | port))
            behind = slaves[slave.position + 1 : slave.position + 2]
            if behind and not behind[0].present and not behind[0].configuration.optional:
                link = LinkBit.MISSING | LinkBit.PORT_B
            elif not behind and self.master.supervision.strangers:
                link = LinkBit.ADDITIONAL | LinkBit.PORT_B
        return bytes((state & 0xFF, link))

    @property
    def dev_state(self) -> int:
        """The state of the bus; 0: all is well."""
        master = self.master
        slaves = [each for each in master.slaves if each.present]
        expected = [each for each in master.slaves if not each.configuration.optional]
        states = {each.state for each in slaves}
        bits = 0
        if not master.supervision.link or any(not each.present for each in expected):
            bits |= DevStateBit.LINK
        ring = master.redundancy
        if ring is not None:
            bits |= DevStateBit.LINK if ring.cut_off[0] else 0
            bits |= DevStateBit.SECOND_LINK if ring.cut_off[1] else 0
            bits |= DevStateBit.ONE_FRAME if ring.open else 0
        for state, bit in (
            (AlState.INIT, DevStateBit.INIT),
            (AlState.PREOP, DevStateBit.PREOP),
            (AlState.SAFEOP, DevStateBit.SAFEOP),
        ):
            bits |= bit if state in states else 0
        if any(each.error or each.failed_command or each.mismatch for each in master.slaves):
            bits |= DevStateBit.ERROR
        window = master.bus.clock_window_ns
        if any(
            each.configuration.clock and abs(each.clock_difference_ns) > window for each in slaves
        ):
            bits |= DevStateBit.CLOCK
        return bits

    @property
    def counts(self) -> tuple[int, int]:
        """Slaves found by each adapter; all by the first while a ring is closed."""
        ring = self.master.redundancy
        if ring is None or ring.split is None:
            return self.master.supervision.slave_count, 0
        return ring.reached[0], ring.reached[1]

    @property
    def second_dev_state(self) -> int:
        """The state of the second adapter: 0, or its link is lost."""
        ring = self.master.redundancy
        return DevStateBit.LINK if ring is not None and ring.cut_off[1] else 0

    # lists

    def topology(self) -> bytes:
        """64 bytes for each configured slave: addresses, neighbours by port, delay, status."""
        present = [each for each in self.master.slaves if each.present]
        tree = build_tree([each.facts.dl_status for each in present])
        records = []
        for slave in self.master.slaves:
            stations, positions = [0] * 4, [0] * 4
            if slave.present:
                place = tree[present.index(slave)]
                around = dict(place.children)
                if place.parent is not None:
                    around[0] = place.parent
                for port, other in around.items():
                    stations[port] = present[other].station
                    positions[port] = -present[other].position & 0xFFFF
            status = (
                slave.facts.has_clock
                | slave.facts.wide_clock << 1
                | slave.present << 2
                | slave.configuration.optional << 4
            )
            records.append(
                struct.pack(
                    "<HH4H4H4II24x",
                    slave.station,
                    -slave.position & 0xFFFF,
                    *stations,
                    *positions,
                    *(slave.facts.delay_ns, 0, 0, 0),
                    status,
                )
            )
        return b"".join(records)

    def information(self) -> bytes:
        """Return the packed entry of this bus with its boxes."""
        boxes = [self._box(number, slave) for number, slave in enumerate(self.master.slaves, 1)]
        name, comment = _text(self.name[:31]), _text(self.comment)
        head = struct.pack(
            "<4H8s2H",
            *(1, self.device_type, self.number, len(boxes)),
            self.address(),
            *(len(name), len(comment)),
        )
        entry = head + name + comment + b"".join(boxes)
        return (4 + len(entry)).to_bytes(4, "little") + entry

    def _box(self, number: int, slave: BusSlave) -> bytes:
        name = _text(slave.name)
        entry = (
            struct.pack(
                "<3H8s2H",
                *(number, _BOX_TYPE, slave.station),
                self.address(slave),
                *(len(name), 1),
            )
            + name
            + b"\0"
        )
        return (2 + len(entry)).to_bytes(2, "little") + entry


def _text(text: str) -> bytes:
    return text.encode("cp1252", "replace") + b"\0"


_CLASSES: Sequence[tuple[tuple[type[BusError], ...], ReturnCode]] = (
    ((NoMailbox,), ReturnCode.SERVICE_NOT_SUPPORTED),
    ((SlaveNotReady,), ReturnCode.INVALID_STATE),
    ((MailboxTimeout, StateTimeout, FrameLost, NoAnswer, EepromTrouble), ReturnCode.DEVICE_TIMEOUT),
)

_NOT_SPOKEN = (MailboxError.UNSUPPORTED_PROTOCOL, MailboxError.SERVICE_NOT_SUPPORTED)
_FILES: dict[int, ReturnCode] = {
    FoeError.NOT_FOUND: ReturnCode.NOT_FOUND,
    FoeError.ACCESS_DENIED: ReturnCode.INVALID_ACCESS,
    FoeError.NO_RIGHTS: ReturnCode.INVALID_ACCESS,
    FoeError.BOOTSTRAP_ONLY: ReturnCode.INVALID_STATE,
    FoeError.NOT_IN_BOOTSTRAP: ReturnCode.INVALID_STATE,
}
"""ADS return codes of refused files, by error code of the slave, which is read at 0xF407. Ours."""


def bus_error(trouble: BusError) -> DeviceError:
    """Return the ADS error for what went wrong on the bus."""
    if isinstance(trouble, SdoRefusal):
        return DeviceError(return_code_of(trouble.code), str(trouble))
    if isinstance(trouble, MailboxRefusal) and trouble.number in _NOT_SPOKEN:
        return DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, str(trouble))
    if isinstance(trouble, FoeRefusal):
        return DeviceError(_FILES.get(trouble.number, ReturnCode.DEVICE_ERROR), str(trouble))
    for kinds, known in _CLASSES:
        if isinstance(trouble, kinds):
            return DeviceError(known, str(trouble))
    return DeviceError(ReturnCode.DEVICE_ERROR, str(trouble))
