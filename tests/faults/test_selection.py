"""Whom a fault hits."""

from typing import Any

import pytest

from achse.ams import AmsAddress
from achse.faults.fault import FaultError
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
