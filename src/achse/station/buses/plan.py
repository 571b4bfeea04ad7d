"""Plan of a station's bus: a drive or a terminal at each place along the cable.

A plan makes the configuration of the bus, from the virtual slaves of this process or from the
slaves that a search found on a network interface.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from achse.ethercat import describe
from achse.ethercat.master import (
    BusConfiguration,
    ClockConfiguration,
    InitCommand,
    SlaveConfiguration,
    from_description,
)
from achse.ethercat.master.configuration import FIRST_STATION
from achse.ethercat.master.scanning import ScannedSlave
from achse.ethercat.terminals import AnalogTerminal, DigitalTerminal
from achse.ethercat.virtual import VirtualDevice
from achse.motion.servo import INPUT_OBJECTS, OUTPUT_OBJECTS
from achse.motion.servo.optional import INTERPOLATION_TIME, MODE_DISPLAY
from achse.station.buses.esi_terminals import make_esi_terminal
from achse.station.buses.virtual_drives import make_drives
from achse.station.configuration.bus import BusConfig, DriveConfig
from achse.station.configuration.terminal import TerminalConfig

DEFAULT_OUTPUTS = (0x6040, 0x6060, 0x6071, 0x607A, 0x60B8, 0x60FF)
DEFAULT_INPUTS = (0x6041, 0x6061, 0x6064, 0x6077, 0x60B9, 0x60BA, 0x60BB, 0x60FD)
"""Process data by which an axis has all modes, both edges of touch probe 1 and the inputs."""

TerminalDevice: TypeAlias = DigitalTerminal | AnalogTerminal | VirtualDevice
"""The device of a [[terminal]]."""

_NOBODY = 0xFFFF_FFFF
"""A vendor id that no slave has."""
_TARGETS = {"csp": 0x607A, "csv": 0x60FF, "cst": 0x6071}
_EXPONENTS = (-3, -4, -5, -6)


@dataclass(frozen=True)
class BusSlot:
    """A place along the cable, 0 the first, and what the station has there."""

    place: int
    name: str
    device: DriveConfig | TerminalConfig
    folder: Path = Path()
    """Folder of the station.toml, in which ESI files are looked for."""


class BusPlan:
    """The slots of a bus: those of `drives`, then those of `terminals`, each in their order.

    Without a position the next free place is taken. `cycle_ns` is that of the bus. Files are
    relative to `folder`. ValueError for a position that two have.
    """

    def __init__(
        self,
        bus: BusConfig,
        drives: Sequence[DriveConfig],
        terminals: Sequence[TerminalConfig],
        cycle_ns: int,
        folder: Path = Path(),
    ) -> None:
        self.bus = bus
        self.cycle_ns = cycle_ns
        devices: list[tuple[str, DriveConfig | TerminalConfig]] = [
            *((f"Drive {n} (axis {drive.axis})", drive) for n, drive in enumerate(drives, 1)),
            *((terminal.name, terminal) for terminal in terminals),
        ]
        places = _places([(name, device.position) for name, device in devices])
        self.slots = tuple(
            BusSlot(place, name, device, folder)
            for place, (name, device) in zip(places, devices, strict=True)
        )
        self.own_mapping = any(drive.own_mapping for drive in drives)

    def in_process(self, known: Mapping[int, SlaveConfiguration]) -> BusConfiguration:
        """Return the bus of virtual slaves, one for each slot; `known` describes them by place."""
        along = sorted(self.slots, key=lambda slot: slot.place)
        slaves = tuple(self._configured(slot, known[slot.place]) for slot in along)
        return self._bus(slaves)

    def _bus(self, slaves: tuple[SlaveConfiguration, ...]) -> BusConfiguration:
        bus = self.bus
        return BusConfiguration(
            slaves,
            self.cycle_ns,
            name=bus.name,
            clock_window_ns=bus.clock_window,
            redundant=bool(bus.redundant),
        )

    def expected(self) -> BusConfiguration:
        """Return the bus as long as nothing is known of its slaves: virtual ones in their
        places."""
        return self.configuration_of([])[0]

    def configuration_of(
        self, slaves: Sequence[ScannedSlave]
    ) -> tuple[BusConfiguration, list[str]]:
        """Return the bus of these slaves, and what is wrong with it.

        A slot without a slave that fits has what is expected there, so that such a slave may come.
        Other slaves are brought to Op too, without links.
        """
        slots = {slot.place: slot for slot in self.slots}
        count = max(len(slaves), *(place + 1 for place in slots), 0)
        configurations: list[SlaveConfiguration] = []
        faults: list[str] = []
        missing: list[str] = []
        for place in range(count):
            there = slaves[place] if place < len(slaves) else None
            slot = slots.get(place)
            if slot is None:
                if there is not None:
                    unlinked = replace(there.configuration, clock=None, optional=True)
                    configurations.append(_at(place, unlinked))
                continue
            configuration = self._expected(slot)
            if there is None:
                missing.append(slot.name)
            else:
                own = self._configured(slot, there.configuration)
                fault = there.trouble or _misfit(slot, own)
                if fault:
                    name = there.configuration.type_name or there.configuration.name
                    faults.append(f"place {place + 1} ({name}) cannot be {slot.name}: {fault}")
                else:
                    configuration = own
            configurations.append(_at(place, configuration))
        if missing:
            faults.insert(
                0,
                f"{len(slaves)} slaves found, {len(slaves) + len(missing)} or more expected:"
                f" {', '.join(missing)} missing",
            )
        return self._bus(tuple(configurations)), faults

    def _expected(self, slot: BusSlot) -> SlaveConfiguration:
        """Return the configuration expected as long as the slave was not read."""
        device = slot.device
        if not isinstance(device, DriveConfig) or not device.own_mapping:
            return self._configured(slot, _virtual(slot))
        # its process data have to be read: no slave fits until the bus is searched again
        device = device.model_copy(update={"own_mapping": False})
        slave = self._configured(replace(slot, device=device), _virtual(slot))
        return replace(slave, vendor_id=_NOBODY)

    def _configured(self, slot: BusSlot, slave: SlaveConfiguration) -> SlaveConfiguration:
        slave = replace(slave, name=slot.name)
        if isinstance(slot.device, DriveConfig):
            return slave_configuration(slave, self.bus, slot.device, self.cycle_ns)
        return replace(slave, clock=None)


def _places(wanted: Sequence[tuple[str, int | None]]) -> list[int]:
    """Return a place for each, 0 the first."""
    taken: dict[int, str] = {}
    for name, position in wanted:
        if position is not None:
            if position in taken:
                raise ValueError(f"position {position}: {taken[position]} is there, got {name} too")
            taken[position] = name
    free = (position for position in range(1, len(wanted) + 256) if position not in taken)
    return [(next(free) if position is None else position) - 1 for _, position in wanted]


def _at(place: int, slave: SlaveConfiguration) -> SlaveConfiguration:
    return replace(slave, station=FIRST_STATION + place)


def _virtual(slot: BusSlot) -> SlaveConfiguration:
    """Return the virtual slave of a slot."""
    if isinstance(slot.device, DriveConfig):
        (drive,) = make_drives([slot.device])
        return from_description(describe(drive))
    return described_terminal(make_terminal(slot.device, slot.folder))


def described_terminal(terminal: TerminalDevice) -> SlaveConfiguration:
    """Return a terminal as a master knows it."""
    if isinstance(terminal, VirtualDevice):
        return terminal.configuration
    return from_description(describe(terminal))


def make_terminal(config: TerminalConfig, folder: Path = Path()) -> TerminalDevice:
    """Return the virtual terminal that a table says; EsiError for a device of a file that cannot
    be."""
    if config.esi is not None:
        return make_esi_terminal(config, folder)
    terminal_type = DigitalTerminal if config.is_digital else AnalogTerminal
    return terminal_type(config.input_count, config.output_count, config.name)


def _misfit(slot: BusSlot, slave: SlaveConfiguration) -> str:
    """Return the reason why a slave does not fit the station's device there, empty if it fits."""
    sizes = [
        sum(slave.bits(each) for each in slave.sync_managers if each.output == output) + 7 >> 3
        for output in (False, True)
    ]
    if isinstance(slot.device, TerminalConfig):
        virtual = make_terminal(slot.device, slot.folder)
        wanted = [virtual.input_size, virtual.output_size]
        message = "expected {} bytes of inputs and {} of outputs".format(*wanted)
        return "" if sizes == wanted else message + ", it has {} and {}".format(*sizes)
    if not slave.coe and not slot.device.own_mapping:
        return "it has no CoE"
    needed = (
        ("outputs", slave.outputs, (0x6040, _TARGETS[slot.device.mode]), OUTPUT_OBJECTS),
        ("inputs", slave.inputs, (0x6041, 0x6064), INPUT_OBJECTS),
    )
    for way, pdos, objects, known in needed:
        entries = {(each.index, each.subindex): each for pdo in pdos for each in pdo.entries}
        for index in objects:
            entry = entries.get((index, 0))
            if entry is None or entry.bits != 8 * known[index].size:
                return f"{index:04X}h is not in its {way}"
    return ""


