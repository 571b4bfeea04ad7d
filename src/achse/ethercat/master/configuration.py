"""Target configuration of a bus: slaves, process data, mailboxes, clocks and start commands.

A configuration comes from descriptions (our own slaves), SII images, ESI or ENI files, or a scan;
the master compares the bus with it and brings the slaves up by it.

Source: ETG.2000 for time-outs and defaults; ETG.1000.4 §6.6, §6.7.
"""

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from achse.codes import AlState
from achse.ethercat.description import Pdo, PdoEntry, SiiUse, SlaveDescription, SyncManagerArea
from achse.ethercat.master.sii_reader import SiiContent

FIRST_STATION = 1001
"""Station address of the first slave; the others count on."""

_MS = 1_000_000
ASSIGN_SYNC0, ASSIGN_BOTH = 0x0300, 0x0700
"""AssignActivate for SYNC0, and for SYNC0 and SYNC1."""

_NO_STATION = 0xFFFF
_SPARE_STATIONS = 0xC000
_OUTPUTS, _INPUTS = 2, 3
_RX_PDO, _TX_PDO = 0x1600, 0x1A00
_CYCLE_IDNS, _OUTPUT_IDNS = (1, 2), 24
_LIST_IDNS = (16, _OUTPUT_IDNS)
_WORD_IDNS = (134, 135)
"""SERCOS control word and status word: they are always mapped."""


@dataclass(frozen=True)
class StateTimes:
    """Time-outs of each state transition and each message, ns."""

    preop_ns: int = 3_000 * _MS
    safeop_op_ns: int = 10_000 * _MS
    back_to_init_ns: int = 5_000 * _MS
    back_to_safeop_ns: int = 200 * _MS
    request_ns: int = 100 * _MS
    response_ns: int = 2_000 * _MS

    def allowed(self, before: AlState, target: AlState) -> int:
        """For one change of state."""
        if target > before:
            return self.preop_ns if target is AlState.PREOP else self.safeop_op_ns
        return self.back_to_safeop_ns if target is AlState.SAFEOP else self.back_to_init_ns


@dataclass(frozen=True)
class InitCommand:
    """An SDO download on the way from PreOp to SafeOp (`transition` PS), SafeOp to Op (SO) or back
    (OS, SP); one of Init to PreOp (IP) is done once PreOp is reached, where the mailbox begins."""

    index: int
    subindex: int
    data: bytes
    transition: str = "PS"
    complete: bool = False
    comment: str = ""


@dataclass(frozen=True)
class IdnCommand:
    """A write to an IDN of a SERCOS drive (SoE) at a transition, as with `InitCommand`.

    With `adapts` the master makes the data of those that it knows: `SlaveConfiguration.idn_data`.
    """

    idn: int
    data: bytes
    drive: int = 0
    transition: str = "PS"
    comment: str = ""
    adapts: bool = False


@dataclass(frozen=True)
class ClockConfiguration:
    """Timing of the slave's SYNC signals.

    `cycle0_ns` 0 means the bus cycle. `shift_ns` is the time from the frame's cycle to SYNC0; None
    means half a cycle. `cycle1_ns` is written to register 0x09A4.
    """

    assign_activate: int = ASSIGN_SYNC0
    cycle0_ns: int = 0
    cycle1_ns: int = 0
    shift_ns: int | None = None

    def __post_init__(self) -> None:
        """Raise ValueError for what the registers of a clock do not hold."""
        numbers = (
            ("AssignActivate", self.assign_activate, 0xFFFF),
            ("cycle of SYNC0", self.cycle0_ns, 0xFFFF_FFFF),
            ("cycle of SYNC1", self.cycle1_ns, 0xFFFF_FFFF),
            ("shift", abs(self.shift_ns or 0), 0xFFFF_FFFF),
        )
        for name, value, most in numbers:
            if not 0 <= value <= most:
                raise ValueError(f"{name}: expected 0 to {most}, got {value}")


@dataclass(frozen=True)
class ProcessSyncManager:
    """A SyncManager for process data; its length follows the mapping."""

    number: int
    start: int
    control: int
    output: bool


