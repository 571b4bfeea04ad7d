"""System service, port 10000: state block, device info."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import Command, NetId
from achse.ams.commands import EmptyRequest
from achse.devices.system import SystemDevice
from achse.router import Router


@pytest.fixture
def device() -> SystemDevice:
    return SystemDevice(clock=lambda: 0)


@pytest.fixture
def client(device: SystemDevice, client_of: Callable[..., Any]) -> Any:
    router = Router(NetId("5.1.2.3.1.1"))
    device.attach(router, 10_000)
    return client_of(router, 10_000)


def test_the_state_block_is_that_of_a_real_target(device: SystemDevice, client: Any) -> None:
    device.restart_index = 4
    assert client.read(0xF0, 0, 16).hex(" ", 2) == "0500 0100 0400 0301 b80f 0100 0000 0000"
    assert client.read(0xF0, 0, 6) == bytes.fromhex("050001000400")


def test_the_restart_index_wraps(device: SystemDevice, client: Any) -> None:
    device.restart_index = 0x1_0001
    assert client.get(0xF0, 0, "<HHH") == (5, 1, 1)


def test_device_info_is_that_of_a_real_target(client: Any) -> None:
    info = client.ask(Command.READ_DEVICE_INFO, EmptyRequest())
    assert (info.name, info.major, info.minor, info.build) == ("TwinCAT System", 3, 1, 4024)


def test_state(client: Any) -> None:
    state = client.ask(Command.READ_STATE, EmptyRequest())
    assert (state.ads_state, state.device_state) == (5, 1)
    assert client.get(0xF100, 0, "<HH") == (5, 1)


def test_what_is_not_there(client: Any, refused: Any) -> None:
    with refused(0x702):
        client.read(0xF1, 0, 4)
    with refused(0x703):
        client.read(0xF0, 1, 16)
    with refused(0x704):
        client.write(0xF0, 0, bytes(16))