def slave_configuration(
    slave: SlaveConfiguration, bus: BusConfig, drive: DriveConfig, cycle_ns: int
) -> SlaveConfiguration:
    """Return a slave as the drive of an axis: mapping, start commands, SYNC0, sync unit of its
    own."""
    if not drive.own_mapping:
        slave = slave.with_entries(
            [
                (index, 0, 8 * OUTPUT_OBJECTS[index].size)
                for index in drive.outputs or DEFAULT_OUTPUTS
            ],
            [(index, 0, 8 * INPUT_OBJECTS[index].size) for index in drive.inputs or _inputs(drive)],
        )
    clock = (slave.clock or ClockConfiguration()) if bus.synchronous else None
    cycle = _interpolation(cycle_ns) if drive.interpolation_time else ()
    commands = (*cycle, *_homing(drive), *_start(drive))
    return replace(
        slave,
        clock=clock,
        commands=(*slave.commands, *commands),
        sync_unit=drive.sync_unit or slave.name,
    )


def _inputs(drive: DriveConfig) -> list[int]:
    """Return the default inputs that the drive has."""
    return [each for each in DEFAULT_INPUTS if drive.mode_display or each != MODE_DISPLAY.index]


def _command(index: int, subindex: int, value: int, size: int, comment: str) -> InitCommand:
    data = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
    return InitCommand(index, subindex, data, comment=comment)


