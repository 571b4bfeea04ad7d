"""Links: packets in, answers out, and clear words where there is no way."""

import os
import socket
import sys
import time
from collections.abc import Iterator

import pytest

from achse.transport.ethernet import EthernetLink, LinkError, UdpLink

FOREVER = 3600.0
"""Seconds: more than the guard of the run gives a test."""

LOOPBACK = "lo"
ETHERTYPE = 0x88B5  # for local experiments


@pytest.fixture
def link() -> Iterator[UdpLink]:
    link = UdpLink("127.0.0.1", 0)
    yield link
    link.close()


@pytest.fixture
def peer() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        yield peer


def test_a_udp_packet_is_answered_to_its_sender(link: UdpLink, peer: socket.socket) -> None:
    peer.sendto(b"question", link.address)
    assert link.exchange(lambda packet: packet[::-1], FOREVER)
    assert peer.recvfrom(100) == (b"noitseuq", link.address)


def test_no_answer_is_sent_for_none(link: UdpLink, peer: socket.socket) -> None:
    answers = {b"one": None, b"two": b"answer to two"}
    for question in answers:
        peer.sendto(question, link.address)
        assert link.exchange(lambda packet: answers[bytes(packet)], FOREVER)
    assert peer.recv(100) == b"answer to two"


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

            assert link.exchange(answer, FOREVER)
            assert seen == [frame]
            # on the loopback interface our own answer comes in
            assert link.exchange(answer, FOREVER)
        assert seen[1][14:] == b"answer"
        link.close()

    def test_frames_are_sent_and_taken_by_a_master(self) -> None:
        link, other = EthernetLink(LOOPBACK, ETHERTYPE), EthernetLink(LOOPBACK, ETHERTYPE)
        frame = bytes(12) + ETHERTYPE.to_bytes(2, "big") + b"datagrams"
        assert link.receive(0.0) is None
        assert link.send(frame)
        assert other.receive(FOREVER) == frame
        assert other.receive(0.01) is None
        link.close()
        other.close()

    def test_the_kernel_says_when_a_frame_arrived(self) -> None:
        link, other = EthernetLink(LOOPBACK, ETHERTYPE), EthernetLink(LOOPBACK, ETHERTYPE)
        before = time.time_ns()
        assert other.send(bytes(12) + ETHERTYPE.to_bytes(2, "big") + b"stamped")
        assert link.receive(FOREVER) is not None
        assert before - 1_000_000_000 < link.arrived_ns <= time.time_ns() + 1_000_000_000
        for each in (link, other):
            each.close()

    def test_an_interface_that_was_removed_is_gone(self, monkeypatch: pytest.MonkeyPatch) -> None:
        link = EthernetLink(LOOPBACK, ETHERTYPE)
        assert not link.gone
        monkeypatch.setattr(socket, "if_nametoindex", lambda name: 4711)
        assert link.gone

        def unknown(name: str) -> int:
            raise OSError("no interface with this name")

        monkeypatch.setattr(socket, "if_nametoindex", unknown)
        assert link.gone
        link.close()

    def test_a_missing_interface_is_reported_with_those_there_are(self) -> None:
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


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="raw Ethernet needs Linux")
def test_an_interface_that_is_served_already_is_refused() -> None:
    try:
        first = EthernetLink(LOOPBACK, ETHERTYPE, alone=True)
    except LinkError as refusal:
        pytest.skip(str(refusal))
    with pytest.raises(LinkError, match="lo is served already"):
        EthernetLink(LOOPBACK, ETHERTYPE, alone=True)
    other = EthernetLink(LOOPBACK, ETHERTYPE)  # one that only looks may
    other.close()
    first.close()
    EthernetLink(LOOPBACK, ETHERTYPE, alone=True).close()
