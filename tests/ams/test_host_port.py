"""Hosts as people write them."""

import pytest

from achse.ams.host_port import host_and_port, parse_tcp_port


@pytest.mark.parametrize(
    ("host", "name", "tcp_port"),
    [
        ("plc", "plc", 5000),
        ("plc:48898", "plc", 48898),
        ("::1", "::1", 5000),
        ("[::1]", "::1", 5000),
        ("[::1]:77", "::1", 77),
    ],
)
def test_a_host_may_name_its_port(host: str, name: str, tcp_port: int) -> None:
    assert host_and_port(host, 5000) == (name, tcp_port)


@pytest.mark.parametrize("host", ["", ":1", "[]:1", "http://plc", "plc:0", "plc:x", "[::1]1x"])
def test_what_is_not_a_host(host: str) -> None:
    with pytest.raises(ValueError, match=r"got '"):
        host_and_port(host, 5000)


@pytest.mark.parametrize("text", ["", "0", "65536", "-1", "\u0661", "1.0"])
def test_what_is_not_a_tcp_port(text: str) -> None:
    with pytest.raises(ValueError, match=r"a TCP port is 1\.\.65535, got"):
        parse_tcp_port(text)
