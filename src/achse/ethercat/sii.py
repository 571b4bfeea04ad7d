"""The SII image: a slave's EEPROM, made from its description.

Source: ETG.2010; words that masters were seen to read.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass

from achse.ethercat.description import (
    OPERATION_MODES,
    Pdo,
    SiiUse,
    SlaveDescription,
    SyncManagerArea,
)
from achse.ethercat.eeprom import checksum

SII_SIZE = 4096
"""Bytes of the EEPROM."""

_STRINGS, _GENERAL, _FMMU, _SYNC_MANAGERS, _TX_PDO, _RX_PDO, _DC, _END = (
    10, 30, 40, 41, 50, 51, 60, 0xFFFF,
)  # fmt: skip

_PDI_CONTROL = 0x0C05
"""SPI, and the DC units for SYNC and latch on (registers 0x0140, 0x0141)."""

_PDI_CONFIGURATION = 0x0003
_SYNC_IMPULSE = 100
"""Length of a SYNC0 impulse in 10 ns."""

_COE_DETAILS = 0x2F
"""SDO, SDO information, PDO assignment, PDO configuration, complete access."""

_PORTS_MII = 0x0011
_HEAD_SIZE = 0x80
"""Bytes before the first category."""
_NOT_ASSIGNED = 0xFF


class _Strings:
    """The strings of an image, counted from 1; 0 is none."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}

    def number(self, text: str) -> int:
        data = text.encode("ascii", "replace")[:255]
        if not data or len(self._numbers) == 255:
            return 0
        return self._numbers.setdefault(data, len(self._numbers) + 1)

    def encode(self) -> bytes:
        return bytes((len(self._numbers),)) + b"".join(
            bytes((len(data),)) + data for data in self._numbers
        )


@dataclass(frozen=True)
class SiiClockMode:
    """A clock mode: times in ns, factors as in ESI."""

    name: str
    description: str
    assign_activate: int
    sync0_factor: int = 0
    sync1_factor: int = 0
    cycle0_ns: int = 0
    shift0_ns: int = 0
    shift1_ns: int = 0


@dataclass(frozen=True)
class SiiSource:
    """All that an image is made from.

    `configuration` are the first 14 bytes, `boot` and `mailbox` offsets and sizes of the mailboxes
    from and to the master, `sync_managers` area, enable flags and use of each.
    """

    configuration: bytes
    identity: tuple[int, int, int, int]
    boot: tuple[int, int, int, int]
    mailbox: tuple[int, int, int, int]
    protocols: int
    name: str
    fmmus: bytes
    sync_managers: tuple[tuple[SyncManagerArea, int, int], ...]
    tx_pdos: tuple[Pdo, ...]
    rx_pdos: tuple[Pdo, ...]
    modes: tuple[SiiClockMode, ...]
    size: int = SII_SIZE
    group: str = ""
    order: str = ""
    coe_details: int = _COE_DETAILS
    foe: bool = False
    eoe: bool = False
    flags: int = 0
    current_ma: int = 0
    ports: int = _PORTS_MII
    identification_at: int = 0
    """Address of the memory with the identification, with `flags` bit 4."""
    stretches: bool = False
    """True if an image that is too long makes the EEPROM larger."""


def build_sii(description: SlaveDescription, alias: int = 0) -> bytes:
    """Return the image, `SII_SIZE` bytes; ValueError if the description does not fit."""
    mailbox_out, mailbox_in = description.layout.mailbox_out, description.layout.mailbox_in
    return encode_sii(
        SiiSource(
            configuration=struct.pack(
                "<4HH4x", _PDI_CONTROL, _PDI_CONFIGURATION, _SYNC_IMPULSE, 0, alias
            ),
            identity=(
                description.vendor_id,
                description.product_code,
                description.revision_number,
                description.serial_number,
            ),
            boot=_boot_areas(description),
            mailbox=(mailbox_out.start, mailbox_out.length, mailbox_in.start, mailbox_in.length),
            protocols=description.protocols,
            name=description.name,
            fmmus=b"\x01\x02\x03\xff",
            sync_managers=_sync_managers(description),
            tx_pdos=description.tx_pdos,
            rx_pdos=description.rx_pdos,
            modes=tuple(
                SiiClockMode(each.name, each.description, each.assign_activate, each.sync0_factor)
                for each in OPERATION_MODES
            ),
        )
    )


