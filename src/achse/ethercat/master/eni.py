"""ENI files: a bus configuration as configurators write it, read and written.

What is read: names, addresses, identities, process data with their PDOs, mailboxes, start commands
of CoE and SoE, clocks, the cycle time. Commands to registers are not executed: the master makes its
own.

Source: ETG.2100; published ENI files of several configurators.
"""

from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from achse.ethercat.description import MailboxBit, Pdo, PdoEntry, SyncManagerArea
from achse.ethercat.master.configuration import (
    ASSIGN_BOTH,
    ASSIGN_SYNC0,
    BusConfiguration,
    ClockConfiguration,
    IdnCommand,
    InitCommand,
    ProcessSyncManager,
    SlaveConfiguration,
)
from achse.ethercat.master.soe_client import SoeElement
from achse.ethercat.master.xml_document import XmlRefusal, flag, number, parse_xml

_MAILBOXES = 2
"""SyncManagers before those of process data."""
_MAILBOX_OUT, _MAILBOX_IN = 0x26, 0x22
_DIRECTION = 0x04
"""Bit of a SyncManager's control: the master writes."""
_DOWNLOAD, _SOE_WRITE = 1, 3
_TYPES = {
    1: "BOOL", 2: "SINT", 3: "INT", 4: "DINT", 5: "USINT", 6: "UINT", 7: "UDINT", 8: "REAL",
    0x11: "LREAL", 0x15: "LINT", 0x1B: "ULINT",
}  # fmt: skip
TYPE_NUMBERS = {name: code for code, name in _TYPES.items()}
"""Number of each basic type by its name."""


class EniError(ValueError):
    """A file that is not an ENI, or has an element that cannot be read; the text names it."""


def read_eni(text: str | bytes) -> BusConfiguration:
    """Return the bus in an ENI file; raises `EniError`."""
    try:
        root = parse_xml(text)
    except XmlRefusal as refusal:
        raise EniError(f"an ENI file: {refusal}") from None
    config = root.find("Config") if root.tag == "EtherCATConfig" else None
    if config is None:
        raise EniError(f"expected EtherCATConfig/Config, the root is {root.tag}")
    slaves = tuple(
        _slave(place, element) for place, element in enumerate(config.findall("Slave"), 1)
    )
    name = config.findtext("Master/Info/Name", "") or BusConfiguration.name
    try:
        cycle_us = number(config, "Cyclic/CycleTime", 0)
        if cycle_us > 0:
            return BusConfiguration(slaves, cycle_ns=cycle_us * 1000, name=name)
        return BusConfiguration(slaves, name=name)
    except ValueError as fault:
        raise EniError(str(fault)) from None


def _slave(place: int, element: Element) -> SlaveConfiguration:
    name = element.findtext("Info/Name", "").strip() or f"Box {place}"
    try:
        return _read_slave(name, element)
    except ValueError as fault:
        raise EniError(f"Slave {place} ({name}): {fault}") from None


def _read_slave(name: str, element: Element) -> SlaveConfiguration:
    process = element.find("ProcessData")
    optional = element.find("HotConnect") is not None
    managers = tuple(_managers(process))
    mailbox_out = _area(element.find("Mailbox/Send"), _MAILBOX_OUT)
    mailbox_in = _area(element.find("Mailbox/Recv"), _MAILBOX_IN)
    coe = element.find("Mailbox/CoE")
    protocols = [each.text or "" for each in element.findall("Mailbox/Protocol")]
    return SlaveConfiguration(
        name,
        number(element, "Info/VendorId"),
        number(element, "Info/ProductCode"),
        number(element, "Info/RevisionNo"),
        number(element, "Info/SerialNo"),
        station=number(element, "Info/PhysAddr"),
        mailbox_out=mailbox_out,
        mailbox_in=mailbox_in,
        coe=mailbox_out is not None and (coe is not None or "CoE" in protocols),
        protocols=0 if mailbox_out is None else int(MailboxBit.of(protocols)),
        sync_managers=managers,
        outputs=tuple(_pdos(process, "RxPdo")),
        inputs=tuple(_pdos(process, "TxPdo")),
        commands=tuple(_commands(coe)),
        idn_commands=tuple(_idn_commands(element.find("Mailbox/SoE"))),
        clock=_clock(element.find("DC")),
        optional=optional,
        sync_unit=name if optional else "",  # a slave that is missing would spoil the others' data
    )


