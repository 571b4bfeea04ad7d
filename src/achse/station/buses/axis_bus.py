"""Buses of a station: the axes of the NC joined with the drives that are slaves of a bus.

In each cycle of the NC the inputs of the last frame are taken, the NC works, and the outputs go out
with the next frame.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from achse.ams import NetId
from achse.drive import Drive
from achse.motion import Nc
from achse.motion.servo import ProcessEntry, ServoLink, Servos, ServoView
from achse.motion.servo.optional import DriveParts
from achse.station.buses.ethercat_bus import EthercatBus
from achse.station.buses.kernel_cycles import KernelCycles
from achse.station.buses.servo_options import servo_options
from achse.station.configuration.bus import DriveConfig


class BusPlace(Protocol):
    """Position of an entry in the process data of a slave."""

    @property
    def bit(self) -> int: ...

    @property
    def bits(self) -> int: ...


class DriveSlave(Protocol):
    """A slave with a drive: memory of its process data, and whether that is alive."""

    @property
    def station(self) -> int:
        """Its station address, which is its AMS port at the NetId of the bus."""

    @property
    def name(self) -> str: ...

    @property
    def last_trouble(self) -> str:
        """Reason why the slave does not reach its state, empty if it does."""

    @property
    def inputs(self) -> memoryview: ...

    @property
    def outputs(self) -> memoryview: ...

    @property
    def input_entries(self) -> Mapping[tuple[int, int], BusPlace]: ...

    @property
    def output_entries(self) -> Mapping[tuple[int, int], BusPlace]: ...

    @property
    def operational(self) -> bool:
        """True if the slave is in Op, and its data came with the last frame."""


class DriveBus(Protocol):
    """A bus with drives, in the order of their axes."""

    @property
    def slaves(self) -> Sequence[DriveSlave]: ...

    @property
    def drives(self) -> Sequence[Drive]:
        """The virtual drives, if they are in this process."""

    @property
    def trouble(self) -> str:
        """Reason why the bus does not work, empty if it works."""

    def take(self) -> None:
        """Take the inputs that came since the last cycle."""

    def exchange(self) -> None:
        """Send the outputs of one cycle; inputs come at once or with `take`."""

    def absent(self, slave: Any) -> bool:
        """Return True if the bus was searched, and this one of `slaves` does not answer."""

    def on_renewal(self, renewed: Callable[[], None]) -> None:
        """Call `renewed` whenever `slaves` are others: the bus was searched again."""

    def torque_per_acceleration(self, number: int) -> float:
        """‰ for an increment a second² at drive `number`, 0 if unknown."""

    def digest(self) -> bytes:
        """Return the hash of the bus state that belongs to the station's state."""


class AxisBus:
    """The axes that have their drives on one bus."""

    def __init__(
        self, nc: Nc, bus: DriveBus, drives: Mapping[int, DriveConfig], net_id: NetId
    ) -> None:
        """`drives` in the order of the slaves, by axis id; `net_id` is that of the bus.

        Raises ServoError.
        """
        self.bus = bus
        self._nc = nc
        self._drives = dict(drives)
        self._net_id = net_id
        self.servos: Servos
        self._link()
        bus.on_renewal(self._link)
        self.shortcut = KernelCycles(nc, self.servos, bus) if isinstance(bus, EthercatBus) else None

    def _link(self) -> None:
        """Join the axes with the slaves that there are now."""
        nc, bus = self._nc, self.bus
        links = []
        places: list[tuple[DriveSlave, slice, slice]] = []
        read = written = 0
        for number, (axis_id, drive) in enumerate(self._drives.items()):
            slave = bus.slaves[number]
            nc.axis(axis_id).hardware_address = bytes(self._net_id), slave.station, 0
            inputs = _entries(slave.input_entries, read)
            outputs = _entries(slave.output_entries, written)
            homing = drive.homing
            options = servo_options(
                *(drive, nc.cycle_seconds, bus.torque_per_acceleration(number)),
                dead_cycles=_DEAD_CYCLES,
                home_offset=round(homing.offset / drive.scaling) if homing else 0,
                parts=DriveParts.of(drive),
            )
            links.append(ServoLink(axis_id, inputs, outputs, options))
            ends = read + len(slave.inputs), written + len(slave.outputs)
            places.append((slave, slice(read, ends[0]), slice(written, ends[1])))
            read, written = ends
        self.servos = Servos(nc, links, read, written)
        for link in links:
            axis = nc.axis(link.axis_id)
            first_in = min(entry.offset for entry in link.inputs)
            first_out = min(entry.offset for entry in link.outputs)
            axis.encoder.input_address_offset = axis.drive.input_address_offset = first_in
            axis.encoder.output_address_offset = axis.drive.output_address_offset = first_out
        self._places: list[tuple[ServoView, DriveSlave, slice, slice]] = [
            (servo, *place) for servo, place in zip(self.servos.servos, places, strict=True)
        ]
        for _, slave, _, part in self._places:
            self.servos.outputs[part] = slave.outputs

    def at_rest(self) -> bool:
        """Return True if no axis is enabled."""
        return not any(servo.axis.loop_closed for servo in self.servos.servos)

    def missing_condition(self, axis_id: int) -> str:
        """Return the reason why an axis is not ready; empty if it is ready, or is not on this
        bus."""
        for number, (servo, slave, *_) in zip(self._drives, self._places, strict=True):
            if number != axis_id:
                continue
            if not servo.valid:
                why = slave.last_trouble or self.bus.trouble
                state = f"its slave {slave.name} is not in Op"
                return f"{state}: {why}" if why else state
            return servo.missing_condition
        return ""

    def many(self, count: int) -> int:
        """Up to `count` cycles in one go; how many were done."""
        return 0 if self.shortcut is None else self.shortcut.run(count)

    def before(self) -> None:
        self.bus.take()
        servos = self.servos
        image = servos.inputs
        for servo, slave, part, _ in self._places:
            valid = slave.operational
            if valid:
                image[part] = slave.inputs
            absent = not valid and self.bus.absent(slave)
            if servo.valid != valid or servo.absent != absent:
                servos.connect(servo, valid, absent)
        servos.take()

    def after(self) -> None:
        servos = self.servos
        servos.send()
        image = servos.outputs
        for _, slave, _, part in self._places:
            slave.outputs[:] = image[part]
        self.bus.exchange()

    def digest(self) -> bytes:
        """State of the servos and of the bus."""
        return self.servos.digest() + self.bus.digest()


_DEAD_CYCLES = 2.5
"""Without a measurement: a set value acts for a cycle, what it did is read a cycle later."""

_WHOLE_BYTE = 8


def _entries(places: Mapping[tuple[int, int], BusPlace], first: int) -> list[ProcessEntry]:
    """Return the entries of a slave whose data begin at byte `first` of the image."""
    return [
        ProcessEntry(index, first + place.bit // _WHOLE_BYTE, place.bits // _WHOLE_BYTE)
        for (index, subindex), place in places.items()
        if subindex == 0 and place.bit % _WHOLE_BYTE == 0 and place.bits % _WHOLE_BYTE == 0
    ]
