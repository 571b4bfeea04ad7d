"""The ESI file: a slave's description for configurators, made from what the SII image is made from.

Elements and their order follow EtherCATInfo.xsd. Numbers beginning with #x are hexadecimal.

Source: ETG.2000, and published ESI files of servo drives.
"""

from collections.abc import Iterable
from xml.etree import ElementTree

from achse.codes import DataType
from achse.ethercat.application import (
    ObjectAccess,
    ObjectCode,
    ObjectDescription,
    ObjectEntry,
)
from achse.ethercat.description import (
    OPERATION_MODES,
    MailboxBit,
    Pdo,
    SlaveDescription,
    SyncManagerArea,
)
from achse.ethercat.registers import FMMUS, RAM_KIB, SYNC_MANAGERS
from achse.ethercat.sii import SII_SIZE, build_sii

_GROUP = "Drives"
"""Heading of the device in lists."""
_PROFILE = 402
_BOOT_AT = 0x28
"""Bytes of the EEPROM that describe the mailboxes of Bootstrap."""
_ENGLISH = {"LcId": "1033"}
_TIMEOUTS = {
    "PreopTimeout": 3000,
    "SafeopOpTimeout": 10000,
    "BackToInitTimeout": 5000,
    "BackToSafeopTimeout": 200,
}
_MAILBOX_TIMEOUTS = {"RequestTimeout": 100, "ResponseTimeout": 2000}

_BASE_TYPES = {
    DataType.BOOL: "BOOL",
    DataType.I8: "SINT",
    DataType.I16: "INT",
    DataType.I32: "DINT",
    DataType.I64: "LINT",
    DataType.U8: "USINT",
    DataType.U16: "UINT",
    DataType.U32: "UDINT",
    DataType.U64: "ULINT",
    DataType.F32: "REAL",
    DataType.F64: "LREAL",
}

_OBJECT_0_BITS = 16
"""Subindex 0 takes 16 bits in complete access."""


def build_esi(description: SlaveDescription, *, vendor: str) -> str:
    """Return the ESI file as text; `vendor` is the maker's name."""
    root = ElementTree.Element("EtherCATInfo")
    maker = _sub(root, "Vendor")
    _sub(maker, "Id", _hex(description.vendor_id))
    _sub(maker, "Name", vendor)
    descriptions = _sub(root, "Descriptions")
    family = _sub(_sub(descriptions, "Groups"), "Group")
    _sub(family, "Type", _GROUP)
    _sub(family, "Name", _GROUP, _ENGLISH)
    device = _sub(_sub(descriptions, "Devices"), "Device", Physics="YY")
    _sub(
        device,
        "Type",
        description.name,
        ProductCode=_hex(description.product_code),
        RevisionNo=_hex(description.revision_number),
    )
    _sub(device, "Name", description.name, _ENGLISH)
    _info(_sub(device, "Info"))
    _sub(device, "GroupType", _GROUP)
    _profile(_sub(device, "Profile"), description)
    for kind in ("Outputs", "Inputs", "MBoxState"):
        _sub(device, "Fmmu", kind)
    _sync_managers(device, description)
    for pdo in description.rx_pdos:
        _pdo(_sub(device, "RxPdo"), pdo, description.rx_pdos)
    for pdo in description.tx_pdos:
        _pdo(_sub(device, "TxPdo"), pdo, description.tx_pdos)
    assignable = any(not pdo.fixed for pdo in (*description.rx_pdos, *description.tx_pdos))
    mailbox = _sub(device, "Mailbox", DataLinkLayer="1")
    coe = {
        "SdoInfo": "1",
        "PdoAssign": str(int(assignable)),
        "PdoConfig": str(int(assignable)),
        "CompleteAccess": "1",
        "SegmentedSdo": "1",
    }
    for name in MailboxBit(description.protocols).names:
        _sub(mailbox, name, **(coe if name == "CoE" else {}))
    clock = _sub(device, "Dc")
    for mode in OPERATION_MODES:
        operation = _sub(clock, "OpMode")
        _sub(operation, "Name", mode.name)
        _sub(operation, "Desc", mode.description)
        _sub(operation, "AssignActivate", f"#x{mode.assign_activate:04X}")
        if mode.sync0_factor:
            _sub(operation, "CycleTimeSync0", "0", Factor=str(mode.sync0_factor))
            _sub(operation, "ShiftTimeSync0", "0")
    eeprom = _sub(device, "Eeprom")
    _sub(eeprom, "ByteSize", str(SII_SIZE))
    image = build_sii(description)
    _sub(eeprom, "ConfigData", image[:14].hex().upper())
    if description.bootstrap:
        _sub(eeprom, "BootStrap", image[_BOOT_AT : _BOOT_AT + 8].hex().upper())
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _sub(
    parent: ElementTree.Element,
    tag: str,
    text: str | None = None,
    attributes: dict[str, str] | None = None,
    /,
    **more: str,
) -> ElementTree.Element:
    element = ElementTree.SubElement(parent, tag, {**(attributes or {}), **more})
    element.text = text
    return element