def _managers(process: Element | None) -> Iterator[ProcessSyncManager]:
    if process is None:
        return
    for place in range(16):
        element = process.find(f"Sm{place}")
        if element is None:
            continue
        control = number(element, "ControlByte")
        start = number(element, "StartAddress")
        if place >= _MAILBOXES or element.find("Pdo") is not None:
            yield ProcessSyncManager(place, start, control, bool(control & _DIRECTION))


def _pdos(process: Element | None, tag: str) -> Iterator[Pdo]:
    """Yield the assigned PDOs: those with an attribute Sm."""
    for element in [] if process is None else process.findall(tag):
        manager = element.get("Sm")
        if manager is None:
            continue
        entries = tuple(
            PdoEntry(
                number(entry, "Index"),
                number(entry, "SubIndex"),
                number(entry, "BitLen"),
                entry.findtext("Name", ""),
                TYPE_NUMBERS.get(entry.findtext("DataType", ""), 0),
            )
            for entry in element.findall("Entry")
        )
        fixed = element.get("Fixed", "0").lower() in ("1", "true")
        yield Pdo(
            number(element, "Index"), element.findtext("Name", ""), int(manager), fixed, entries
        )


def _area(element: Element | None, control: int) -> SyncManagerArea | None:
    if element is None:
        return None
    length = number(element, "Length")
    return SyncManagerArea(number(element, "Start"), length, control) if length else None


def _commands(coe: Element | None) -> Iterator[InitCommand]:
    """Downloads; a command for several transitions is one for each that is known."""
    for element in [] if coe is None else coe.findall("InitCmds/InitCmd"):
        if number(element, "Ccs", _DOWNLOAD) != _DOWNLOAD or flag(element, "Disabled"):
            continue
        for transition in element.findall("Transition"):
            yield InitCommand(
                number(element, "Index"),
                number(element, "SubIndex"),
                bytes.fromhex(element.findtext("Data", "")),
                (transition.text or "").strip(),
                flag(element, "CompleteAccess"),
                element.findtext("Comment", ""),
            )


def _idn_commands(soe: Element | None) -> Iterator[IdnCommand]:
    """Writes to values of IDNs; a command for several transitions is one for each."""
    for element in [] if soe is None else soe.findall("InitCmds/InitCmd"):
        if number(element, "OpCode", _SOE_WRITE) != _SOE_WRITE or flag(element, "Disabled"):
            continue
        if number(element, "Elements", SoeElement.VALUE) != SoeElement.VALUE:
            continue
        for transition in element.findall("Transition"):
            yield IdnCommand(
                number(element, "IDN"),
                bytes.fromhex(element.findtext("Data", "")),
                number(element, "DriveNo"),
                (transition.text or "").strip(),
                element.findtext("Comment", ""),
            )


def _clock(element: Element | None) -> ClockConfiguration | None:
    if element is None or not (cycle0 := number(element, "CycleTime0", 0)):
        return None
    cycle1 = number(element, "CycleTime1", 0)
    return ClockConfiguration(
        ASSIGN_BOTH if cycle1 else ASSIGN_SYNC0, cycle0, cycle1, number(element, "ShiftTime", 0)
    )


