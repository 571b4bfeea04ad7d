"""Scanning: a configuration of the bus as it is, from EEPROMs and, where it speaks CoE, objects.

Nothing is written to the slaves but station addresses and the states that reading needs. The bus
goes to Init for it: no process data flow while a scan runs.

Source: ETG.2010 for the EEPROM; ETG.1020 for the assignment of PDOs; 001 §2.8.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from achse.codes import AlState
from achse.ethercat.description import Pdo, PdoEntry
from achse.ethercat.master.bring_up import mailbox_registers
from achse.ethercat.master.bus_slave import SlaveFacts
from achse.ethercat.master.configuration import (
    ASSIGN_SYNC0,
    FIRST_STATION,
    ClockConfiguration,
    SlaveConfiguration,
    from_sii,
)
from achse.ethercat.master.eeprom_client import EepromClient
from achse.ethercat.master.errors import BusError, FrameLost
from achse.ethercat.master.inspection import count_slaves, inspect, reset_bus, set_station
from achse.ethercat.master.mailbox_client import MailboxClient
from achse.ethercat.master.sdo_client import SdoClient
from achse.ethercat.master.sii_reader import SiiContent, read_sii
from achse.ethercat.master.states import acknowledge, change_state
from achse.ethercat.master.steps import Steps, write
from achse.ethercat.registers import SM_BASE

_ASSIGNMENT = 0x1C10
_MOST_PDOS, _MOST_ENTRIES = 64, 255


@dataclass(frozen=True)
class ScannedSlave:
    """A slave as a scan found it: registers, EEPROM, and the configuration made from them.

    `trouble` says what could not be read, empty if all could.
    """

    position: int
    station: int
    facts: SlaveFacts
    image: bytes
    content: SiiContent
    configuration: SlaveConfiguration
    trouble: str = ""


def scan_bus(
    *,
    with_objects: bool = True,
    progress: Callable[[int, int], None] = lambda done, all_: None,
) -> Steps[list[ScannedSlave]]:
    """All slaves there are; raises `BusError` if the bus itself cannot be read.

    With `with_objects` slaves with CoE go to PreOp, and the assignment and mapping of their PDOs
    are read; without, those of the EEPROM are taken. `progress(done, all)` is called for each.
    """
    count = yield from count_slaves()
    if count == 0:
        raise FrameLost("no slave answers")
    yield from reset_bus()
    slaves = []
    for position in range(count):
        progress(position, count)
        station = FIRST_STATION + position
        yield from set_station(position, station)
        slaves.append((yield from _scan_slave(position, station, with_objects)))
    progress(count, count)
    return slaves


def _scan_slave(position: int, station: int, with_objects: bool) -> Steps[ScannedSlave]:
    facts = yield from inspect(station)
    eeprom = EepromClient(station)
    trouble = ""
    image = b""
    try:
        yield from eeprom.claim()
        image = yield from eeprom.image()
    except BusError as fault:
        trouble = str(fault)
    content = read_sii(image)
    vendor, product, revision, _ = facts.identity
    name = content.name or f"{vendor:08X}:{product:08X}"
    configuration = replace(
        from_sii(content, f"Box {position + 1} ({name})"),
        vendor_id=vendor,
        product_code=product,
        revision_number=revision,
        station=station,
        packed=facts.maps_bits,
        logical_read_write=facts.logical_read_write,
    )
    mode = next((each for each in content.modes if each.assign_activate & ASSIGN_SYNC0), None)
    if facts.has_clock and mode is not None:
        configuration = replace(configuration, clock=ClockConfiguration(mode.assign_activate))
    if with_objects and configuration.coe and not trouble:
        try:
            configuration = yield from _with_objects(station, configuration, eeprom)
        except BusError as fault:
            trouble = str(fault)
    return ScannedSlave(
        position, station, facts, image, content, configuration, trouble or content.damage
    )


def _with_objects(
    station: int, slave: SlaveConfiguration, eeprom: EepromClient
) -> Steps[SlaveConfiguration]:
    """Return the same slave with the PDOs that its objects assign now."""
    out, into = slave.mailbox_out, slave.mailbox_in
    assert out is not None
    assert into is not None
    yield from acknowledge(station)
    yield from write(station, SM_BASE, mailbox_registers(out, into))
    yield from eeprom.hand_over()
    yield from change_state(
        station, AlState.PREOP, slave.times.allowed(AlState.INIT, AlState.PREOP)
    )
    sdo = SdoClient(MailboxClient(station, out, into, lambda data: None))
    known = {
        (entry.index, entry.subindex): entry
        for pdo in (*slave.outputs, *slave.inputs)
        for entry in pdo.entries
    }
    sides: dict[bool, tuple[Pdo, ...]] = {}
    for output in (True, False):
        pdos: list[Pdo] = []
        for manager in slave.sync_managers:
            if manager.output == output:
                numbers = yield from _numbers(sdo, _ASSIGNMENT + manager.number, 2, _MOST_PDOS)
                for number in numbers:
                    entries = yield from _numbers(sdo, number, 4, _MOST_ENTRIES)
                    pdos.append(_pdo(number, manager.number, entries, known))
        sides[output] = tuple(pdos)
    return replace(slave, outputs=sides[True], inputs=sides[False])


def _numbers(sdo: SdoClient, index: int, size: int, most: int) -> Steps[list[int]]:
    """Entries 1 to n of a list, n from its subindex 0."""
    count = int.from_bytes((yield from sdo.upload(index, 0))[:1], "little")
    numbers = []
    for subindex in range(1, min(count, most) + 1):
        value = yield from sdo.upload(index, subindex)
        numbers.append(int.from_bytes(value[:size], "little"))
    return numbers


def _pdo(
    index: int, manager: int, entries: Sequence[int], known: dict[tuple[int, int], PdoEntry]
) -> Pdo:
    pdo_entries = []
    for each in entries:
        place = each >> 16, each >> 8 & 0xFF
        name, kind = (known[place].name, known[place].data_type) if place in known else ("", 0)
        pdo_entries.append(PdoEntry(*place, each & 0xFF, name, kind))
    return Pdo(index, "", manager, False, tuple(pdo_entries))
