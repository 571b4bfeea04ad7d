"""The SII image: a slave's EEPROM, made from its description.

Source: ETG.2010; words that masters were seen to read.
"""

import struct
from collections.abc import Iterable

from achse.ethercat.description import OPERATION_MODES, Pdo, SlaveDescription, SyncManagerArea
from achse.ethercat.eeprom import checksum

__all__ = ["SII_SIZE", "build_sii"]

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


def build_sii(description: SlaveDescription, alias: int = 0) -> bytes:
    """The image, `SII_SIZE` bytes; ValueError if the description does not fit."""
    strings = _Strings()
    name = strings.number(description.name)  # masters take string 1 for the slave's name
    mailbox_out, mailbox_in = description.layout.mailbox_out, description.layout.mailbox_in
    configuration = struct.pack("<4HH4x", _PDI_CONTROL, _PDI_CONFIGURATION, _SYNC_IMPULSE, 0, alias)
    head = struct.pack(
        "<14sH4I8x4H4HH",
        configuration,
        checksum(configuration),
        description.vendor_id,
        description.product_code,
        description.revision_number,
        description.serial_number,
        *_boot_areas(description),
        mailbox_out.start,
        mailbox_out.length,
        mailbox_in.start,
        mailbox_in.length,
        description.protocols,
    )
    sizes = struct.pack("<HH", SII_SIZE * 8 // 1024 - 1, 1)
    general = struct.pack(
        "<4Bx7BHBxHH12x", 0, 0, 0, name, _COE_DETAILS, 0, 0, 0, 0, 0, 0, 0, 0, _PORTS_MII, 0
    )
    categories = [
        (_GENERAL, general),
        (_FMMU, b"\x01\x02\x03\xff"),
        (_SYNC_MANAGERS, _sync_managers(description)),
        (_TX_PDO, _pdos(description.tx_pdos, strings)),
        (_RX_PDO, _pdos(description.rx_pdos, strings)),
        (_DC, _modes(strings)),
    ]
    categories.insert(0, (_STRINGS, strings.encode()))
    image = (
        head.ljust(0x7C, b"\0")
        + sizes
        + b"".join(_category(kind, data) for kind, data in categories if data)
        + struct.pack("<H", _END)
    )
    if len(image) > SII_SIZE:
        raise ValueError(
            f"the SII image of {description.name} has {len(image)} of {SII_SIZE} bytes"
        )
    return image.ljust(SII_SIZE, b"\xff")


def _boot_areas(description: SlaveDescription) -> tuple[int, int, int, int]:
    """Words 14h to 17h, 0 without Bootstrap."""
    if not description.bootstrap:
        return 0, 0, 0, 0
    out, into = description.layout.boot_out, description.layout.boot_in
    return out.start, out.length, into.start, into.length


def _category(kind: int, data: bytes) -> bytes:
    data += b"\0" * (len(data) & 1)
    return struct.pack("<HH", kind, len(data) // 2) + data


def _sync_managers(description: SlaveDescription) -> bytes:
    layout = description.layout
    outputs = SyncManagerArea(layout.outputs.start, description.output_size, layout.outputs.control)
    inputs = SyncManagerArea(layout.inputs.start, description.input_size, layout.inputs.control)
    return b"".join(
        struct.pack("<HHBBBB", area.start, area.length, area.control, 0, 1, kind)
        for kind, area in enumerate((layout.mailbox_out, layout.mailbox_in, outputs, inputs), 1)
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
                len(pdo.entries),
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
                entry.bits,
                0,
            )
            for entry in pdo.entries
        ]
    return b"".join(parts)


def _modes(strings: _Strings) -> bytes:
    return b"".join(
        struct.pack(
            "<IiihHhBB4x",
            0,
            0,
            0,
            0,
            mode.assign_activate,
            mode.sync0_factor,
            strings.number(mode.name),
            strings.number(mode.description),
        )
        for mode in OPERATION_MODES
    )