def _interpolation(cycle_ns: int) -> list[InitCommand]:
    """60C2h: the cycle of the set values; nothing where the object has no form for it."""
    for exponent in _EXPONENTS:
        value, rest = divmod(cycle_ns, 10 ** (9 + exponent))
        if not rest and value <= 255:
            comment = "interpolation time"
            return [
                _command(INTERPOLATION_TIME.index, 1, value, 1, comment),
                _command(INTERPOLATION_TIME.index, 2, exponent, 1, comment),
            ]
    return []


def _homing(drive: DriveConfig) -> list[InitCommand]:
    homing = drive.homing
    if homing is None:
        return []

    def increments(value: float) -> int:
        return round(value / drive.scaling)

    return [
        _command(0x6098, 0, homing.method, 1, "homing method"),
        _command(0x6099, 1, increments(homing.search_velocity), 4, "velocity towards the switch"),
        _command(0x6099, 2, increments(homing.index_velocity), 4, "velocity towards the index"),
        _command(0x609A, 0, increments(homing.acceleration), 4, "homing acceleration"),
        _command(0x607C, 0, increments(homing.offset), 4, "home offset"),
    ]


def _start(drive: DriveConfig) -> list[InitCommand]:
    return [
        _command(each.index, each.subindex, each.value, each.size, "[[drive.start]]")
        for each in drive.start
    ]