def encode_sii(source: SiiSource) -> bytes:
    """Return the image of what is in `source`; ValueError if it does not fit its size."""
    strings = _Strings()
    order = strings.number(source.order)  # masters take string 1 for the slave's name
    name, group = strings.number(source.name), strings.number(source.group)
    head = struct.pack(
        "<14sH4I8x4H4HH",
        source.configuration,
        checksum(source.configuration),
        *source.identity,
        *source.boot,
        *source.mailbox,
        source.protocols,
    )
    general = struct.pack(
        "<5B6BBhBxHH12x",
        *(group, 0, order, name, 0),
        *(source.coe_details, source.foe, source.eoe, 0, 0, 0),
        *(source.flags, source.current_ma, group, source.ports, source.identification_at),
    )
    categories = [
        (_GENERAL, general),
        (_FMMU, source.fmmus),
        (
            _SYNC_MANAGERS,
            b"".join(
                struct.pack("<HHBBBB", area.start, area.length, area.control, 0, enable, use)
                for area, enable, use in source.sync_managers
            ),
        ),
        (_TX_PDO, _pdos(source.tx_pdos, strings)),
        (_RX_PDO, _pdos(source.rx_pdos, strings)),
        (_DC, _modes(source.modes, strings)),
    ]
    categories.insert(0, (_STRINGS, strings.encode()))
    body = b"".join(_category(kind, data) for kind, data in categories if data)
    needed = _HEAD_SIZE + len(body) + 2
    size = source.size
    while needed > size and source.stretches:
        size *= 2
    if needed > size:
        raise ValueError(f"the SII image of {source.name} has {needed} of {size} bytes")
    image = (
        head.ljust(_HEAD_SIZE - 4, b"\0")
        + struct.pack("<HH", size * 8 // 1024 - 1, 1)
        + body
        + struct.pack("<H", _END)
    )
    return image.ljust(size, b"\xff")


def _boot_areas(description: SlaveDescription) -> tuple[int, int, int, int]:
    """Words 14h to 17h, 0 without Bootstrap."""
    if not description.bootstrap:
        return 0, 0, 0, 0
    out, into = description.layout.boot_out, description.layout.boot_in
    return out.start, out.length, into.start, into.length


def _category(kind: int, data: bytes) -> bytes:
    data += b"\0" * (len(data) & 1)
    return struct.pack("<HH", kind, len(data) // 2) + data


def _sync_managers(
    description: SlaveDescription,
) -> tuple[tuple[SyncManagerArea, int, int], ...]:
    sizes = {SiiUse.OUTPUTS: description.output_size, SiiUse.INPUTS: description.input_size}
    return tuple(
        (SyncManagerArea(area.start, sizes.get(use, area.length), area.control), 1, use)
        for use, area in description.layout.memory.managers
    )


def _pdos(pdos: Iterable[Pdo], strings: _Strings) -> bytes:
    parts = []
    for pdo in pdos:
        sync_manager = _NOT_ASSIGNED if pdo.sync_manager is None else pdo.sync_manager
        flags = 0x0010 if pdo.fixed else 0
        parts.append(
            struct.pack(
                "<HBBBBH",
                pdo.index,
                len(pdo.entries) & 0xFF,
                sync_manager,
                0,
                strings.number(pdo.name),
                flags,
            )
        )
        parts += [
            struct.pack(
                "<HBBBBH",
                entry.index,
                entry.subindex,
                strings.number(entry.name),
                entry.data_type & 0xFF,
                entry.bits & 0xFF,
                0,
            )
            for entry in pdo.entries
        ]
    return b"".join(parts)


def _modes(modes: Iterable[SiiClockMode], strings: _Strings) -> bytes:
    return b"".join(
        struct.pack(
            "<IiihHhBB4x",
            mode.cycle0_ns,
            mode.shift0_ns,
            mode.shift1_ns,
            mode.sync1_factor,
            mode.assign_activate,
            mode.sync0_factor,
            strings.number(mode.name),
            strings.number(mode.description),
        )
        for mode in modes
    )
