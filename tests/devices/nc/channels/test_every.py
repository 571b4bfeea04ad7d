"""The channel of all PTP groups over ADS."""

import struct
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.nc import NcDevice
from achse.motion import Nc
from achse.router import Router


def test_a_client_walks_from_the_channel_to_every_axis(bench: Any) -> None:
    [channel] = struct.unpack("<I", bench.read(0x1100, 0x31, 1020))
    parameters, states = 0x2000 + channel, 0x2100 + channel
    assert bench.get(parameters, 0x01, "<I") == channel
    assert bench.read(parameters, 0x02, 31) == b"Axes".ljust(31, b"\0")
    assert (bench.get(parameters, 0x03, "<I"), bench.get(parameters, 0x04, "<I")) == (1, 0)
    assert bench.get(parameters, 0x21, "<I") == 1
    assert bench.get(states, 0x01, "<i") == 0
    groups = struct.unpack("<II", bench.read(0x1100, 0x32, 1020))
    assert bench.get(states, 0x02, "<I") == len(groups)
    axes = struct.unpack("<II", bench.read(states, 0x100, 1020))
    for place, (group, axis) in enumerate(zip(groups, axes, strict=True), 1):
        assert bench.get(0x3000 + group, 0x21, "<I") == bench.get(0x4000 + axis, 0x51, "<I") == 1
        assert bench.get(0x3000 + group, 0x24, "<I") == place
        assert bench.get(0x4000 + axis, 0x54, "<I") == group


def test_stop_and_reset_are_for_all_axes(bench: Any) -> None:
    for axis in (1, 3):
        bench.start(0.0, 50.0, 3, axis)
    bench.run(0.5)
    bench.write(0x2201, 0x11)
    bench.until(lambda: not any(axis.set_velocity for axis in bench.nc))
    for axis in (1, 3):
        bench.put(0x4200 + axis, 0x19, "<I", 0x4650)
    bench.run(0.1)
    assert all(axis.error_code for axis in bench.nc)
    bench.write(0x2201, 0x10)
    bench.run(0.1)
    assert not any(axis.error_code for axis in bench.nc)


@pytest.mark.parametrize("channel", [0, 2, 255])
def test_an_id_that_no_channel_has(bench: Any, refused: Any, channel: int) -> None:
    for group in (0x2000, 0x2100, 0x2300):
        with refused(0x4010):
            bench.read(group + channel, 0x01, 4)
    with refused(0x4010):
        bench.write(0x2200 + channel, 0x11)


def test_an_nc_without_axes_has_no_channel(client_of: Any, refused: Any) -> None:
    router = Router(NetId("5.1.2.3.1.1"))
    NcDevice(Nc(2_000_000, [], compiled=False), clock=lambda: 0).attach(router, 501)
    client = client_of(router, 501)
    assert client.get(0x1100, 0x01, "<I") == client.get(0x1100, 0x02, "<I") == 0
    assert client.read(0x1100, 0x31, 1020) == client.read(0x1100, 0x32, 1020) == b""
    with refused(0x4010):
        client.read(0x2001, 0x01, 4)