def _hex(number: int) -> str:
    return f"#x{number:08X}"


def _index(index: int) -> str:
    return f"#x{index:04X}"


def _info(info: ElementTree.Element) -> None:
    timeouts = _sub(_sub(info, "StateMachine"), "Timeout")
    for name, milliseconds in _TIMEOUTS.items():
        _sub(timeouts, name, str(milliseconds))
    timeouts = _sub(_sub(info, "Mailbox"), "Timeout")
    for name, milliseconds in _MAILBOX_TIMEOUTS.items():
        _sub(timeouts, name, str(milliseconds))
    controller = _sub(info, "EtherCATController")
    for name, number in (
        ("DpramSize", 1024 * RAM_KIB),
        ("SmCount", SYNC_MANAGERS),
        ("FmmuCount", FMMUS),
    ):
        _sub(controller, name, str(number))


def _sync_managers(device: ElementTree.Element, description: SlaveDescription) -> None:
    layout = description.layout
    rows: tuple[tuple[str, SyncManagerArea, int], ...] = (
        ("MBoxOut", layout.mailbox_out, layout.mailbox_out.length),
        ("MBoxIn", layout.mailbox_in, layout.mailbox_in.length),
        ("Outputs", layout.outputs, description.output_size),
        ("Inputs", layout.inputs, description.input_size),
    )
    for name, area, size in rows:
        _sub(
            device,
            "Sm",
            name,
            MinSize="34" if name.startswith("MBox") else "0",
            MaxSize=str(max(area.length, size)),
            DefaultSize=str(size),
            StartAddress=_index(area.start),
            ControlByte=f"#x{area.control:02X}",
            Enable="1",
        )


def _pdo(element: ElementTree.Element, pdo: Pdo, alternatives: Iterable[Pdo]) -> None:
    if pdo.sync_manager is not None:
        element.set("Sm", str(pdo.sync_manager))
    element.set("Fixed", str(int(pdo.fixed)))
    _sub(element, "Index", _index(pdo.index))
    _sub(element, "Name", pdo.name)
    for other in alternatives:
        if other is not pdo:
            _sub(element, "Exclude", _index(other.index))
    for mapped in pdo.entries:
        entry = _sub(element, "Entry")
        _sub(entry, "Index", _index(mapped.index))
        if mapped.index:
            _sub(entry, "SubIndex", str(mapped.subindex))
        _sub(entry, "BitLen", str(mapped.bits))
        if mapped.index:
            _sub(entry, "Name", mapped.name)
            _sub(entry, "DataType", _type_name(mapped.data_type, mapped.bits))


def _type_name(data_type: int, bits: int) -> str:
    name = _BASE_TYPES.get(DataType(data_type)) if data_type in list(DataType) else None
    return name or f"STRING({bits // 8})"


