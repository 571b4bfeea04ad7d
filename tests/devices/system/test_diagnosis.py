"""IPC diagnosis: values by address, and addresses that a station knows nothing of."""

import pytest

from achse.ams import DeviceError, NetId
from achse.devices.system import SystemDevice
from achse.devices.system.device import VERSION
from achse.router import Router
from achse.router.routes import Route, RouteTable
from achse.testing import ManualClock

NAME, COUNT = 0x1008_0000, 0xF020_0000


@pytest.fixture
def device() -> SystemDevice:
    routes = RouteTable()
    routes.add(Route(name="north", net_id=NetId("1.2.3.4.1.1"), host="10.0.0.1"))
    result = SystemDevice(clock=ManualClock(), name="Press", routes=routes)
    result.attach(Router(NetId("5.6.7.8.1.1")), 10_000)
    return result


def read(device: SystemDevice, offset: int) -> bytes:
    return device.read(0xF302, offset, 256)


def test_every_module_of_the_list_has_values(device: SystemDevice) -> None:
    assert read(device, NAME) == b"Press\0"
    count = int.from_bytes(read(device, COUNT), "little")
    modules = [int.from_bytes(read(device, COUNT + n), "little") for n in range(1, count + 1)]
    assert [each >> 16 for each in modules] == [8, 11, 24, 3]
    assert [each & 0xFFFF for each in modules] == [1, 2, 3, 4]
    assert int.from_bytes(read(device, 0x8011_0003), "little") == VERSION[2]
    assert read(device, 0x8011_0004) == b"5.6.7.8.1.1\0"
    assert read(device, 0x8011_0006) == b"\5\0"
    assert read(device, 0x8020_0003) != b"\0"
    assert read(device, 0x8030_0003) != b"\0"
    assert len(read(device, 0x8041_0003)) == 4


def test_routes(device: SystemDevice) -> None:
    assert read(device, 0x8012_0000) == b"\1\0"
    assert read(device, 0x8012_0001) == b"north\0"
    assert read(device, 0x8013_0001) == b"10.0.0.1\0"
    assert read(device, 0x8014_0001) == b"1.2.3.4.1.1\0"


@pytest.mark.parametrize(
    "offset", [0, COUNT + 5, 0x8012_0002, 0x8013_0000, 0x8021_0002, 0x8051_0001, 0xFFFF_FFFF]
)
def test_what_a_station_does_not_know(device: SystemDevice, offset: int) -> None:
    with pytest.raises(DeviceError) as refusal:
        read(device, offset)
    assert refusal.value.code == 0x703


def test_nothing_is_written(device: SystemDevice) -> None:
    with pytest.raises(DeviceError):
        device.write(0xF302, NAME, b"x\0")