def write_eni(bus: BusConfiguration) -> str:
    """Return the bus as an ENI file."""
    root = Element("EtherCATConfig", Version="1.3")
    config = ElementTree.SubElement(root, "Config")
    info = ElementTree.SubElement(ElementTree.SubElement(config, "Master"), "Info")
    _text(info, "Name", bus.name)
    _text(info, "Destination", "ffffffffffff")
    _text(info, "Source", "020000000000")
    _text(info, "EtherType", "a488")
    for position, (slave, station) in enumerate(zip(bus.slaves, bus.stations(), strict=True)):
        element = ElementTree.SubElement(config, "Slave")
        _write_slave(element, slave, (station, position), bus.cycle_ns)
    cyclic = ElementTree.SubElement(config, "Cyclic")
    _text(cyclic, "CycleTime", bus.cycle_ns // 1000)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _write_slave(
    element: Element, slave: SlaveConfiguration, at: tuple[int, int], cycle_ns: int
) -> None:
    station, position = at
    info = ElementTree.SubElement(element, "Info")
    _text(info, "Name", slave.name)
    _text(info, "PhysAddr", station)
    _text(info, "AutoIncAddr", -position & 0xFFFF)
    _text(info, "VendorId", slave.vendor_id)
    _text(info, "ProductCode", slave.product_code)
    _text(info, "RevisionNo", slave.revision_number)
    _text(info, "SerialNo", slave.serial_number)
    process = ElementTree.SubElement(element, "ProcessData")
    for manager in slave.sync_managers:
        area = ElementTree.SubElement(process, f"Sm{manager.number}")
        _text(area, "Type", "Outputs" if manager.output else "Inputs")
        _text(area, "DefaultSize", slave.bits(manager) + 7 >> 3)
        _text(area, "StartAddress", manager.start)
        _text(area, "ControlByte", manager.control)
        _text(area, "Enable", 1)
        for pdo in slave.outputs if manager.output else slave.inputs:
            if slave.manager_of(pdo) == manager.number:
                _text(area, "Pdo", pdo.index)
    for tag, pdos in (("TxPdo", slave.inputs), ("RxPdo", slave.outputs)):
        for pdo in pdos:
            _write_pdo(ElementTree.SubElement(process, tag), pdo, slave.manager_of(pdo))
    out, into = slave.mailbox_out, slave.mailbox_in
    if out is not None and into is not None:
        mailbox = ElementTree.SubElement(element, "Mailbox")
        for tag, place in (("Send", out), ("Recv", into)):
            area = ElementTree.SubElement(mailbox, tag)
            _text(area, "Start", place.start)
            _text(area, "Length", place.length)
        for name in MailboxBit(slave.protocols).names:
            _text(mailbox, "Protocol", name)
        if slave.coe:
            _write_commands(ElementTree.SubElement(mailbox, "CoE"), slave)
        if slave.idn_commands:
            _write_idn_commands(ElementTree.SubElement(mailbox, "SoE"), slave, cycle_ns)
    if slave.clock is not None:
        clock = ElementTree.SubElement(element, "DC")
        _text(clock, "CycleTime0", slave.clock.cycle0_ns)
        _text(clock, "CycleTime1", slave.clock.cycle1_ns)
        _text(clock, "ShiftTime", slave.clock.shift_ns or 0)
    if slave.optional:
        ElementTree.SubElement(element, "HotConnect")


def _write_pdo(element: Element, pdo: Pdo, manager: int) -> None:
    element.set("Fixed", str(int(pdo.fixed)))
    element.set("Sm", str(manager))
    _text(element, "Index", f"#x{pdo.index:04x}")
    _text(element, "Name", pdo.name)
    for entry in pdo.entries:
        each = ElementTree.SubElement(element, "Entry")
        _text(each, "Index", f"#x{entry.index:04x}")
        if entry.index:
            _text(each, "SubIndex", entry.subindex)
        _text(each, "BitLen", entry.bits)
        if entry.index:
            _text(each, "Name", entry.name)
            _text(each, "DataType", _TYPES.get(entry.data_type, f"BIT{entry.bits}"))


def _write_commands(element: Element, slave: SlaveConfiguration) -> None:
    if not slave.commands:
        return
    commands = ElementTree.SubElement(element, "InitCmds")
    for command in slave.commands:
        each = ElementTree.SubElement(commands, "InitCmd")
        if command.complete:
            each.set("CompleteAccess", "true")
        _text(each, "Transition", command.transition)
        _text(each, "Comment", command.comment)
        _text(each, "Timeout", 0)
        _text(each, "Ccs", _DOWNLOAD)
        _text(each, "Index", command.index)
        _text(each, "SubIndex", command.subindex)
        _text(each, "Data", command.data.hex())


def _write_idn_commands(element: Element, slave: SlaveConfiguration, cycle_ns: int) -> None:
    commands = ElementTree.SubElement(element, "InitCmds")
    for command in slave.idn_commands:
        each = ElementTree.SubElement(commands, "InitCmd")
        _text(each, "Transition", command.transition)
        _text(each, "Comment", command.comment)
        _text(each, "Timeout", 0)
        _text(each, "OpCode", _SOE_WRITE)
        _text(each, "DriveNo", command.drive)
        _text(each, "IDN", command.idn)
        _text(each, "Elements", int(SoeElement.VALUE))
        _text(each, "Attribute", 0)
        _text(each, "Data", slave.idn_data(command, cycle_ns).hex())


def _text(parent: Element, tag: str, value: str | int) -> None:
    ElementTree.SubElement(parent, tag).text = _printable(str(value))


def _printable(text: str) -> str:
    """Without what XML cannot hold."""
    return "".join(each for each in text if each >= " " and each not in "\ufffe\uffff")
