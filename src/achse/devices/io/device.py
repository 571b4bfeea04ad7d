"""The I/O server, port 300: the buses of a station, their names, addresses and boxes.

Numbers of group 0x5000 that clients are known to use are theirs; those that only PLC libraries
name (name → id, boxes, reset, combined list) are ours, as nothing public prints them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar

from achse.ams import AdsState, DeviceError
from achse.ams.text import terminated_text
from achse.codes import ReturnCode
from achse.devices.io.groups import IoGroup
from achse.devices.io.served import ServedBus
from achse.ethercat.master import BusSlave
from achse.server import (
    BYTES,
    READ,
    READ_WRITE,
    WRITE,
    Device,
    Group,
    IndexGroup,
    Layout,
    ObjectGroup,
    Service,
)

IO_PORT = 300
"""The AMS port of the I/O server."""

_U16, _U32 = Layout("<H"), Layout("<I")
_LAST_ID = 0xFE


class IoDevice(Device):
    """Answers for all buses."""

    accepted_states: ClassVar[Mapping[int, AdsState]] = dict.fromkeys(
        (AdsState.RUN, AdsState.RESET), AdsState.RUN
    )

    def __init__(self, buses: Sequence[ServedBus], *, clock: Callable[[], int]) -> None:
        self.buses = tuple(buses)
        super().__init__("TwinCAT IO", (3, 1, 0), self._own_groups(), clock=clock)

    def _own_groups(self) -> Iterator[IndexGroup]:
        yield Group(IoGroup.DEVICES, IO_ROWS, self)
        yield ObjectGroup(IoGroup.DEVICES + 1, _LAST_ID, self._bus, BUS_ROWS)

    def _bus(self, place: int) -> ServedBus:
        for bus in self.buses:
            if bus.number == place + 1:
                return bus
        raise DeviceError(ReturnCode.NOT_FOUND, f"no I/O device {place + 1}")

    def by_name(self, name: bytes) -> ServedBus:
        """Return the bus of a name; upper and lower case count."""
        wanted = terminated_text(name)
        for bus in self.buses:
            if bus.name == wanted:
                return bus
        raise DeviceError(ReturnCode.NOT_FOUND, f"no I/O device {wanted!r}")


def _text(text: str) -> bytes:
    return text.encode("cp1252", "replace") + b"\0"


def _ids(device: IoDevice) -> bytes:
    numbers = [len(device.buses), *(bus.number for bus in device.buses)]
    return b"".join(each.to_bytes(2, "little") for each in numbers)


def _box(bus: ServedBus, name: bytes) -> BusSlave:
    wanted = terminated_text(name)
    for slave in bus.master.slaves:
        if slave.name == wanted:
            return slave
    raise DeviceError(ReturnCode.NOT_FOUND, f"{bus.name} has no box {wanted!r}")


def _box_at(bus: ServedBus, station: int) -> BusSlave:
    slave = bus.master.slave(station)
    if slave is None:
        raise DeviceError(ReturnCode.NOT_FOUND, f"{bus.name} has no box at {station}")
    return slave


def _box_net_id(bus: ServedBus, slave: BusSlave) -> bytes:
    return bytes(bus.slave_net_id(slave) or bus.net_id)


def _reset(bus: ServedBus, data: bytes) -> None:
    """Request Init of all slaves; they return to the state that was requested of them."""
    for slave in bus.master.slaves:
        bus.master.restart(slave)


IO_ROWS = (
    Service(1, "device ids", READ, BYTES, "UINT each: how many, then the ids", read=_ids),
    Service(2, "device count", READ, _U32, "I/O devices", read=lambda device: len(device.buses)),
    Service(
        3,
        "device id by name",
        READ_WRITE,
        BYTES,
        "Name to id; offset ours",
        exchange=lambda device, name: device.by_name(name).number,
        response=_U32,
        source="achse",
    ),
    Service(
        10,
        "device information",
        READ,
        BYTES,
        "All devices with their boxes, packed; offset ours",
        read=lambda device: b"".join(bus.information() for bus in device.buses),
        source="achse",
    ),
)

BUS_ROWS = (
    Service(1, "device name", READ, BYTES, "Text", read=lambda bus: _text(bus.name)),
    Service(
        3,
        "box count",
        READ,
        _U32,
        "Boxes on line; offset ours",
        read=lambda bus: sum(slave.present for slave in bus.master.slaves),
        source="achse",
    ),
    Service(
        4,
        "box address by name",
        READ_WRITE,
        BYTES,
        "Name to station address; offset ours",
        exchange=lambda bus, name: _box(bus, name).station,
        response=_U16,
        source="achse",
    ),
    Service(5, "NetId", READ, BYTES, "6 bytes", read=lambda bus: bytes(bus.net_id)),
    Service(
        6,
        "box name by address",
        READ_WRITE,
        _U16,
        "Station address to name; offset ours",
        exchange=lambda bus, station: _text(_box_at(bus, station).name),
        response=BYTES,
        source="achse",
    ),
    Service(7, "device type", READ, _U16, "111: EtherCAT master", read=lambda bus: bus.device_type),
    Service(
        8,
        "box NetId",
        READ_WRITE,
        _U16,
        "Station address to the NetId of the box: its own if it speaks AoE, else that of the bus;"
        " offset ours",
        exchange=lambda bus, station: _box_net_id(bus, _box_at(bus, station)),
        response=BYTES,
        source="achse",
    ),
    Service(
        9,
        "reset",
        WRITE,
        BYTES,
        "All slaves go through Init again; offset ours",
        write=_reset,
        source="achse",
    ),
    Service(
        10,
        "device information",
        READ,
        BYTES,
        "This device with its boxes, packed; offset ours",
        read=lambda bus: bus.information(),
        source="achse",
    ),
)
