"""Errors on a symbol or service, whichever way it is read."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.client import connect
from achse.station import Station

NAME = b"MAIN.nCounter\0"


def test_an_error_on_a_symbol_meets_name_handle_address_and_sums(
    station: Station, client_of: Any
) -> None:
    plc = client_of(station.router, 851)
    (handle,) = struct.unpack("<I", plc.exchange(0xF003, 0, 4, NAME))
    group, offset, size = struct.unpack("<III", plc.exchange(0xF007, 0, 12, NAME))
    station.faults.add("error", symbol="main.ncounter", code=0x706)
    asks: dict[str, Callable[[], Any]] = {
        "name": lambda: plc.exchange(0xF004, 0, 4, NAME),
        "handle": lambda: plc.read(0xF005, handle, 4),
        "address": lambda: plc.read(group, offset, size),
        "within": lambda: plc.read(group, offset - 8, 16),
        "write": lambda: plc.write(0xF005, handle, bytes(4)),
        "watch": lambda: plc.subscribe(0xF005, handle, 4),
    }
    for what, ask in asks.items():
        with pytest.raises(DeviceError) as refusal:
            ask()
        assert (what, refusal.value.code) == (what, 0x706)
    parts = struct.pack("<6I", 0xF005, handle, 4, 0x4020, 0, 4)
    assert plc.exchange(0xF080, 2, 16, parts) == struct.pack("<4I", 0x706, 0, 0, 0)
    assert len(plc.read(group, offset + size, 4)) == 4
    station.faults.clear()
    assert len(plc.read(0xF005, handle, 4)) == 4


def test_an_error_on_a_service_that_the_device_does_not_have(
    station: Station, client_of: Any, refused: Any
) -> None:
    plc = client_of(station.router, 851)
    station.faults.add("error", port=851, group=0x1234, code=0x70A, count=1)
    with refused(0x70A):
        plc.read(0x1234, 0, 4)
    with refused(0x701):
        plc.read(0x1234, 0, 4)


async def test_an_error_on_a_symbol_selects_clients_by_the_host_they_are_at() -> None:
    station = Station.demo()
    station.faults.add("error", symbol="GVL.nInt", client="127.0.0.1", code=0x706, count=1)
    station.faults.add("error", symbol="GVL.nInt", client="127.0.0.9", code=0x707)
    async with (
        station.running("127.0.0.1", 0, speed=0) as running,
        connect(f"127.0.0.1:{running.tcp_port}", watch_symbols=False) as plc,
    ):
        with pytest.raises(DeviceError, match="0x706"):
            await plc.read("GVL.nInt")
        assert await plc.read("GVL.nInt") == -16
