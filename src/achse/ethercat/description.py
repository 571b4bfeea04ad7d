"""Description of a slave for masters and configurators: the source of SII image and ESI file.

Source: 001 §2.2; ETG.2000 and ETG.2010 for the content of a description.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag

from achse.codes import SdoAbort
from achse.ethercat.application import (
    Application,
    FileApplication,
    MessagingApplication,
    ObjectAccess,
    ObjectDescription,
)

_PDO_INDICES = (range(0x1600, 0x1800), range(0x1A00, 0x1C00))
_ASSIGNMENT = 0x1C10
"""Object of SyncManager 0; 1C12h and 1C13h assign the process data."""

_OUTPUTS, _INPUTS = 2, 3
_BITS = {1: 0x01, 2: 0x02, 4: 0x08, 5: 0x10, 15: 0x20}
"""Bits of what a mailbox speaks, by the type of its messages."""


class MailboxBit(IntFlag):
    """Protocols that a mailbox supports, word 0x1C of an EEPROM."""

    AOE = 0x01
    EOE = 0x02
    COE = 0x04
    FOE = 0x08
    SOE = 0x10
    VOE = 0x20

    @classmethod
    def of(cls, names: Iterable[str]) -> "MailboxBit":
        """Return the bits of protocols as ESI and ENI files name them (CoE, FoE, …); others are
        left."""
        known = {each.name: each for each in cls}
        bits = cls(0)
        for name in names:
            bits |= known.get(name.upper(), cls(0))
        return bits

    @property
    def names(self) -> list[str]:
        """As files name them."""
        return [
            f"{each.name[0]}o{each.name[2]}" for each in MailboxBit if each in self and each.name
        ]


@dataclass(frozen=True)
class SyncManagerArea:
    """The memory of one SyncManager; process data lengths follow the mapping."""

    start: int
    length: int
    control: int


class SiiUse(IntEnum):
    """Use of a SyncManager."""

    NONE = 0
    MAILBOX_OUT = 1
    MAILBOX_IN = 2
    OUTPUTS = 3
    INPUTS = 4


@dataclass(frozen=True)
class SlaveMemory:
    """SyncManagers of a slave in their order, with their use; the mailboxes of Bootstrap."""

    managers: tuple[tuple[SiiUse, SyncManagerArea], ...]
    boot_out: SyncManagerArea
    boot_in: SyncManagerArea

    def mailbox(self) -> tuple[tuple[int, SyncManagerArea], tuple[int, SyncManagerArea]] | None:
        """Number and area of the mailboxes from and to the master, None without a mailbox."""
        uses = [use for use, _ in self.managers]
        if not {SiiUse.MAILBOX_OUT, SiiUse.MAILBOX_IN} <= set(uses):
            return None
        out, into = uses.index(SiiUse.MAILBOX_OUT), uses.index(SiiUse.MAILBOX_IN)
        return (out, self.managers[out][1]), (into, self.managers[into][1])


@dataclass(frozen=True)
class SyncManagerLayout:
    """Memory of the four SyncManagers: mailboxes from and to the master, outputs, inputs."""

    mailbox_out: SyncManagerArea
    mailbox_in: SyncManagerArea
    outputs: SyncManagerArea
    inputs: SyncManagerArea
    boot_out: SyncManagerArea = SyncManagerArea(0x1000, 512, 0x26)
    """The mailboxes of Bootstrap, where a slave has that state."""
    boot_in: SyncManagerArea = SyncManagerArea(0x1200, 512, 0x22)

    @property
    def memory(self) -> SlaveMemory:
        """The SyncManagers in their order."""
        uses = (SiiUse.MAILBOX_OUT, SiiUse.MAILBOX_IN, SiiUse.OUTPUTS, SiiUse.INPUTS)
        areas = (self.mailbox_out, self.mailbox_in, self.outputs, self.inputs)
        return SlaveMemory(tuple(zip(uses, areas, strict=True)), self.boot_out, self.boot_in)


LAYOUT = SyncManagerLayout(
    SyncManagerArea(0x1000, 256, 0x26),
    SyncManagerArea(0x1100, 256, 0x22),
    SyncManagerArea(0x1200, 32, 0x64),
    SyncManagerArea(0x1300, 32, 0x20),
)
"""The layout offered; the manual gives lengths of process data only (32 bytes each at most)."""


@dataclass(frozen=True)
class OperationMode:
    """Synchronization mode of a slave; `assign_activate` is the word for 0x0980."""

    name: str
    description: str
    assign_activate: int
    sync0_factor: int


OPERATION_MODES = (
    OperationMode("FreeRun", "FreeRun, local timer", 0x0000, 0),
    OperationMode("DC", "DC, local cycle by SYNC0", 0x0300, 1),
)


@dataclass(frozen=True)
class PdoEntry:
    """One mapped object; index 0 is padding."""

    index: int
    subindex: int
    bits: int
    name: str
    data_type: int


@dataclass(frozen=True)
class Pdo:
    """A PDO with its default entries; `sync_manager` is None if it is not assigned by default."""

    index: int
    name: str
    sync_manager: int | None
    fixed: bool
    entries: tuple[PdoEntry, ...]


@dataclass(frozen=True)
class SlaveDescription:
    """All that SII and ESI say about a slave. `output_size` and `input_size` are the defaults."""

    name: str
    vendor_id: int
    product_code: int
    revision_number: int
    serial_number: int
    layout: SyncManagerLayout
    rx_pdos: tuple[Pdo, ...]
    tx_pdos: tuple[Pdo, ...]
    output_size: int
    input_size: int
    objects: tuple[ObjectDescription, ...]
    protocols: int = MailboxBit.COE
    bootstrap: bool = False


def describe(application: Application, layout: SyncManagerLayout = LAYOUT) -> SlaveDescription:
    """Return the description of an application, with its present mapping as the default."""
    objects = tuple(application.objects())
    by_index = {each.index: each for each in objects}
    identity = application.identity

    def pdos(indices: range, sync_manager: int) -> tuple[Pdo, ...]:
        assigned = _numbers(application, by_index.get(_ASSIGNMENT + sync_manager))
        return tuple(
            Pdo(
                each.index,
                each.name,
                sync_manager if each.index in assigned else None,
                not each.entries[0].access & ObjectAccess.WRITE,
                tuple(_entry(value, by_index) for value in _numbers(application, each)),
            )
            for each in objects
            if each.index in indices
        )

    rx, tx = _PDO_INDICES
    return SlaveDescription(
        application.name,
        identity.vendor_id,
        identity.product_code,
        identity.revision_number,
        identity.serial_number,
        layout,
        pdos(rx, _OUTPUTS),
        pdos(tx, _INPUTS),
        application.output_size,
        application.input_size,
        objects,
        _protocols(application),
        isinstance(application, FileApplication) and application.bootstrap,
    )


def _protocols(application: Application) -> int:
    own = application.services if isinstance(application, MessagingApplication) else ()
    bits = MailboxBit.COE
    if isinstance(application, FileApplication):
        bits |= MailboxBit.FOE
    for protocol in own:
        bits |= _BITS.get(protocol, 0)
    return int(bits)


def _numbers(application: Application, described: ObjectDescription | None) -> Sequence[int]:
    """Return the entries 1..n of a mapping or assignment, n from subindex 0."""
    if described is None:
        return ()
    read = application.read_object
    try:
        count = read(described.index, 0)[0]
        return [
            int.from_bytes(read(described.index, subindex), "little")
            for subindex in range(1, count + 1)
        ]
    except SdoAbort:
        return ()


def _entry(mapping: int, objects: dict[int, ObjectDescription]) -> PdoEntry:
    index, subindex, bits = mapping >> 16, mapping >> 8 & 0xFF, mapping & 0xFF
    description = objects.get(index)
    if description is not None:
        for entry in description.entries:
            if entry.subindex == subindex:
                name = (
                    description.name
                    if len(description.entries) == 1
                    else f"{description.name}: {entry.name}"
                )
                return PdoEntry(index, subindex, bits, name, entry.data_type)
    return PdoEntry(index, subindex, bits, "", 0)
