"""ESI files of vendors, read: devices with their PDOs, SyncManagers, mailboxes, clock modes.

`read_esi` gives the devices of a file, `from_esi` a slave's configuration from one of them.
Dictionaries, and modules of modular devices, stay in `EsiDevice.element`.

Source: ETG.2000; published ESI files of drives and terminals.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from xml.etree.ElementTree import Element

from achse.ethercat.description import MailboxBit, Pdo, PdoEntry, SyncManagerArea
from achse.ethercat.master.configuration import (
    ClockConfiguration,
    IdnCommand,
    InitCommand,
    ProcessSyncManager,
    SlaveConfiguration,
    StateTimes,
)
from achse.ethercat.master.eni import TYPE_NUMBERS
from achse.ethercat.master.xml_document import (
    ElementHandler,
    XmlRefusal,
    flag,
    number,
    number_of,
    parse_xml,
)

_MS = 1_000_000
_OUTPUT, _MAILBOX = 0x04, 0x02
"""Bits of a SyncManager's control: the master writes; it is a mailbox."""
_USES = ("MBoxOut", "MBoxIn", "Outputs", "Inputs")
_PROTOCOLS = ("AoE", "EoE", "CoE", "FoE", "SoE", "VoE")
_ENGLISH = "1033"
_LAST_SYNC_MANAGER = 15
DEVICE_PATH = "EtherCATInfo/Descriptions/Devices/Device"
"""The way to a device from the root of a file."""


class EsiError(ValueError):
    """Another file than an ESI, or one with an element that cannot be read; the text names it."""


@dataclass(frozen=True)
class EsiSyncManager:
    """A SyncManager: `use` is MBoxOut, MBoxIn, Outputs or Inputs."""

    use: str
    area: SyncManagerArea
    enabled: bool = True
    op_only: bool = False


@dataclass(frozen=True)
class EsiPdo:
    """A PDO with what else may be assigned beside it."""

    pdo: Pdo
    mandatory: bool = False
    excludes: tuple[int, ...] = ()


@dataclass(frozen=True)
class EsiTime:
    """A time of a clock mode: `ns`, or with a `factor` so many cycles (below 0: a part of one)."""

    ns: int = 0
    factor: int = 0

    def of(self, cycle_ns: int) -> int:
        """In ns; 0 without a factor stays 0."""
        if self.ns or not self.factor:
            return self.ns
        return cycle_ns * self.factor if self.factor > 0 else cycle_ns // -self.factor


@dataclass(frozen=True)
class EsiMode:
    """A clock mode (Dc/OpMode). `pdos` are those it assigns, by SyncManager, where it says so."""

    name: str
    assign_activate: int = 0
    cycle0: EsiTime = EsiTime()
    cycle1: EsiTime = EsiTime()
    shift0_ns: int = 0
    shift1_ns: int = 0
    pdos: tuple[tuple[int, tuple[int, ...]], ...] = ()
    description: str = ""

    def clock(self, cycle_ns: int) -> ClockConfiguration | None:
        """Return the SYNC signals at that bus cycle, None for a mode without.

        Raises `EsiError` for times that a clock cannot have.
        """
        if not self.assign_activate:
            return None
        cycle0 = self.cycle0.of(cycle_ns)
        base = cycle0 or cycle_ns
        # a factor of SYNC1 counts cycles of SYNC0; below 0 it divides that of the bus
        period = self.cycle1.of(base if self.cycle1.factor >= 0 else cycle_ns)
        try:
            return ClockConfiguration(
                self.assign_activate,
                cycle0,
                max(period - base, 0) + self.shift1_ns,
                base // 2 + self.shift0_ns if self.shift0_ns else None,
            )
        except ValueError as fault:
            raise EsiError(f"{self.name}: {fault}") from None


