"""The process image: where each entry of each slave is in the cyclic datagrams.

Logical addresses: per sync unit the outputs of its slaves one after the other, then their inputs;
each slave begins at a whole byte, but slaves with fewer than 8 bits, as digital terminals, share
one if their FMMUs count in bits. Each SyncManager with process data takes one FMMU, the mailbox
state one more.

Source: ETG.1000.4 §5.4 (working counter), §6.6 (FMMU).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from achse.ethercat.fmmu import Fmmu
from achse.ethercat.frame import DatagramCommand
from achse.ethercat.master.configuration import (
    BusConfiguration,
    ProcessSyncManager,
    SlaveConfiguration,
)
from achse.ethercat.registers import SM_BASE

FIRST_LOGICAL = 0x0100_0000
"""Of the first process data."""
MAILBOX_BITS = 0x0900_0000
"""Logical address of the mailbox states, one bit for each slave."""

_STEP = 0x0800
"""From one datagram to the next."""
_LIMIT = 1400
"""Bytes of process data in one datagram: it shares its frame with others."""

_READ, _WRITE = 1, 2
_SM1_STATUS = SM_BASE + 8 + 5
_FULL_BIT = 3


@dataclass(frozen=True, slots=True)
class EntryPlace:
    """Position of an entry in the `outputs` or `inputs` of its slave; `bit` counts from their
    start."""

    index: int
    subindex: int
    bit: int
    bits: int
    name: str
    data_type: int
    pdo: int

    @property
    def byte(self) -> int:
        """The byte in which it begins."""
        return self.bit >> 3


def entry_places(slave: SlaveConfiguration, output: bool) -> tuple[EntryPlace, ...]:
    """Return all entries of one direction, padding left out, in order."""
    places = []
    base = 0
    for manager in _managers(slave, output):
        bit = base
        for pdo in slave.outputs if output else slave.inputs:
            if slave.manager_of(pdo) != manager.number:
                continue
            for entry in pdo.entries:
                if entry.index:
                    places.append(
                        EntryPlace(
                            entry.index,
                            entry.subindex,
                            bit,
                            entry.bits,
                            entry.name,
                            entry.data_type,
                            pdo.index,
                        )
                    )
                bit += entry.bits
        base += 8 * (slave.bits(manager) + 7 >> 3)
    return tuple(places)


def _managers(slave: SlaveConfiguration, output: bool) -> list[ProcessSyncManager]:
    return [each for each in slave.sync_managers if each.output == output and slave.bits(each)]


@dataclass
class ProcessArea:
    """The process data of one slave in one direction: `first` is its byte in the datagram.

    Where slaves share a byte, `bits` are its bits from `bit` of that byte on; else 0.
    """

    first: int = 0
    length: int = 0
    bit: int = 0
    bits: int = 0


@dataclass
class ProcessDatagram:
    """One logical datagram with the slaves that have their data in it.

    `working` is the working counter that it should come back with. `output_end` is where its
    outputs end and its inputs begin. `valid` is true if the last cycle had that counter, `fresh`
    counts the cycles that had, `wrong` those that had not.
    """

    unit: str
    logical: int
    command: DatagramCommand
    slaves: list[int] = field(default_factory=list)
    length: int = 0
    output_end: int = 0
    working: int = 0
    valid: bool = False
    fresh: int = 0
    wrong: int = 0


@dataclass(frozen=True)
class _Size:
    """Bytes of a slave; bits where it may share a byte, else 0."""

    position: int
    outputs: int
    inputs: int
    output_bits: int = 0
    input_bits: int = 0


class ProcessImage:
    """Datagrams, areas and FMMUs of a bus, made from its configuration once."""

    def __init__(self, bus: BusConfiguration) -> None:
        self.bus = bus
        self.datagrams: list[ProcessDatagram] = []
        self.outputs: list[ProcessArea] = [ProcessArea() for _ in bus.slaves]
        self.inputs: list[ProcessArea] = [ProcessArea() for _ in bus.slaves]
        self.writes: dict[int, ProcessDatagram] = {}
        """By position: the datagram that a slave takes its outputs from."""
        self.reads: dict[int, ProcessDatagram] = {}
        for unit, members in _units(bus.slaves).items():
            for chunk in _chunks(members):
                self._add(unit, chunk)
        self.mailboxes = [
            position for position, slave in enumerate(bus.slaves) if slave.mailbox_in is not None
        ]

    def _add(self, unit: str, chunk: list[_Size]) -> None:
        base = FIRST_LOGICAL + _STEP * len(self.datagrams)
        whole = all(self.bus.slaves[each.position].logical_read_write for each in chunk)
        outputs = [each for each in chunk if each.outputs]
        inputs = [each for each in chunk if each.inputs]
        out_areas, out_size = _placed((e.position, e.outputs, e.output_bits) for e in outputs)
        if whole and outputs and inputs:
            datagrams = [ProcessDatagram(unit, base, DatagramCommand.LRW)]
            datagrams[0].working = 2 * len(outputs) + len(inputs)
        else:
            datagrams = [
                ProcessDatagram(unit, at, command, working=len(members))
                for command, members, at in (
                    (DatagramCommand.LWR, outputs, base),
                    (DatagramCommand.LRD, inputs, base + out_size),
                )
                if members
            ]
        for datagram in datagrams:
            at = 0
            if datagram.command is not DatagramCommand.LRD:
                for position, area in out_areas.items():
                    self.outputs[position] = area
                    self.writes[position] = datagram
                at = out_size
            datagram.output_end = at
            if datagram.command is not DatagramCommand.LWR:
                areas, at = _placed(((e.position, e.inputs, e.input_bits) for e in inputs), at)
                for position, area in areas.items():
                    self.inputs[position] = area
                    self.reads[position] = datagram
            datagram.length = at
            datagram.slaves = [each.position for each in chunk]
            self.datagrams.append(datagram)

    def fmmus(self, position: int, available: int) -> list[Fmmu]:
        """Return the FMMUs of a slave, at most `available`; the mailbox state comes last, if it
        fits.

        ValueError if the process data need more.
        """
        slave = self.bus.slaves[position]
        fmmus = []
        for output, areas, owners, direction in (
            (True, self.outputs, self.writes, _WRITE),
            (False, self.inputs, self.reads, _READ),
        ):
            owner = owners.get(position)
            if owner is None:
                continue
            area = areas[position]
            at = owner.logical + area.first
            if area.bits:
                (manager,) = _managers(slave, output)
                last = area.bit + area.bits - 1
                fmmus.append(Fmmu(at, 1, area.bit, last, manager.start, 0, direction, 1))
                continue
            for manager in _managers(slave, output):
                size = slave.bits(manager) + 7 >> 3
                fmmus.append(Fmmu(at, size, 0, 7, manager.start, 0, direction, 1))
                at += size
        if len(fmmus) > available:
            raise ValueError(
                f"{slave.name}: process data need {len(fmmus)} FMMUs, the slave has {available}"
            )
        if slave.mailbox_in is not None and len(fmmus) < available:
            bit = self.mailboxes.index(position)
            fmmus.append(
                Fmmu(
                    MAILBOX_BITS + (bit >> 3), 1, bit & 7, bit & 7, _SM1_STATUS, _FULL_BIT, _READ, 1
                )
            )
        return fmmus

    def lengths(self, position: int) -> Mapping[int, int]:
        """Return bytes of each SyncManager with process data, 0 where nothing is mapped."""
        slave = self.bus.slaves[position]
        return {each.number: slave.bits(each) + 7 >> 3 for each in slave.sync_managers}


def _placed(
    members: Iterable[tuple[int, int, int]], begin: int = 0
) -> tuple[dict[int, ProcessArea], int]:
    """Areas by position, one behind the other from byte `begin` on, and the byte where they end.

    Members are position, bytes, and bits where a byte may be shared.
    """
    areas: dict[int, ProcessArea] = {}
    at = 8 * begin
    for position, size, bits in members:
        if not bits or (at & 7) + bits > 8:
            at = at + 7 & ~7
        areas[position] = ProcessArea(at >> 3, size, at & 7, bits)
        at += bits or 8 * size
    return areas, at + 7 >> 3


def _shared(slave: SlaveConfiguration, output: bool) -> int:
    """Bits that may share a byte; 0 where a slave has bytes of its own."""
    managers = _managers(slave, output)
    bits = slave.bits(managers[0]) if slave.packed and len(managers) == 1 else 0
    return bits if bits < 8 else 0


def _units(slaves: Sequence[SlaveConfiguration]) -> dict[str, list[_Size]]:
    units: dict[str, list[_Size]] = {}
    for position, slave in enumerate(slaves):
        outputs, inputs = (
            sum(slave.bits(each) + 7 >> 3 for each in _managers(slave, output))
            for output in (True, False)
        )
        if outputs or inputs:
            size = _Size(position, outputs, inputs, _shared(slave, True), _shared(slave, False))
            units.setdefault(slave.sync_unit, []).append(size)
    return units


def _chunks(members: Iterable[_Size]) -> Iterable[list[_Size]]:
    """Slaves that share a datagram; ValueError if one is too large for a frame by itself."""
    chunk: list[_Size] = []
    size = 0
    for each in members:
        needed = each.outputs + each.inputs
        if needed > _LIMIT:
            raise ValueError(f"a slave has {_LIMIT} bytes of process data at most, got {needed}")
        if size + needed > _LIMIT:
            yield chunk
            chunk, size = [], 0
        chunk.append(each)
        size += needed
    yield chunk
