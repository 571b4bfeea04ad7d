"""Rows with their behaviour: each of the table is served, where values lie in the record."""

import math
import random
import struct
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.codes.nc.table import every_row, named_rows
from achse.devices.nc import NcDevice
from achse.devices.nc.axes.states import AXIS_STATES
from achse.devices.nc.channels import CHANNEL_GROUPS
from achse.devices.nc.device import AXIS_GROUPS, GROUPS, RING0_GROUPS
from achse.devices.nc.layouts import INT32
from achse.devices.nc.rows import shown
from achse.devices.nc.tables.services import TABLE_GROUPS
from achse.motion import AxisParameters, Nc
from achse.motion.axis import Axis
from achse.motion.record import FIELDS
from achse.native.memory import AttributeCell, ComputedCell, MemoryCell
from achse.router import Router
from achse.server import READ, WRITE, Service

MS = 1_000_000
ROWS = [row for row in AXIS_STATES if READ in row.access]


class Client:
    def __init__(self) -> None:
        self.stream: list[bytes] = []

    def deliver(self, frame: Frame) -> bool:
        self.stream.append(frame.data)
        return True


def stream(compiled: bool, seed: int) -> list[bytes]:
    """All answers and notifications of two moving axes, 40 subscriptions by `seed`."""
    chance = random.Random(seed)
    now = 0
    nc = Nc(2 * MS, [AxisParameters(1), AxisParameters(2)], compiled=compiled)
    device = NcDevice(nc, clock=lambda: now)
    router, client = Router(NetId("5.1.2.3.1.1")), Client()
    target, me = AmsAddress(device.attach(router, 501)), router.register(0, client)

    def ask(command: Command, data: bytes) -> None:
        frame = Frame(target, me, command, 4, 0, 1, data)
        frame.origin = client
        router.deliver(frame)

    for axis in (1, 2):
        device.write(0x4300 + axis, 0x01, struct.pack("<I", 7))
        device.write(0x4300 + axis, 0x21, struct.pack("<I", 1_000_000))
    for _ in range(40):
        row = chance.choice(ROWS)
        length = chance.choice((2, 4, 8, 16))
        mode, delay, cycle = chance.choice((3, 4)), chance.choice((0, 7)), chance.choice((2, 4))
        body = ADD_NOTIFICATION_BODY.pack(
            0x4100 + chance.choice((1, 2)), row.offset, length, mode, delay * 10_000, cycle * 10_000
        )
        ask(Command.ADD_NOTIFICATION, body)
    for cycle in range(60):
        if cycle == 10:
            device.write(0x4201, 0x20, struct.pack("<I4xdd", 3, 0.0, 100.0))
        if cycle == 30:
            ask(Command.DELETE_NOTIFICATION, struct.pack("<I", chance.randrange(1, 30)))
            device.write(0x4301, 0x21, struct.pack("<I", 500_000))
        now += 2 * MS
        nc.cycle()
        device.notifications.tick(now)
    return client.stream


def served() -> dict[tuple[int, int, str], Service]:
    groups = [
        *RING0_GROUPS,
        *CHANNEL_GROUPS,
        *GROUPS,
        *((base, services) for base, services, _ in AXIS_GROUPS),
        *TABLE_GROUPS,
    ]
    return {
        (base, service.offset, str(service.access)): service
        for base, services in groups
        for service in services
    }


def test_each_row_is_served_as_it_says() -> None:
    services = served()
    for base, row in every_row():
        service = services.pop((base, row.offset, row.access))
        assert (service.name, service.unit) == (row.name, row.unit)
        assert (service.count, service.symbol) == (row.offsets, row.symbol)
        assert (service.element is not None) == row.per_element, row.name
        if row.access != "R":
            assert (service.minimum, service.maximum) == (row.least, row.most), row.name
    assert services == {}


def test_units_and_ranges_of_the_record_are_those_of_the_rows() -> None:
    """What a station's file may say of a parameter is what a client may write."""
    seen = 0
    for base, services, _ in AXIS_GROUPS:
        prefix = {5: "encoder_", 6: "controller_", 7: "drive_"}.get(base >> 12, "")
        for service in services:
            name = service.field if service.field in FIELDS else prefix + service.name
            field = FIELDS.get(name)
            if field is None or WRITE not in service.access or service.choices:
                continue
            least, most = service.minimum, service.maximum
            narrow = name == "velocity_override"  # the record keeps 200 %, 100 % may be written
            assert field.least == (-math.inf if least is None else least), name
            assert narrow or field.most == (math.inf if most is None else most), name
            assert field.unit in (service.unit, "0/1", "bits"), name
            seen += 1
    assert seen > 150


def test_row_without_a_field_is_an_error() -> None:
    with pytest.raises(ValueError, match="no such field"):
        shown(named_rows(0x4000)["axis_id"]._replace(name="nowhere"))


@pytest.mark.parametrize("seed", range(4))
def test_values_taken_from_memory_make_the_stream_of_those_read_one_by_one(seed: int) -> None:
    pytest.importorskip("llvmlite")
    assert stream(compiled=True, seed=seed) == stream(compiled=False, seed=seed)


def test_values_that_lie_in_memory_as_they_are_shown_have_a_place() -> None:
    pytest.importorskip("llvmlite")
    axis = Nc(2 * MS, [AxisParameters(1)], compiled=True).axis(1)
    axis.remaining_time, axis.remaining_distance = 1.5, 2.5
    axis.encoder.hardware_increments = -3
    read = {row.name: row.sample and row.sample(_subject(row, axis), 16) for row in ROWS}
    both, count = read["remaining_time_and_distance"], read["encoder_hardware_increments"]
    assert isinstance(both, MemoryCell)
    assert isinstance(count, MemoryCell)
    assert both() == struct.pack("<dd", 1.5, 2.5)
    assert count() == INT32.encode(-3)
    assert isinstance(read["set_velocity_override"], ComputedCell)
    assert read["axis_online_structure"] is None


def test_values_of_plain_records_are_attributes() -> None:
    axis = Nc(2 * MS, [AxisParameters(1)], compiled=False).axis(1)
    axis.encoder.hardware_increments = -3
    read = {row.name: row.sample(_subject(row, axis), 8) for row in ROWS if row.sample}
    count = read["encoder_hardware_increments"]
    assert isinstance(count, AttributeCell)
    assert count() == INT32.encode(-3)
    assert read["set_velocity_override"] is None
    assert {type(cell) for cell in read.values()} == {AttributeCell, type(None)}
    for row in ROWS:
        if row.sample and (cell := read[row.name]) is not None and row.count == 1:
            subject = _subject(row, axis)
            assert cell() == row.encoder(8)(row.get(subject))[:8], row.name


def _subject(row: Any, axis: Axis) -> Any:
    """The axis, or its ratio to its first master."""
    return row.element(axis, 0) if row.name == "set_gear_ratio" else axis
