"""The EEPROM of a virtual slave, made from its ESI file.

Source: ETG.2000, Eeprom; ETG.2010 for the categories.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import replace

from achse.ethercat.description import MailboxBit, Pdo, PdoEntry, SiiUse, SyncManagerArea
from achse.ethercat.master.esi_reader import EsiDevice, EsiError, EsiMode
from achse.ethercat.master.xml_document import number
from achse.ethercat.sii import SiiClockMode, SiiSource, encode_sii

_CONFIGURATION = 14
_USUAL = struct.pack("<4H6x", 0x0C05, 0x0003, 100, 0)
"""Configuration where a file gives none: SPI, clock units on."""
_LEAST, _MOST = 128, 1 << 19
_OP_ONLY, _ENABLED = 0x08, 0x01
_FMMUS = {"outputs": 1, "inputs": 2, "mboxstate": 3}
_USES = {
    "MBoxOut": SiiUse.MAILBOX_OUT, "MBoxIn": SiiUse.MAILBOX_IN,
    "Outputs": SiiUse.OUTPUTS, "Inputs": SiiUse.INPUTS,
}  # fmt: skip
_PORTS = {"Y": 1, "H": 1, "K": 3}
"""Physical layer of a port by its letter in `Physics`: MII, EBUS."""
_DATA_LINK, _ID_BY_STATUS, _ID_IN_MEMORY = 0x04, 0x08, 0x10
_SIGNED_16 = 0x7FFF


def image_of(
    device: EsiDevice,
    sizes: dict[int, int],
    assigned: Iterable[Pdo],
    *,
    alias: int = 0,
    serial_number: int = 0,
) -> bytes:
    """Return the image. `sizes` are the bytes of process data in each SyncManager, `assigned` the
    PDOs that a device assigns by itself, with their SyncManagers."""
    head = (device.eeprom_head or _USUAL)[:_CONFIGURATION].ljust(_CONFIGURATION, b"\0")
    head = head[:8] + (alias.to_bytes(2, "little") if alias else head[8:10]) + head[10:]
    mailbox = [0, 0, 0, 0]
    managers = []
    for place, each in enumerate(device.sync_managers):
        use, area = _USES[each.use], each.area
        if use in (SiiUse.MAILBOX_OUT, SiiUse.MAILBOX_IN):
            at = 0 if use is SiiUse.MAILBOX_OUT else 2
            mailbox[at : at + 2] = [area.start, area.length]
        length = sizes.get(place, area.length)
        enable = _ENABLED * each.enabled | _OP_ONLY * each.op_only
        managers.append((SyncManagerArea(area.start, length, area.control), enable, use))
    by_index = {each.index: each for each in assigned}
    return _fitting(
        SiiSource(
            configuration=head,
            identity=(
                device.vendor_id, device.product_code, device.revision_number, serial_number,
            ),
            boot=_boot(device.bootstrap),
            mailbox=(mailbox[0], mailbox[1], mailbox[2], mailbox[3]),
            protocols=int(MailboxBit.of(device.protocols)),
            name=device.name,
            fmmus=_fmmus(device),
            sync_managers=tuple(managers),
            tx_pdos=tuple(_as_assigned(each.pdo, by_index) for each in device.inputs),
            rx_pdos=tuple(_as_assigned(each.pdo, by_index) for each in device.outputs),
            modes=tuple(_mode(each) for each in device.modes),
            size=min(max(device.eeprom_size, _LEAST), _MOST),
            group=device.group,
            order=device.type_name,
            coe_details=_coe(device),
            foe="FoE" in device.protocols,
            eoe="EoE" in device.protocols,
            flags=_flags(device),
            current_ma=_current(device),
            ports=_ports(device.physics),
            identification_at=_identification(device),
        ),
        objects="CoE" in device.protocols,
    )  # fmt: skip


def _fitting(source: SiiSource, *, objects: bool) -> bytes:
    """Return the image with as much of the PDOs as there is room for.

    Left out are first the names of entries, then those of PDOs, then PDOs that are not assigned.
    A slave whose `objects` describe its PDOs may have none at all; others get a larger EEPROM.
    """
    variants = [
        source,
        _with_pdos(source, lambda pdo: replace(pdo, entries=_unnamed(pdo))),
        _with_pdos(source, lambda pdo: replace(pdo, name="", entries=_unnamed(pdo))),
        _with_pdos(source, _assigned_only),
    ]
    if objects:
        variants.append(replace(source, tx_pdos=(), rx_pdos=()))
    for variant in variants:
        try:
            return encode_sii(variant)
        except (ValueError, struct.error):
            continue
    try:
        return encode_sii(replace(variants[-1], stretches=True))
    except struct.error as fault:
        raise EsiError(f"its PDOs do not fit into an EEPROM: {fault}") from None


def _with_pdos(source: SiiSource, change: Callable[[Pdo], Pdo | None]) -> SiiSource:
    """Return the same with other PDOs; None leaves one out."""
    directions = [
        tuple(new for pdo in pdos if (new := change(pdo)) is not None)
        for pdos in (source.tx_pdos, source.rx_pdos)
    ]
    return replace(source, tx_pdos=directions[0], rx_pdos=directions[1])


def _unnamed(pdo: Pdo) -> tuple[PdoEntry, ...]:
    return tuple(replace(entry, name="") for entry in pdo.entries)


def _assigned_only(pdo: Pdo) -> Pdo | None:
    if pdo.sync_manager is None:
        return None
    return replace(pdo, name="", entries=_unnamed(pdo))


def _boot(data: bytes) -> tuple[int, int, int, int]:
    if len(data) < 8:
        return 0, 0, 0, 0
    first, length, back, size = struct.unpack_from("<4H", data)
    return first, length, back, size


def _fmmus(device: EsiDevice) -> bytes:
    """Return the use of each FMMU, an even number of bytes."""
    uses = bytes(_FMMUS.get(each.lower(), 0xFF) for each in device.fmmus)
    if not uses:
        kinds = dict.fromkeys(each.use.lower() for each in device.sync_managers)
        uses = bytes(_FMMUS[each] for each in kinds if each in _FMMUS)
    return uses + b"\xff" * (len(uses) & 1)


def _as_assigned(pdo: Pdo, assigned: dict[int, Pdo]) -> Pdo:
    """Return a PDO with its SyncManager, none if the device does not assign it by itself."""
    default = assigned.get(pdo.index)
    manager = None if default is None else default.sync_manager
    return Pdo(pdo.index, pdo.name, manager, pdo.fixed, pdo.entries)


def _mode(mode: EsiMode) -> SiiClockMode:
    return SiiClockMode(
        mode.name,
        mode.description,
        mode.assign_activate,
        _limited(mode.cycle0.factor),
        _limited(mode.cycle1.factor),
        mode.cycle0.ns & 0xFFFF_FFFF,
        mode.shift0_ns,
        mode.shift1_ns,
    )


def _limited(factor: int) -> int:
    return max(-_SIGNED_16, min(_SIGNED_16, factor))


def _coe(device: EsiDevice) -> int:
    if "CoE" not in device.protocols:
        return 0
    return (
        0x01
        | 0x02 * device.sdo_information
        | 0x04 * device.pdo_assign
        | 0x08 * device.pdo_configure
        | 0x20 * device.complete_access
    )


def _flags(device: EsiDevice) -> int:
    element = device.element
    info = None if element is None else element.find("Info")
    by_status = info is not None and (info.findtext("IdentificationReg134") or "").strip() in (
        "1",
        "true",
    )
    return (
        _DATA_LINK * device.mailbox_repeat
        | _ID_BY_STATUS * by_status
        | _ID_IN_MEMORY * bool(_identification(device))
    )


def _identification(device: EsiDevice) -> int:
    if device.element is None:
        return 0
    return number(device.element, "Info/IdentificationAdo") & 0xFFFF


def _current(device: EsiDevice) -> int:
    if device.element is None:
        return 0
    current = number(device.element, "Info/Electrical/EBusCurrent")
    return _limited(current)


def _ports(physics: str) -> int:
    return sum(_PORTS.get(letter, 0) << 4 * port for port, letter in enumerate(physics[:4]))