def _profile(element: ElementTree.Element, description: SlaveDescription) -> None:
    _sub(element, "ProfileNo", str(_PROFILE))
    dictionary = _sub(element, "Dictionary")
    types = _sub(dictionary, "DataTypes")
    base = {
        _type_name(entry.data_type, entry.bits): entry.bits
        for each in description.objects
        for entry in each.entries
    }
    for name, bits in sorted(base.items()):
        kind = _sub(types, "DataType")
        _sub(kind, "Name", name)
        _sub(kind, "BitSize", str(bits))
    objects = _sub(dictionary, "Objects")
    for each in description.objects:
        _object(objects, types, each)


def _object(
    objects: ElementTree.Element, types: ElementTree.Element, described: ObjectDescription
) -> None:
    """Write an object, and for one with subindices the data type that lists them."""
    first = described.entries[0]
    if described.code == ObjectCode.VAR:
        type_name, bits = _type_name(first.data_type, first.bits), first.bits
    else:
        type_name = f"DT{described.index:04X}"
        kind = _sub(types, "DataType")
        _sub(kind, "Name", type_name)
        size = _sub(kind, "BitSize")
        bits = 0
        for entry in described.entries:
            item = _sub(kind, "SubItem")
            _sub(item, "SubIdx", str(entry.subindex))
            _sub(item, "Name", _item_name(entry))
            _sub(item, "Type", _type_name(entry.data_type, entry.bits))
            _sub(item, "BitSize", str(entry.bits))
            _sub(item, "BitOffs", str(bits))
            _flags(item, entry)
            bits += _OBJECT_0_BITS if entry.subindex == 0 else entry.bits
        size.text = str(bits)
    element = _sub(objects, "Object")
    _sub(element, "Index", _index(described.index))
    _sub(element, "Name", described.name)
    _sub(element, "Type", type_name)
    _sub(element, "BitSize", str(bits))
    info = _sub(element, "Info")
    if described.code == ObjectCode.VAR:
        _values(info, first)
        _flags(element, first)
    else:
        for entry in described.entries:
            item = _sub(info, "SubItem")
            _sub(item, "Name", _item_name(entry))
            _values(_sub(item, "Info"), entry)


def _item_name(entry: ObjectEntry) -> str:
    return f"SubIndex {entry.subindex:03d}" if not entry.name else entry.name


def _values(info: ElementTree.Element, entry: ObjectEntry) -> None:
    """Write limits and default as bytes on the wire, which have no sign; text is text."""
    if _type_name(entry.data_type, entry.bits).startswith("STRING"):
        if entry.default:
            _sub(info, "DefaultString", entry.default.decode("ascii", "replace"))
        return
    for tag, value in (
        ("MinData", entry.minimum),
        ("MaxData", entry.maximum),
        ("DefaultData", entry.default),
    ):
        if value is not None:
            _sub(info, tag, value.hex().upper())


def _flags(parent: ElementTree.Element, entry: ObjectEntry) -> None:
    flags = _sub(parent, "Flags")
    writable = entry.access & ObjectAccess.WRITE
    if not entry.access & ObjectAccess.READ:
        access = "wo"
    else:
        access = "rw" if writable else "ro"
    restricted = {}
    if writable == ObjectAccess.WRITE_PREOP:
        restricted["WriteRestrictions"] = "PreOP"
    _sub(flags, "Access", access, restricted)
    mappable = ("R" if entry.access & ObjectAccess.RX_PDO else "") + (
        "T" if entry.access & ObjectAccess.TX_PDO else ""
    )
    if mappable:
        _sub(flags, "PdoMapping", mappable)
    for tag, bit in (("Backup", ObjectAccess.BACKUP), ("Setting", ObjectAccess.SETTINGS)):
        if entry.access & bit:
            _sub(flags, tag, "1")
