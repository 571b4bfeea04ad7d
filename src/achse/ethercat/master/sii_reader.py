"""An SII image taken apart: identity, mailboxes, names, SyncManagers, PDOs, clock modes.

Source: ETG.2010. A broken image gives what could be read before the break.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import IntEnum

from achse.ethercat.description import MailboxBit, Pdo, PdoEntry, SyncManagerArea
from achse.ethercat.eeprom import checksum

_HEAD = 0x80
"""Bytes before the first category."""

_IDENTITY, _MAILBOXES = struct.Struct("<4I"), struct.Struct("<4HH")
_IDENTITY_AT, _BOOT_AT, _MAILBOXES_AT = 0x10, 0x28, 0x30
_END = 0xFFFF
_PDO = struct.Struct("<HBBBBH")
_ENTRY = struct.Struct("<HBBBBH")
_MODE = struct.Struct("<IiihHhBB4x")
_NOT_ASSIGNED = 0xFF
_FIXED = 0x0010
_COMPLETE = 0x20


class SiiCategory(IntEnum):
    """Kinds of categories that are read."""

    STRINGS = 10
    GENERAL = 30
    FMMU = 40
    SYNC_MANAGERS = 41
    TX_PDO = 50
    RX_PDO = 51
    DC = 60


_KNOWN = frozenset(SiiCategory)


@dataclass(frozen=True)
class SiiSyncManager:
    """A SyncManager as the image describes it."""

    area: SyncManagerArea
    enabled: bool
    use: int


@dataclass(frozen=True)
class SiiMode:
    """A clock mode: times in ns, factors as in ESI."""

    name: str
    cycle0_ns: int
    shift0_ns: int
    shift1_ns: int
    sync1_factor: int
    assign_activate: int
    sync0_factor: int


@dataclass
class SiiContent:
    """Content of an SII image. `valid` is False if the checksum of the configuration is wrong."""

    valid: bool = False
    alias: int = 0
    vendor_id: int = 0
    product_code: int = 0
    revision_number: int = 0
    serial_number: int = 0
    mailbox_out: SyncManagerArea | None = None
    mailbox_in: SyncManagerArea | None = None
    boot_out: SyncManagerArea | None = None
    """The mailboxes of Bootstrap."""
    boot_in: SyncManagerArea | None = None
    protocols: int = 0
    name: str = ""
    order: str = ""
    strings: list[str] = field(default_factory=list)
    coe_details: int = 0
    flags: int = 0
    fmmus: list[int] = field(default_factory=list)
    sync_managers: list[SiiSyncManager] = field(default_factory=list)
    rx_pdos: list[Pdo] = field(default_factory=list)
    tx_pdos: list[Pdo] = field(default_factory=list)
    modes: list[SiiMode] = field(default_factory=list)
    damage: str = ""
    """Description of the place where the image breaks off, empty if it is complete."""

    @property
    def has_coe(self) -> bool:
        """True if the mailbox supports CoE."""
        return bool(self.protocols & MailboxBit.COE)

    @property
    def complete_access(self) -> bool:
        """True if SDO accesses whole objects."""
        return bool(self.coe_details & _COMPLETE)

    def text(self, number: int) -> str:
        """String `number`, counted from 1; empty if there is none."""
        return self.strings[number - 1] if 0 < number <= len(self.strings) else ""


def read_sii(image: bytes) -> SiiContent:
    """Return the content of an SII image; never fails."""
    content = SiiContent()
    if len(image) < _HEAD:
        content.damage = f"{len(image)} bytes, the head has {_HEAD}"
        return content
    content.valid = image[14] == checksum(image)
    content.alias = int.from_bytes(image[8:10], "little")
    (
        content.vendor_id,
        content.product_code,
        content.revision_number,
        content.serial_number,
    ) = _IDENTITY.unpack_from(image, _IDENTITY_AT)
    out_at, out_size, in_at, in_size, content.protocols = _MAILBOXES.unpack_from(
        image, _MAILBOXES_AT
    )
    if out_size and in_size:
        content.mailbox_out = SyncManagerArea(out_at, out_size, 0x26)
        content.mailbox_in = SyncManagerArea(in_at, in_size, 0x22)
    boot_at, boot_size, back_at, back_size = struct.unpack_from("<4H", image, _BOOT_AT)
    if boot_size and back_size:
        content.boot_out = SyncManagerArea(boot_at, boot_size, 0x26)
        content.boot_in = SyncManagerArea(back_at, back_size, 0x22)
    parts = list(_categories(image, content))
    for kind, data in parts:
        if kind == SiiCategory.STRINGS and not content.strings:
            content.strings = _strings(data, content)
    for kind, data in parts:
        _take(kind, data, content)
    return content


def _categories(image: bytes, content: SiiContent) -> Iterator[tuple[int, bytes]]:
    at = _HEAD
    while at + 4 <= len(image):
        kind, words = struct.unpack_from("<HH", image, at)
        if kind == _END:
            return
        data = image[at + 4 : at + 4 + 2 * words]
        if len(data) < 2 * words:
            content.damage = f"category {kind} ends {2 * words - len(data)} bytes behind the image"
            return
        yield kind, data
        at += 4 + 2 * words
    if at < len(image) or at > _HEAD:
        content.damage = content.damage or "no end of the categories"


def _take(kind: int, data: bytes, content: SiiContent) -> None:
    match SiiCategory(kind) if kind in _KNOWN else None:
        case SiiCategory.GENERAL if len(data) >= 12:
            content.order, content.name = content.text(data[2]), content.text(data[3])
            content.coe_details, content.flags = data[5], data[11]
        case SiiCategory.FMMU:
            content.fmmus = [each for each in data if each != _NOT_ASSIGNED]
        case SiiCategory.SYNC_MANAGERS:
            for at in range(0, len(data) - 7, 8):
                start, length, control, _, enable, use = struct.unpack_from("<HHBBBB", data, at)
                area = SyncManagerArea(start, length, control)
                content.sync_managers.append(SiiSyncManager(area, bool(enable & 1), use))
        case SiiCategory.TX_PDO:
            content.tx_pdos += _pdos(data, content)
        case SiiCategory.RX_PDO:
            content.rx_pdos += _pdos(data, content)
        case SiiCategory.DC:
            for at in range(0, len(data) - _MODE.size + 1, _MODE.size):
                cycle, shift0, shift1, factor1, activate, factor0, name, _ = _MODE.unpack_from(
                    data, at
                )
                content.modes.append(
                    SiiMode(content.text(name), cycle, shift0, shift1, factor1, activate, factor0)
                )


def _strings(data: bytes, content: SiiContent) -> list[str]:
    strings: list[str] = []
    at = 1
    for _ in range(data[0] if data else 0):
        if at >= len(data) or at + 1 + data[at] > len(data):
            content.damage = f"string {len(strings) + 1} of {data[0]} is cut off"
            break
        strings.append(data[at + 1 : at + 1 + data[at]].decode("latin-1").rstrip("\0"))
        at += 1 + data[at]
    return strings


def _pdos(data: bytes, content: SiiContent) -> list[Pdo]:
    pdos = []
    at = 0
    while at + _PDO.size <= len(data):
        index, count, manager, _, name, flags = _PDO.unpack_from(data, at)
        if index == 0:
            break  # padding
        at += _PDO.size
        if at + count * _ENTRY.size > len(data):
            content.damage = f"PDO {index:04X} has fewer than {count} entries"
            break
        entries = []
        for _ in range(count):
            entry, subindex, text, kind, bits, _ = _ENTRY.unpack_from(data, at)
            entries.append(PdoEntry(entry, subindex, bits, content.text(text), kind))
            at += _ENTRY.size
        assigned = None if manager == _NOT_ASSIGNED else manager
        pdos.append(Pdo(index, content.text(name), assigned, bool(flags & _FIXED), tuple(entries)))
    return pdos
