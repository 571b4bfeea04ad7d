"""Whom a fault hits."""

import struct
from typing import Any

import pytest

from achse.ams import AmsAddress, Command
from achse.faults.fault import FaultError
from achse.faults.kinds import STATION_FAULTS
from achse.faults.selection import client_test
from achse.station import Station

NAME = b"MAIN.nCounter\0"


def test_a_fault_of_one_client_spares_the_others(
    sender: Any, station: Station, client: Any
) -> None:
    other = sender(station)
    station.faults.add("drop", client=str(client.address))
    client.send(1)
    other.send(2)
    assert (client.numbers, other.numbers) == ([], [2])


@pytest.mark.parametrize(
    ("client", "fits"),
    [
        ("", True),
        ("10.0.0.7.1.1", True),
        ("10.0.0.7.1.1:30000", True),
        ("10.0.0.7.1.1:30001", False),
        ("10.0.0.8.1.1", False),
        ("192.0.2.1", True),
        ("192.0.2.2", False),
    ],
)
def test_a_client_is_named_by_net_id_address_or_host(client: str, fits: bool) -> None:
    assert client_test(client)(AmsAddress("10.0.0.7.1.1:30000"), "192.0.2.1") is fits


def test_a_client_that_is_no_address_is_refused() -> None:
    with pytest.raises(FaultError, match="client: expected a NetId"):
        client_test("my laptop")


def test_services_are_selected_by_place_port_and_command(station: Station, client: Any) -> None:
    station.faults.add("drop", port=851, command="read", group=0x4020, offset=8)
    client.read(1, 0x4020, 8)
    client.read(2, 0x4020, 12)
    client.read(3, 0x4040, 8)
    client.send(4)
    assert client.numbers == [2, 3, 4]


@pytest.mark.parametrize("way", ["name", "handle", "address", "within"])
def test_a_variable_is_selected_whichever_way_it_is_read(
    station: Station, client: Any, client_of: Any, way: str
) -> None:
    plc = client_of(station.router, 851)
    name = b"GVL.nInt\0"
    handle = int.from_bytes(plc.exchange(0xF003, 0, 4, name), "little")
    group, offset, size = struct.unpack("<III", plc.exchange(0xF007, 0, 12, name))
    station.faults.add("drop", symbol="gvl.nint")
    if way == "name":
        data = struct.pack("<4I", 0xF004, 0, 2, len(name)) + name
        client.send(1, Command.READ_WRITE, data)
    elif way == "handle":
        client.read(1, 0xF005, handle)
    elif way == "address":
        client.read(1, group, offset)
    else:
        client.read(1, group, offset - 2)
    client.read(2, group, offset + size)
    assert client.numbers == [2]


def test_an_unknown_variable_is_reported(station: Station) -> None:
    with pytest.raises(FaultError, match=r"symbol: no device of the station has 'X\.y'"):
        station.faults.add("drop", symbol="X.y")
    with pytest.raises(FaultError, match="port: expected one of the station's devices, got 9"):
        station.faults.add("drop", symbol="X.y", port=9)


def test_samples_are_selected_by_client_and_port(station: Station, client_of: Any) -> None:
    first, second = (client_of(station.router, 851) for _ in range(2))
    for each in (first, second):
        each.subscribe(0x4020, 0, 4, cycle_s=0.01)
        each.samples()
    station.faults.add("drop", command="notification", client=str(first.address), port=851)
    station.advance(0.05)
    assert (len(first.samples()), len(second.samples())) == (0, 5)


def test_codes_and_places_are_reported_in_words() -> None:
    fault = STATION_FAULTS.of({"kind": "error", "code": 0x4221, "group": 0x4020, "offset": 8})
    assert str(fault) == "error group=0x4020 offset=0x8 code=0x4221 (SET_VELOCITY_NOT_ALLOWED)"
