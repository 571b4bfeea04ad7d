"""Loopback addresses for stations side by side."""

import socket
import sys

import pytest

from achse.testing import addresses, free_host


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have 127.0.0.1 only")
def test_each_call_gives_another_address() -> None:
    hosts = [free_host(0) for _ in range(5)]
    assert len(set(hosts)) == 5
    assert all(host.startswith("127.") for host in hosts)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have 127.0.0.1 only")
def test_an_address_that_is_taken_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = free_host(0)
    with socket.create_server((taken, 0)) as listener:
        monkeypatch.setattr(addresses, "_hosts", iter([taken, "127.0.0.1"]))
        port = listener.getsockname()[1]
        assert free_host(port) == "127.0.0.1"


def test_where_there_is_one_address_a_taken_port_is_an_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        monkeypatch.setattr(addresses, "_hosts", iter(["127.0.0.1"]))
        with pytest.raises(OSError, match="in use"):
            free_host(listener.getsockname()[1])