@dataclass(frozen=True)
class EsiDevice:
    """One device of a file. `protocols` are those of its mailbox: CoE, FoE, EoE, SoE, …"""

    name: str
    type_name: str
    vendor_id: int
    product_code: int
    revision_number: int = 0
    group: str = ""
    physics: str = ""
    fmmus: tuple[str, ...] = ()
    sync_managers: tuple[EsiSyncManager, ...] = ()
    outputs: tuple[EsiPdo, ...] = ()
    inputs: tuple[EsiPdo, ...] = ()
    protocols: frozenset[str] = frozenset()
    sdo_information: bool = False
    pdo_assign: bool = False
    pdo_configure: bool = False
    complete_access: bool = False
    mailbox_repeat: bool = False
    commands: tuple[InitCommand, ...] = ()
    idn_commands: tuple[IdnCommand, ...] = ()
    modes: tuple[EsiMode, ...] = ()
    times: StateTimes = field(default=StateTimes())
    eeprom_size: int = 0
    eeprom_head: bytes = b""
    """The first words of the EEPROM (ConfigData)."""
    bootstrap: bytes = b""
    element: Element | None = field(default=None, repr=False, compare=False)
    """The device's element, with its dictionary and slots."""
    modules: Element | None = field(default=None, repr=False, compare=False)
    """The element of the modules in the same file."""

    def mode(self, name: str = "") -> EsiMode | None:
        """Return the mode of that name, by default the first one; None without modes.

        Raises `EsiError` for a name that no mode has.
        """
        if not name:
            return self.modes[0] if self.modes else None
        for each in self.modes:
            if each.name == name:
                return each
        names = ", ".join(each.name for each in self.modes) or "none"
        raise EsiError(f"{self.type_name}: no mode {name!r}; there are: {names}")


def read_esi(
    text: str | bytes,
    *,
    product_code: int = 0,
    revision_number: int = 0,
    encoding: str | None = None,
) -> list[EsiDevice]:
    """Return the devices of an ESI file, all or those with that product and revision.

    Raises `EsiError` for other files, and for a wanted device that cannot be read.
    """
    places = count(1)
    wanted: list[tuple[Element, str, tuple[int, int]]] = []

    def consider(element: Element, _: slice) -> bool:
        place, kind = next(places), element.find("Type")
        if kind is None:
            return False
        name = (kind.text or "").strip() or f"device {place}"
        try:
            product, revision = identity_of(kind)
        except ValueError as fault:
            raise EsiError(f"{name}: {fault}") from None
        if product_code not in (0, product) or revision_number not in (0, revision):
            return False
        wanted.append((element, name, (product, revision)))
        return True

    root = parse_esi(text, {DEVICE_PATH: consider}, encoding)
    modules = root.find("Descriptions/Modules")
    devices = []
    for element, name, identity in wanted:
        try:
            vendor = _within(number(root, "Vendor/Id"), 0xFFFF_FFFF, "Vendor Id")
            devices.append(replace(_device(element, name, (vendor, *identity)), modules=modules))
        except ValueError as fault:
            raise EsiError(f"{name}: {fault}") from None
    return devices


def parse_esi(
    text: str | bytes, handlers: Mapping[str, ElementHandler], encoding: str | None = None
) -> Element:
    """Return the root of an ESI file; raises `EsiError`."""
    try:
        root = parse_xml(text, encoding=encoding, handlers=handlers)
    except XmlRefusal as refusal:
        raise EsiError(f"an ESI file: {refusal}") from None
    if root.tag != "EtherCATInfo":
        raise EsiError(f"expected EtherCATInfo, the root is {root.tag}")
    return root


def identity_of(kind: Element) -> tuple[int, int]:
    """Product code and revision number of a Type; ValueError for what is none."""
    product, revision = (
        _within(number_of(kind.get(name, "0"), name), 0xFFFF_FFFF, name)
        for name in ("ProductCode", "RevisionNo")
    )
    return product, revision


