"""The address that is told to others for a listener at all addresses."""

import ipaddress
import socket
from unittest import mock

import pytest

from achse.transport.own_address import address_for_others


@pytest.mark.parametrize("host", ["127.0.0.1", "192.0.2.7", "::1", "mill.local", "localhost", ""])
def test_a_host_that_can_be_opened_stays(host: str) -> None:
    assert address_for_others(host) == host


@pytest.mark.parametrize("host", ["0.0.0.0", "::"])
def test_a_listener_at_all_addresses_has_that_of_the_default_route(host: str) -> None:
    probe = mock.MagicMock(spec=socket.socket)
    probe.__enter__.return_value = probe
    probe.getsockname.return_value = ("198.51.100.4", 40000)
    with mock.patch("achse.transport.own_address.socket.socket", return_value=probe) as made:
        assert address_for_others(host) == "198.51.100.4"
    made.assert_called_once_with(socket.AF_INET, socket.SOCK_DGRAM)
    probe.send.assert_not_called()
    probe.sendto.assert_not_called()


@pytest.mark.parametrize(
    ("found", "told"), [("198.51.100.9", "198.51.100.9"), (OSError("unknown"), "::")]
)
def test_without_a_route_the_host_name_counts(found: str | OSError, told: str) -> None:
    with (
        mock.patch("achse.transport.own_address.socket.socket", side_effect=OSError),
        mock.patch("achse.transport.own_address.socket.gethostbyname", side_effect=[found]),
    ):
        assert address_for_others("::") == told


def test_this_computer_listens_at_the_address_that_is_told() -> None:
    told = address_for_others("0.0.0.0")
    assert ipaddress.ip_address(told)
    with (
        socket.create_server(("0.0.0.0", 0)) as server,
        socket.create_connection((told, server.getsockname()[1])) as client,
    ):
        assert client.getpeername()[1] == server.getsockname()[1]
