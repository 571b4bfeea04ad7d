"""System service, port 10000: state block, device info, Write Control."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import AdsState, Command
from achse.ams.commands import EmptyRequest, WriteControlRequest
from achse.devices.system import SystemDevice
from achse.router import Router


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


@pytest.mark.parametrize("group", [110, 600, 701, 808, 1200])
def test_what_reaches_into_an_operating_system_is_not_supported(
    client: Any, refused: Any, group: int
) -> None:
    with refused(0x701):
        client.read(group, 0, 4)
    with refused(0x701):
        client.write(group, 1, b"x")
    with refused(0x701):
        client.exchange(group, 0, 4, b"x")


def _write_control(client: Any, state: int, device_state: int = 1, data: bytes = b"") -> None:
    client.ask(Command.WRITE_CONTROL, WriteControlRequest(state, device_state, data))


@pytest.mark.parametrize(
    ("state", "device_state", "data", "requested"),
    [
        (AdsState.RESET, 1, b"", ("restart",)),
        (AdsState.RESET, 0, bytes(10_240), ("restart",)),
        (AdsState.RECONFIG, 1, b"", ("configure",)),
        (AdsState.CONFIG, 1, b"", ("configure",)),
        (AdsState.SHUTDOWN, 0, b"\x05\0\0\0", ("shut down", 5, False)),
        (AdsState.SHUTDOWN, 1, b"", ("shut down", 0, True)),
    ],
)
def test_states_that_the_station_obeys(
    client: Any,
    control: Any,
    state: int,
    device_state: int,
    data: bytes,
    requested: tuple[Any, ...],
) -> None:
    _write_control(client, state, device_state, data)
    assert control.requests == [requested]


@pytest.mark.parametrize(
    ("state", "device_state", "data", "code"),
    [
        (0, 0, b"", 0x701),
        (20, 0, b"", 0x701),
        (AdsState.STOP, 0, b"", 0x712),
        (AdsState.SHUTDOWN, 0, b"\x05", 0x705),
        (AdsState.SHUTDOWN, 2, b"", 0x706),
        (AdsState.SHUTDOWN, 0, b"\xff\xff\xff\xff", 0x706),
    ],
)
def test_states_that_it_refuses(
    client: Any, control: Any, refused: Any, state: int, device_state: int, data: bytes, code: int
) -> None:
    with refused(code):
        _write_control(client, state, device_state, data)
    assert control.requests == []


def test_without_a_station_nothing_is_obeyed(
    router: Router, client_of: Callable[..., Any], refused: Any
) -> None:
    SystemDevice(clock=lambda: 0).attach(router, 10_000)
    with refused(0x712):
        _write_control(client_of(router, 10_000), AdsState.RESET)