def _device(element: Element, type_name: str, identity: tuple[int, int, int]) -> EsiDevice:
    mailbox = element.find("Mailbox")
    coe = element.find("Mailbox/CoE")
    return EsiDevice(
        _name(element) or type_name,
        type_name,
        *identity,
        group=element.findtext("GroupType", "").strip(),
        physics=element.get("Physics", ""),
        fmmus=tuple((each.text or "").strip() for each in _channels(element, "Fmmu")),
        sync_managers=tuple(_sync_manager(each) for each in _channels(element, "Sm")),
        outputs=tuple(map(read_pdo, element.findall("RxPdo"))),
        inputs=tuple(map(read_pdo, element.findall("TxPdo"))),
        protocols=frozenset(
            each for each in _PROTOCOLS if mailbox is not None and mailbox.find(each) is not None
        ),
        sdo_information=flag(coe, "SdoInfo"),
        pdo_assign=flag(coe, "PdoAssign"),
        pdo_configure=flag(coe, "PdoConfig"),
        complete_access=flag(coe, "CompleteAccess"),
        mailbox_repeat=flag(mailbox, "DataLinkLayer"),
        commands=tuple(coe_commands(coe)),
        idn_commands=tuple(idn_commands(element.find("Mailbox/SoE"))),
        modes=tuple(map(_mode, element.findall("Dc/OpMode"))),
        times=_times(element),
        eeprom_size=number(element, "Eeprom/ByteSize"),
        eeprom_head=bytes.fromhex(element.findtext("Eeprom/ConfigData", "")),
        bootstrap=bytes.fromhex(element.findtext("Eeprom/BootStrap", "")),
        element=element,
    )


def _channels(element: Element, tag: str) -> list[Element]:
    """Return the channels of a controller, FMMUs or SyncManagers; ValueError for more than it can
    have."""
    elements = element.findall(tag)
    if len(elements) > _LAST_SYNC_MANAGER + 1:
        raise ValueError(f"{tag}: expected at most {_LAST_SYNC_MANAGER + 1}, got {len(elements)}")
    return elements


def _name(element: Element) -> str:
    """Return the English name, or the first one."""
    names = element.findall("Name")
    english = [each for each in names if each.get("LcId") == _ENGLISH]
    return next(((each.text or "").strip() for each in english + names), "")


def _sync_manager(element: Element) -> EsiSyncManager:
    control = number_of(element.get("ControlByte", "0"), "Sm ControlByte")
    use = (element.text or "").strip()
    if use not in _USES:
        both = (("Inputs", "Outputs"), ("MBoxIn", "MBoxOut"))
        use = both[bool(control & _MAILBOX)][bool(control & _OUTPUT)]
    return EsiSyncManager(
        use,
        SyncManagerArea(
            _within(number_of(element.get("StartAddress", "0"), "Sm StartAddress"), 0xFFFF, "Sm"),
            _within(number_of(element.get("DefaultSize", "0"), "Sm DefaultSize"), 0xFFFF, "Sm"),
            _within(control, 0xFF, "Sm ControlByte"),
        ),
        enabled=number_of(element.get("Enable", "1") or "1", "Sm Enable") != 0,
        op_only=flag(element, "OpOnly"),
    )


def _within(value: int, most: int, name: str) -> int:
    if not 0 <= value <= most:
        raise ValueError(f"{name}: expected 0 to 0x{most:X}, got {value}")
    return value


def read_pdo(element: Element) -> EsiPdo:
    """Return a PDO from its element, RxPdo or TxPdo; ValueError for a number that is none."""
    manager = element.get("Sm")
    index = _within(number(element, "Index"), 0xFFFF, "PDO Index")
    entries = tuple(
        PdoEntry(
            _within(number(entry, "Index"), 0xFFFF, f"{index:04X}: Entry Index"),
            _within(number(entry, "SubIndex"), 0xFF, f"{index:04X}: Entry SubIndex"),
            _within(number(entry, "BitLen"), 0xFFFF, f"{index:04X}: Entry BitLen"),
            entry.findtext("Name", "").strip(),
            TYPE_NUMBERS.get(entry.findtext("DataType", "").strip(), 0),
        )
        for entry in element.findall("Entry")
    )
    place = (
        None
        if manager is None or not manager.strip()
        else _within(number_of(manager.strip(), "PDO Sm"), _LAST_SYNC_MANAGER, "PDO Sm")
    )
    return EsiPdo(
        Pdo(index, element.findtext("Name", "").strip(), place, flag(element, "Fixed"), entries),
        mandatory=flag(element, "Mandatory"),
        excludes=tuple(
            number_of((each.text or "").strip(), f"{index:04X}: Exclude")
            for each in element.findall("Exclude")
        ),
    )