@dataclass(frozen=True)
class SlaveConfiguration:
    """One slave. Identity fields that are 0 (revision, serial number) are not compared.

    `outputs` and `inputs` are the assigned PDOs in order. With `assign` the master writes the
    assignment (1C12h, 1C13h), with `configure` the entries of each PDO too. Slaves of one
    `sync_unit` share a datagram and so the validity of their data. An `optional` slave may be
    missing. With `split_mailbox_writes` messages travel without what fills the mailbox up.
    """

    name: str
    vendor_id: int = 0
    product_code: int = 0
    revision_number: int = 0
    serial_number: int = 0
    station: int = 0
    mailbox_out: SyncManagerArea | None = None
    mailbox_in: SyncManagerArea | None = None
    boot_out: SyncManagerArea | None = None
    """The mailboxes of Bootstrap, None without that state."""
    boot_in: SyncManagerArea | None = None
    coe: bool = False
    protocols: int = 0
    """Protocols that the mailbox supports, as the bits of an EEPROM: `MailboxBit`."""
    complete_access: bool = False
    split_mailbox_writes: bool = False
    sync_managers: tuple[ProcessSyncManager, ...] = ()
    outputs: tuple[Pdo, ...] = ()
    inputs: tuple[Pdo, ...] = ()
    assign: bool = False
    configure: bool = False
    commands: tuple[InitCommand, ...] = ()
    idn_commands: tuple[IdnCommand, ...] = ()
    clock: ClockConfiguration | None = None
    sync_unit: str = ""
    packed: bool = False
    """True if fewer than 8 bits of one direction may share a byte of the frame with bits of
    neighbours in the sync unit: the slave's FMMUs count in bits."""
    optional: bool = False
    watchdog_ms: int | None = None
    times: StateTimes = field(default=StateTimes())
    type_name: str = ""
    logical_read_write: bool = True
    """True if the slave supports LRW; False needs LRD and LWR."""

    def with_entries(
        self,
        outputs: Sequence[tuple[int, int, int]] | None = None,
        inputs: Sequence[tuple[int, int, int]] | None = None,
    ) -> "SlaveConfiguration":
        """Return the same slave with another mapping: (index, subindex, bits) of each entry, index
        0 pads.

        The entries go to the first assigned PDO of each direction, and the master writes them.
        """
        changed = self
        if outputs is not None:
            changed = replace(changed, outputs=(_pdo(self.outputs, _RX_PDO, _OUTPUTS, outputs),))
        if inputs is not None:
            changed = replace(changed, inputs=(_pdo(self.inputs, _TX_PDO, _INPUTS, inputs),))
        return replace(changed, assign=True, configure=True)

    def bits(self, manager: ProcessSyncManager) -> int:
        """Bits of process data in that SyncManager."""
        pdos = self.outputs if manager.output else self.inputs
        return sum(
            entry.bits
            for pdo in pdos
            if self.manager_of(pdo) == manager.number
            for entry in pdo.entries
        )

    def idn_data(self, command: IdnCommand, cycle_ns: int) -> bytes:
        """Return the data of a command in a bus with that cycle.

        A command that adapts writes the cycle in µs to S-0-0001 and S-0-0002, and the IDNs that
        are assigned to S-0-0016 (inputs) and S-0-0024 (outputs), without control and status word.
        """
        if command.adapts and command.idn in _CYCLE_IDNS:
            size = len(command.data) or 2
            return (cycle_ns // 1000).to_bytes(max(size, 4), "little")[:size]
        if command.adapts and command.idn in _LIST_IDNS:
            pdos = self.outputs if command.idn == _OUTPUT_IDNS else self.inputs
            idns = [
                entry.index
                for pdo in pdos
                for entry in pdo.entries
                if entry.index and entry.index not in _WORD_IDNS
            ]
            size = 2 * len(idns)
            return struct.pack(f"<{2 + len(idns)}H", size, size, *idns)
        return command.data

    def manager_of(self, pdo: Pdo) -> int:
        """Return the number of the SyncManager that a PDO travels in."""
        if pdo.sync_manager is not None:
            return pdo.sync_manager
        output = pdo in self.outputs
        return next((each.number for each in self.sync_managers if each.output == output), 0)


@dataclass(frozen=True)
class BusConfiguration:
    """A bus: its slaves in the order in which frames pass them.

    `cycle_ns` is the time between cyclic frames. `strict_revision` compares revisions as well.
    `clock_window_ns` is how far clocks may be apart, `settle_ns` how long is waited for that.
    `drift_telegrams` times the reference's time is sent before the start, if a slave has SYNC
    signals. With `redundant` the end of the line comes back to a second adapter.
    """

    slaves: tuple[SlaveConfiguration, ...] = ()
    cycle_ns: int = 2 * _MS
    name: str = "Device 1 (EtherCAT)"
    strict_revision: bool = False
    clock_window_ns: int = 10_000
    settle_ns: int = 5_000 * _MS
    drift_telegrams: int = 1_000
    redundant: bool = False

    def __post_init__(self) -> None:
        """ValueError for addresses that are not one each, and for a cycle that is none."""
        stations = self.stations()
        if self.cycle_ns <= 0:
            raise ValueError(f"a bus has a cycle above 0 ns, got {self.cycle_ns}")
        twice = sorted({each for each in stations if stations.count(each) > 1})
        if twice or not all(0 < each < _NO_STATION for each in stations):
            raise ValueError(
                f"station addresses are 1 to {_NO_STATION - 1}, each once; got {stations[:20]}"
            )

    def stations(self) -> list[int]:
        """Return the station address of each slave."""
        return [
            slave.station or FIRST_STATION + position for position, slave in enumerate(self.slaves)
        ]

    def spare_stations(self, count: int) -> int:
        """The first of `count` addresses, for the time of a look, that no slave here has."""
        stations = set(self.stations())
        return next(
            base
            for base in range(_SPARE_STATIONS, 0, -count)
            if stations.isdisjoint(range(base, base + count))
        )


def _pdo(
    present: tuple[Pdo, ...], index: int, manager: int, entries: Iterable[tuple[int, int, int]]
) -> Pdo:
    by_place = {
        (each.index, each.subindex): each for pdo in present for each in pdo.entries if each.index
    }

    def entry(index: int, subindex: int, bits: int) -> PdoEntry:
        known = by_place.get((index, subindex))
        return PdoEntry(
            index, subindex, bits, known.name if known else "", known.data_type if known else 0
        )

    assigned = tuple(entry(*each) for each in entries)
    if present:
        return replace(present[0], entries=assigned)
    return Pdo(index, "", manager, False, assigned)


def from_description(
    description: SlaveDescription, name: str = "", *, clock: ClockConfiguration | None = None
) -> SlaveConfiguration:
    """Return a slave by its description: our own slaves (`achse.ethercat.describe`)."""
    layout = description.layout
    managers = (
        ProcessSyncManager(_OUTPUTS, layout.outputs.start, layout.outputs.control, True),
        ProcessSyncManager(_INPUTS, layout.inputs.start, layout.inputs.control, False),
    )
    return SlaveConfiguration(
        name or description.name,
        description.vendor_id,
        description.product_code,
        description.revision_number,
        mailbox_out=layout.mailbox_out,
        mailbox_in=layout.mailbox_in,
        boot_out=layout.boot_out if description.bootstrap else None,
        boot_in=layout.boot_in if description.bootstrap else None,
        coe=True,
        protocols=description.protocols,
        complete_access=True,
        sync_managers=managers,
        outputs=tuple(each for each in description.rx_pdos if each.sync_manager is not None),
        inputs=tuple(each for each in description.tx_pdos if each.sync_manager is not None),
        clock=clock,
        packed=True,
        type_name=description.name,
    )


def from_sii(content: SiiContent, name: str = "") -> SlaveConfiguration:
    """Return a slave by its EEPROM: the PDOs that the image assigns to SyncManagers."""
    managers = tuple(
        ProcessSyncManager(number, each.area.start, each.area.control, each.use == SiiUse.OUTPUTS)
        for number, each in enumerate(content.sync_managers)
        if each.use in (SiiUse.OUTPUTS, SiiUse.INPUTS)
    )
    return SlaveConfiguration(
        name or content.name or f"{content.vendor_id:08X}:{content.product_code:08X}",
        content.vendor_id,
        content.product_code,
        content.revision_number,
        mailbox_out=content.mailbox_out,
        mailbox_in=content.mailbox_in,
        boot_out=content.boot_out,
        boot_in=content.boot_in,
        coe=content.has_coe and content.mailbox_out is not None,
        protocols=content.protocols if content.mailbox_out is not None else 0,
        complete_access=content.complete_access,
        sync_managers=managers,
        outputs=tuple(each for each in content.rx_pdos if each.sync_manager is not None),
        inputs=tuple(each for each in content.tx_pdos if each.sync_manager is not None),
        type_name=content.order or content.name,
        logical_read_write=not content.flags & _NOT_LRW,
    )


_NOT_LRW = 0x02
"""Bit of the SII's general flags."""
