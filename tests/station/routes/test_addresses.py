"""Addresses of a station: the NetId it gets from one, and who reaches it."""

import ipaddress
from pathlib import Path
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import NetId
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.routes.addresses import is_reachable_from_outside, net_id_at
from achse.transport import own_address

LOOPBACK = NetId("127.0.0.1.1.1")
EVERYWHERE = ["0.0.0.0", "::", ""]


@given(st.ip_addresses())
def test_net_id_is_the_address_with_1_1(
    address: "ipaddress.IPv4Address | ipaddress.IPv6Address",
) -> None:
    if address.is_unspecified:
        return
    net_id = net_id_at(str(address))
    expected = LOOPBACK if address.is_loopback else address.packed[-4:] + b"\1\1"
    assert net_id == expected


@pytest.mark.parametrize("host", ["127.0.0.1", "127.9.8.7", "::1", "localhost"])
def test_station_on_loopback_keeps_the_loopback_net_id(host: str) -> None:
    assert net_id_at(host) == LOOPBACK


@pytest.mark.parametrize("host", EVERYWHERE)
def test_station_on_all_addresses_has_that_of_its_default_route(host: str) -> None:
    with mock.patch.object(own_address, "_routed_address", return_value="192.168.7.20"):
        assert str(net_id_at(host)) == "192.168.7.20.1.1"


@pytest.mark.parametrize("host", EVERYWHERE)
@pytest.mark.parametrize(("known", "message"), [("10.0.0.7", "10.0.0.7.1.1"), ("", str(LOOPBACK))])
def test_station_without_default_route_has_that_of_an_interface(
    host: str, known: str, message: str
) -> None:
    with (
        mock.patch.object(own_address, "_routed_address", return_value=""),
        mock.patch.object(own_address, "_interface_address", return_value=known),
        mock.patch.object(own_address, "_named_address", return_value=""),
    ):
        assert str(net_id_at(host)) == message


def test_host_name_counts_by_its_address() -> None:
    with mock.patch("socket.gethostbyname", return_value="10.0.0.9"):
        assert str(net_id_at("press.plant")) == "10.0.0.9.1.1"
    with mock.patch("socket.gethostbyname", side_effect=OSError("unknown")):
        assert net_id_at("press.plant") == LOOPBACK


def test_configured_net_id_precedes_that_of_the_host(tmp_path: Path) -> None:
    router = {"net_id": "5.6.7.8.1.1", "host": "192.168.7.20"}
    assert str(Station(parse({"router": router}, "a.toml")).router.net_id) == "5.6.7.8.1.1"
    del router["net_id"]
    assert str(Station(parse({"router": router}, "a.toml")).router.net_id) == "192.168.7.20.1.1"
    assert Station().router.net_id == LOOPBACK
    file = tmp_path / "station.toml"
    file.write_text('[router]\nhost = "127.0.0.1"\n')
    assert Station.load(file).router.net_id == LOOPBACK
    assert str(Station.load(file, host="192.168.7.21").router.net_id) == "192.168.7.21.1.1"


@pytest.mark.parametrize(
    ("host", "reachable"),
    [
        ("127.0.0.1", False),
        ("127.9.8.7", False),
        ("::1", False),
        ("localhost", False),
        ("0.0.0.0", True),
        ("::", True),
        ("", True),
        ("192.0.2.1", True),
        ("fe80::1%1", True),
    ],
)
async def test_which_addresses_other_computers_reach(host: str, reachable: bool) -> None:
    assert await is_reachable_from_outside(host) is reachable


async def test_an_address_of_another_computer_is_refused() -> None:
    """It read as if the address were this computer's and open to everybody."""
    serving = Station.demo().running(host="192.0.2.1", let_everybody_in=True)
    with pytest.raises(ConfigError, match=r"192\.0\.2\.1 is not an address of this computer: exp"):
        async with serving:
            pass