def coe_commands(coe: Element | None) -> Iterator[InitCommand]:
    """Downloads of the mailbox; a command for several transitions is one for each."""
    for element in [] if coe is None else coe.findall("InitCmd"):
        for transition in element.findall("Transition"):
            yield InitCommand(
                _within(number(element, "Index"), 0xFFFF, "InitCmd Index"),
                _within(number(element, "SubIndex"), 0xFF, "InitCmd SubIndex"),
                bytes.fromhex(element.findtext("Data", "")),
                (transition.text or "").strip(),
                flag(element, "CompleteAccess"),
                element.findtext("Comment", "").strip(),
            )


def idn_commands(soe: Element | None) -> Iterator[IdnCommand]:
    """Writes to IDNs; a command for several transitions is one for each."""
    for element in [] if soe is None else soe.findall("InitCmd"):
        data = element.find("Data")
        for transition in element.findall("Transition"):
            yield IdnCommand(
                _within(number(element, "IDN"), 0xFFFF, "SoE InitCmd IDN"),
                bytes.fromhex(element.findtext("Data", "")),
                _within(number_of(element.get("Chn", "0") or "0", "SoE InitCmd Chn"), 7, "Chn"),
                (transition.text or "").strip(),
                element.findtext("Comment", "").strip(),
                flag(data, "AdaptAutomatically"),
            )


def _mode(element: Element) -> EsiMode:
    pdos = tuple(
        (
            _within(number_of(each.get("No", "0"), "OpMode Sm"), _LAST_SYNC_MANAGER, "OpMode Sm"),
            tuple(
                number_of((pdo.text or "").strip(), "OpMode Sm Pdo") for pdo in each.findall("Pdo")
            ),
        )
        for each in element.findall("Sm")
        if each.find("Pdo") is not None
    )
    return EsiMode(
        element.findtext("Name", "").strip(),
        _within(number(element, "AssignActivate"), 0xFFFF, "AssignActivate"),
        _time(element, "CycleTimeSync0"),
        _time(element, "CycleTimeSync1"),
        number(element, "ShiftTimeSync0"),
        number(element, "ShiftTimeSync1"),
        pdos,
        element.findtext("Desc", "").strip(),
    )


def _time(element: Element, tag: str) -> EsiTime:
    child = element.find(tag)
    factor = "0" if child is None else child.get("Factor", "0")
    return EsiTime(number(element, tag), number_of(factor or "0", f"{tag} Factor"))


