"""Licence server, port 30: functions of achse under ids of our own."""

import struct
import uuid
from collections.abc import Callable
from typing import Any

from achse.ams import NetId
from achse.devices.licence import LICENCE_PORT, LicenceDevice
from achse.router import Router

PLATFORM, MODULES, NAME, ORDER_NUMBER = 0x0101_0004, 0x0101_0006, 0x0101_000C, 0x0101_000D


def _client(client_of: Callable[..., Any], net_id: str = "5.1.2.3.1.1", name: str = "a") -> Any:
    router = Router(NetId(net_id))
    LicenceDevice(name, clock=lambda: 0).attach(router, LICENCE_PORT)
    return client_of(router, LICENCE_PORT)


def test_each_licence_has_name_and_order_number(client_of: Callable[..., Any]) -> None:
    client = _client(client_of)
    (count,) = struct.unpack("<I", client.read(MODULES, 0, 4))
    data = client.read(MODULES, 0, 48 * count)
    assert len(data) == 48 * count
    numbers = set()
    for start in range(0, len(data), 48):
        identity = data[start : start + 16]
        assert data[start + 16 : start + 48] == bytes(32)  # no end, not counted, valid
        number = client.exchange(ORDER_NUMBER, 0, 16, identity)
        assert client.exchange(NAME, 0, 64, identity).startswith(b"achse ")
        assert number.endswith(b"\0")
        numbers.add(number)
    assert numbers == {b"achse-ADS\0", b"achse-NC\0", b"achse-PLC\0"}


def test_system_id_is_one_of_name_and_net_id(client_of: Callable[..., Any]) -> None:
    ids = [
        client.read(PLATFORM, 1, 16)
        for client in (
            _client(client_of),
            _client(client_of),
            _client(client_of, name="b"),
            _client(client_of, net_id="5.1.2.4.1.1"),
        )
    ]
    assert uuid.UUID(bytes_le=ids[0]).version == 5
    assert ids[0] == ids[1]
    assert len(set(ids)) == 3


def test_platform_and_volume_are_none(client_of: Callable[..., Any]) -> None:
    client = _client(client_of)
    assert client.get(PLATFORM, 2, "<H") == 0
    assert client.get(PLATFORM, 5, "<I") == 0


def test_unknown_licence_is_refused(client_of: Callable[..., Any], refused: Any) -> None:
    client = _client(client_of)
    for data in (b"", bytes(16), bytes(17)):
        with refused(0x724):
            client.exchange(NAME, 0, 64, data)
