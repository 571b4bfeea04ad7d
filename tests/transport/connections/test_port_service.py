"""Port service: programs of this computer register ports, others are turned out."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, NetId, TcpCommand, TcpMessage
from achse.transport.connections.peer import Peer
from tests.router.stations import Host, Loop, wires

OURS = NetId("5.0.0.1.1.1")


class End:
    def __init__(self) -> None:
        self.written = b""

    def receive(self, data: bytes) -> None:
        self.written += data

    def close(self) -> None: ...

    def ended(self) -> None: ...


def connected() -> tuple[Host, Peer, End]:
    host = Host(Loop(), OURS)
    here, there = wires(host.loop)
    host.accept(here)
    there.end = End()
    return host, here.end, there.end


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 0xFFFF)), max_size=12))
def test_ports_are_registered_answered_and_freed(steps: list[tuple[bool, int]]) -> None:
    host, peer, end = connected()
    ports: list[int] = []
    for register, port in steps:
        before = len(end.written)
        word = port.to_bytes(2, "little")
        command = TcpCommand.PORT_CONNECT if register else TcpCommand.PORT_CLOSE
        peer.receive(TcpMessage(command, word).encode_tcp())
        host.loop.run()
        answer = end.written[before:]
        if register and port in ports:
            assert not peer.connected
            ports.clear()
        elif register:
            address = AmsAddress(answer[6:])
            assert answer[:6] == bytes.fromhex("001008000000")
            assert address.net_id == OURS
            assert address.port == (port or address.port)
            ports.append(address.port)
        elif port in ports:
            ports.remove(port)
            assert peer.connected == bool(ports)
        assert host.router.ports == sorted(ports)
        if not peer.connected:
            return


@pytest.mark.parametrize("local", [True, False])
def test_own_net_id_is_for_programs_of_this_computer(
    monkeypatch: pytest.MonkeyPatch, local: bool
) -> None:
    host, peer, end = connected()
    served: Any = lambda name: local  # noqa: E731
    monkeypatch.setattr(host, "serves_ports", served)
    peer.receive(TcpMessage(TcpCommand.GET_LOCAL_NET_ID, bytes(4)).encode_tcp())
    host.loop.run()
    assert peer.connected == local
    assert end.written[6:] == (bytes(OURS) if local else b"")


@pytest.mark.parametrize(
    "message",
    [TcpMessage(TcpCommand.PORT_CONNECT, b"\0"), TcpMessage(TcpCommand.PORT_CLOSE, bytes(3))],
)
def test_packet_of_another_length_ends_the_connection(message: TcpMessage) -> None:
    _, peer, _ = connected()
    peer.receive(message.encode_tcp())
    assert not peer.connected