def _times(element: Element) -> StateTimes:
    usual = StateTimes()
    states, mailbox = "Info/StateMachine/Timeout/", "Info/Mailbox/Timeout/"

    def time(path: str, default: int) -> int:
        return number(element, path, default // _MS) * _MS

    return StateTimes(
        time(f"{states}PreopTimeout", usual.preop_ns),
        time(f"{states}SafeopOpTimeout", usual.safeop_op_ns),
        time(f"{states}BackToInitTimeout", usual.back_to_init_ns),
        time(f"{states}BackToSafeopTimeout", usual.back_to_safeop_ns),
        time(f"{mailbox}RequestTimeout", usual.request_ns),
        time(f"{mailbox}ResponseTimeout", usual.response_ns),
    )


def from_esi(
    device: EsiDevice,
    name: str = "",
    *,
    mode: str = "",
    cycle_ns: int = 2 * _MS,
    pdos: Collection[int] | None = None,
) -> SlaveConfiguration:
    """Return a slave by its ESI: default PDOs, or those with the indices `pdos`.

    Some files assign PDOs by default that exclude each other; the first of them is taken.

    `mode` is the name of a clock mode, the first one by default; its times are for the bus cycle
    `cycle_ns`. Raises `EsiError` for a mode or PDO that the device has not, for PDOs that exclude
    each other, and where a mandatory one is left out.
    """
    chosen = device.mode(mode)
    managers = tuple(
        ProcessSyncManager(place, each.area.start, each.area.control, each.use == "Outputs")
        for place, each in enumerate(device.sync_managers)
        if each.use in ("Outputs", "Inputs")
    )
    areas = {each.use: each.area for each in device.sync_managers if each.area.length}
    listed = dict(chosen.pdos) if chosen is not None else {}
    wanted = None if pdos is None else list(pdos)
    known = {each.pdo.index for each in (*device.outputs, *device.inputs)}
    unknown = [each for each in wanted or [] if each not in known]
    if unknown:
        raise EsiError(f"{device.type_name}: no PDO {', '.join(f'{n:04X}' for n in unknown)}")
    outputs = _assigned(device, True, managers, listed, wanted)
    inputs = _assigned(device, False, managers, listed, wanted)
    coe = "CoE" in device.protocols and "MBoxOut" in areas and "MBoxIn" in areas
    return SlaveConfiguration(
        name or device.name,
        device.vendor_id,
        device.product_code,
        device.revision_number,
        mailbox_out=areas.get("MBoxOut"),
        mailbox_in=areas.get("MBoxIn"),
        coe=coe,
        protocols=int(MailboxBit.of(device.protocols)) if "MBoxOut" in areas else 0,
        complete_access=device.complete_access,
        sync_managers=managers,
        outputs=outputs,
        inputs=inputs,
        assign=coe and device.pdo_assign,
        configure=coe and device.pdo_assign and device.pdo_configure,
        commands=device.commands,
        idn_commands=device.idn_commands,
        clock=None if chosen is None else chosen.clock(cycle_ns),
        times=device.times,
        type_name=device.type_name,
    )


def described(
    slave: SlaveConfiguration, devices: Iterable[EsiDevice], *, cycle_ns: int = 2 * _MS
) -> SlaveConfiguration:
    """Return a scanned slave with what only its ESI has: clock mode, start commands, time-outs.

    Taken is the device of its revision, else the newest before it; without one the slave stays
    as it is. PDOs are those of the scan.
    """
    fitting = [
        each
        for each in devices
        if (each.vendor_id, each.product_code) == (slave.vendor_id, slave.product_code)
        and each.revision_number <= slave.revision_number
    ]
    if not fitting:
        return slave
    device = max(fitting, key=lambda each: each.revision_number)
    mode = device.mode()
    return replace(
        slave,
        clock=slave.clock if mode is None else mode.clock(cycle_ns),
        commands=device.commands,
        idn_commands=device.idn_commands,
        times=device.times,
        type_name=device.type_name,
        complete_access=slave.complete_access and device.complete_access,
    )


def _assigned(
    device: EsiDevice,
    output: bool,
    managers: Sequence[ProcessSyncManager],
    listed: dict[int, tuple[int, ...]],
    wanted: Sequence[int] | None,
) -> tuple[Pdo, ...]:
    """Return the PDOs of one direction, each with its SyncManager."""
    usual = next((each.number for each in managers if each.output == output), None)
    by_mode = {pdo: manager for manager, pdos in listed.items() for pdo in pdos}
    assigned = []
    for each in device.outputs if output else device.inputs:
        index, manager = each.pdo.index, each.pdo.sync_manager
        if wanted is not None:
            taken = index in wanted
        elif manager in listed or index in by_mode:
            taken = index in by_mode
        else:
            taken = manager is not None
        if not taken:
            if each.mandatory and wanted is not None:
                raise EsiError(f"{device.type_name}: PDO {index:04X} is mandatory")
            continue
        place = by_mode.get(index, manager if manager is not None else usual)
        if place is None:
            raise EsiError(f"{device.type_name}: no SyncManager for PDO {index:04X}")
        assigned.append(replace(each, pdo=replace(each.pdo, sync_manager=place)))
    if wanted is None:
        assigned = _first_of_each(assigned)
    present = {each.pdo.index for each in assigned}
    for each in assigned:
        against = present.intersection(each.excludes) - {each.pdo.index}
        if against:
            names = ", ".join(f"{n:04X}" for n in sorted(against))
            raise EsiError(f"{device.type_name}: PDO {each.pdo.index:04X} excludes {names}")
    return tuple(each.pdo for each in assigned)


def _first_of_each(pdos: Sequence[EsiPdo]) -> list[EsiPdo]:
    """Without those that one before them excludes; what is mandatory stays."""
    unique: list[EsiPdo] = []
    excluded: set[int] = set()
    for each in pdos:
        if each.mandatory or each.pdo.index not in excluded:
            unique.append(each)
            excluded.update(each.excludes)
    return unique
