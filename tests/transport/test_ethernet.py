"""Links: packets in, answers out, and clear words where there is no way."""

import os
import socket
import sys
from collections.abc import Iterator

import pytest

from achse.transport.ethernet import EthernetLink, LinkError, UdpLink

LOOPBACK = "lo"
ETHERTYPE = 0x88B5  # for local experiments


@pytest.fixture
def link() -> Iterator[UdpLink]:
    made = UdpLink("127.0.0.1", 0)
    yield made
    made.close()


@pytest.fixture
def peer() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.settimeout(5)
        yield made


def test_a_udp_packet_is_answered_to_its_sender(link: UdpLink, peer: socket.socket) -> None:
    peer.sendto(b"question", link.address)
    assert link.exchange(lambda packet: packet[::-1], 5)
    assert peer.recvfrom(100) == (b"noitseuq", link.address)


def test_no_answer_is_sent_for_none(link: UdpLink, peer: socket.socket) -> None:
    peer.sendto(b"question", link.address)
    assert link.exchange(lambda _: None, 5)
    peer.settimeout(0.01)
    with pytest.raises(TimeoutError):
        peer.recv(100)


@pytest.mark.parametrize("timeout", [0, 0.01])
def test_waiting_ends(link: UdpLink, timeout: float) -> None:
    assert not link.exchange(bytes, timeout)


def test_a_port_is_had_once(link: UdpLink) -> None:
    host, port = link.address
    with pytest.raises(LinkError, match=f"{host}:{port}"):
        UdpLink(host, port)


@pytest.mark.skipif(sys.platform != "linux", reason="raw Ethernet is Linux's")
@pytest.mark.skipif(os.geteuid() != 0, reason="raw Ethernet needs CAP_NET_RAW; CI runs as root")
class TestRawEthernet:
    def test_a_frame_is_answered_by_the_way_it_came(self) -> None:
        link = EthernetLink(LOOPBACK, ETHERTYPE)
        frame = bytes(12) + ETHERTYPE.to_bytes(2, "big") + b"question"
        with socket.socket(socket.AF_PACKET, socket.SOCK_RAW) as peer:
            peer.bind((LOOPBACK, ETHERTYPE))
            peer.send(frame)
            seen: list[bytes] = []

            def answer(packet: bytes) -> bytes | None:
                seen.append(packet)
                return packet[:14] + b"answer" if packet == frame else None

            assert link.exchange(answer, 5)
            assert seen == [frame]
            assert link.exchange(answer, 5)  # on the loopback interface our own answer comes in
        assert seen[1][14:] == b"answer"
        link.close()

    def test_a_missing_interface_is_told_with_those_there_are(self) -> None:
        with pytest.raises(LinkError, match=r"no interface nowhere0 .* there are .*lo"):
            EthernetLink("nowhere0")


def test_without_the_privilege_the_error_says_what_is_needed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object) -> socket.socket:
        raise PermissionError

    monkeypatch.setattr("achse.transport.ethernet.socket.socket", refuse)
    with pytest.raises(LinkError, match="CAP_NET_RAW"):
        EthernetLink("eth0")


def test_other_systems_are_pointed_to_udp(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("achse.transport.ethernet.socket.AF_PACKET", raising=False)
    with pytest.raises(LinkError, match="over UDP"):
        EthernetLink("eth0")
