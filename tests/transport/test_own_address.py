"""The address that is told to others for a listener at all addresses."""

import ipaddress
import socket
import struct
import sys
from unittest import mock

import pytest

from achse.transport import own_address
from achse.transport.own_address import address_for_others, is_loopback


@pytest.mark.parametrize("host", ["127.0.0.1", "192.0.2.7", "::1", "mill.local", "localhost"])
def test_a_host_that_can_be_opened_stays(host: str) -> None:
    assert address_for_others(host) == host


@pytest.mark.parametrize("host", ["", "0.0.0.0", "::"])
def test_a_listener_at_all_addresses_has_that_of_the_default_route(host: str) -> None:
    probe = mock.MagicMock(spec=socket.socket)
    probe.__enter__.return_value = probe
    probe.getsockname.return_value = ("198.51.100.4", 40000)
    with mock.patch(
        "achse.transport.own_address.socket.socket", return_value=probe
    ) as socket_class:
        assert address_for_others(host) == "198.51.100.4"
    socket_class.assert_called_once_with(socket.AF_INET, socket.SOCK_DGRAM)
    probe.send.assert_not_called()
    probe.sendto.assert_not_called()


@pytest.mark.parametrize(
    ("address", "message"), [("198.51.100.9", "198.51.100.9"), (OSError("unknown"), "::")]
)
def test_without_a_route_the_host_name_counts(address: str | OSError, message: str) -> None:
    with (
        mock.patch("achse.transport.own_address.socket.socket", side_effect=OSError),
        mock.patch.object(own_address, "_interface_address", return_value=""),
        mock.patch("achse.transport.own_address.socket.gethostbyname", side_effect=[address]),
    ):
        assert address_for_others("::") == message


def test_this_computer_listens_at_the_reported_address() -> None:
    address = address_for_others("0.0.0.0")
    assert ipaddress.ip_address(address)
    with (
        socket.create_server(("0.0.0.0", 0)) as server,
        socket.create_connection((address, server.getsockname()[1])) as client,
    ):
        assert client.getpeername()[1] == server.getsockname()[1]


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such list")
def test_first_interface_with_an_address_besides_loopback_counts() -> None:
    def addressed(_: object, __: int, entry: bytes) -> bytes:
        name = entry.partition(b"\0")[0].decode()
        if name == "can0":
            raise OSError("no address")
        address = {"lo": "127.0.0.1", "eth1": "10.0.0.7", "eth2": "10.0.1.7"}[name]
        return struct.pack("16sHH4s16x", name.encode(), 2, 0, socket.inet_aton(address))

    names = [(number, name) for number, name in enumerate(("lo", "can0", "eth1", "eth2"), 1)]
    with (
        mock.patch("socket.if_nameindex", return_value=names),
        mock.patch("fcntl.ioctl", addressed),
    ):
        assert own_address._interface_address() == "10.0.0.7"
    with (
        mock.patch("socket.if_nameindex", return_value=names[:2]),
        mock.patch("fcntl.ioctl", addressed),
    ):
        assert own_address._interface_address() == ""


@pytest.mark.parametrize(
    ("host", "own"),
    [("127.0.0.1", True), ("::1", True), ("127.1.2.3", True), ("0.0.0.0", False),
     ("::", False), ("192.168.1.5", False), ("name", False),
     ("::1%lo", True), ("fe80::1%lo", False), ("", False), ("/run/socket", False)],
)  # fmt: skip
def test_loopback_addresses(host: str, own: bool) -> None:
    assert is_loopback(host) is own
