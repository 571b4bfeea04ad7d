"""Memory areas by index group."""

import struct

import pytest

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.plc import PlcDevice
from achse.devices.plc.areas import area_groups
from achse.native.memory import MemoryCell
from achse.plc import Area, Memory, PlcRuntime
from achse.server import ServiceTable


@pytest.mark.parametrize(
    ("group", "area"),
    [
        (0x4020, Area.FLAG),
        (0x4030, Area.RETAIN),
        (0x4040, Area.DATA),
        (0xF020, Area.INPUT),
        (0xF030, Area.OUTPUT),
    ],
)
def test_an_area_is_read_and_written_by_byte_offset(
    device: PlcDevice, plc: PlcRuntime, group: int, area: Area
) -> None:
    device.write(group, 1, b"\x11\x22")
    assert plc.memory[area].read(1, 2) == b"\x11\x22"
    plc.memory[area].write(2, b"\x33")
    assert device.read(group, 1, 2) == b"\x11\x33"


@pytest.mark.parametrize(
    ("group", "area"),
    [
        (0x4021, Area.FLAG),
        (0x4031, Area.RETAIN),
        (0x4041, Area.DATA),
        (0xF021, Area.INPUT),
        (0xF031, Area.OUTPUT),
    ],
)
def test_a_bit_is_one_byte_at_eight_times_the_offset(
    device: PlcDevice, plc: PlcRuntime, group: int, area: Area
) -> None:
    plc.memory[area].write(1, b"\x00")
    device.write(group, 8 + 3, b"\x01")
    assert plc.memory[area].read(1, 1) == b"\x08"
    assert device.read(group, 8 + 2, 3) == b"\x00\x01\x00"


@pytest.mark.parametrize(
    ("group", "bits", "base"), [(0xF020, 0xF021, 0x1_F400), (0xF030, 0xF031, 0x3_E800)]
)
def test_the_process_image_answers_at_both_bases(
    device: PlcDevice, group: int, bits: int, base: int
) -> None:
    device.write(group, base + 5, b"\x80")
    assert device.read(group, 5, 1) == b"\x80"
    assert device.read(bits, base * 8 + 5 * 8 + 7, 1) == b"\x01"
    device.write(bits, base * 8 + 5 * 8 + 7, b"\x00")
    assert device.read(group, base + 5, 1) == b"\x00"


def test_an_image_that_reaches_the_base_is_counted_from_0_only() -> None:
    memory = Memory({Area.INPUT: 0x2_0000})
    table = ServiceTable(area_groups(memory))
    table.find(0xF020).write(0xF020, 0x1_F400, b"\x01", b"")
    assert memory[Area.INPUT].read(0x1_F400, 1) == b"\x01"
    assert memory[Area.INPUT].read(0, 1) == b"\x00"


def test_sizes_of_all_areas(device: PlcDevice, plc: PlcRuntime) -> None:
    sizes = [
        struct.unpack("<I", device.read(group, 0, 4))[0]
        for group in (0x4025, 0x4035, 0x4045, 0xF025, 0xF035)
    ]
    assert sizes == [0x1_0000, 0x1_0000, len(plc.memory[Area.DATA]), 128, 0x1_0000]


@pytest.mark.parametrize(("group", "area"), [(0xF040, Area.INPUT), (0xF050, Area.OUTPUT)])
@pytest.mark.parametrize("data", [b"", b"\x01\x00"])
def test_clearing_zeroes_an_image(
    device: PlcDevice, plc: PlcRuntime, group: int, area: Area, data: bytes
) -> None:
    plc.memory[area].write(7, b"\xff")
    device.write(group, 0, data)
    assert not any(plc.memory[area].data)


@pytest.mark.parametrize(
    ("group", "offset", "length", "code"),
    [
        (0x4020, 0x1_0000, 1, ReturnCode.INVALID_OFFSET),
        (0x4020, 0xFFFF_FFFF, 4, ReturnCode.INVALID_OFFSET),
        (0x4020, 0xFFFF, 2, ReturnCode.INVALID_SIZE),
        (0x4020, 0, 0xFFFF_FFFF, ReturnCode.INVALID_SIZE),
        (0x4021, 0x8_0000, 1, ReturnCode.INVALID_OFFSET),
        (0x4021, 0x7_FFFF, 2, ReturnCode.INVALID_SIZE),
        (0xF020, 128, 1, ReturnCode.INVALID_OFFSET),
        (0xF020, 0x1_F400 + 127, 2, ReturnCode.INVALID_SIZE),
        (0x4025, 0x1_0000, 4, ReturnCode.INVALID_OFFSET),
    ],
)
def test_an_access_beyond_the_area_is_refused(
    device: PlcDevice, group: int, offset: int, length: int, code: ReturnCode
) -> None:
    with pytest.raises(DeviceError) as refusal:
        device.read(group, offset, length)
    assert refusal.value.return_code is code


def test_a_write_across_the_end_changes_nothing(device: PlcDevice, plc: PlcRuntime) -> None:
    with pytest.raises(DeviceError) as refusal:
        device.write(0xF020, 126, b"\x01\x02\x03")
    assert refusal.value.return_code is ReturnCode.INVALID_SIZE
    with pytest.raises(DeviceError):
        device.write(0xF021, 127 * 8 + 7, b"\x01\x01")
    assert plc.memory[Area.INPUT].read(126, 2) == b"\0\0"


def test_sizes_cannot_be_written_and_clearing_cannot_be_read(device: PlcDevice) -> None:
    with pytest.raises(DeviceError) as refusal:
        device.write(0x4025, 0, b"\0\0\0\0")
    assert refusal.value.return_code is ReturnCode.INVALID_ACCESS
    with pytest.raises(DeviceError) as refusal:
        device.read(0xF040, 0, 1)
    assert refusal.value.return_code is ReturnCode.INVALID_ACCESS


@pytest.mark.parametrize(
    ("group", "offset"),
    [(0x4020, 3), (0x4040, 3), (0xF020, 3), (0xF020, 0x1_F400 + 3), (0xF030, 0x3_E800 + 3)],
)
def test_what_is_watched_lies_in_memory_and_follows_it(
    device: PlcDevice, plc: PlcRuntime, group: int, offset: int
) -> None:
    read = device.services.find(group).reader(group, offset, 2, bytes(8))
    assert isinstance(read, MemoryCell)
    assert read() == device.read(group, 3, 2)
    device.write(group, 3, b"\x44\x55")
    plc.memory[Area.DATA].place(len(plc.memory[Area.DATA]), 8)  # longer now, and still the same
    assert read() == b"\x44\x55"


def test_what_lies_outside_cannot_be_watched(device: PlcDevice) -> None:
    with pytest.raises(DeviceError, match="0x703"):
        device.services.find(0x4020).reader(0x4020, 1 << 30, 2, bytes(8))


@pytest.mark.parametrize("group", [0x4020, 0x4021, 0x4030, 0x4040, 0xF020, 0xF021, 0xF030, 0xF031])
def test_a_write_without_data_changes_nothing(device: PlcDevice, group: int) -> None:
    """AdsLibTest of the vendor sends one to 0x4020."""
    before = device.read(group, 1, 1)
    device.write(group, 1, b"")
    assert device.read(group, 1, 1) == before
