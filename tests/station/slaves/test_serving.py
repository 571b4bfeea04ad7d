"""A segment on a link, moved by the wall clock or by its frames."""

import socket
import time

import pytest

from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Segment, Slave
from achse.station.slaves import serving
from achse.transport.ethernet import Answer, UdpLink

BRD = EthercatFrame([Datagram.at(DatagramCommand.BRD, 0, 0, bytes(1))])


class Script:
    """A link that delivers packets, None for silence, while a fake clock goes on."""

    def __init__(self, packets: list[bytes | None], monkeypatch: pytest.MonkeyPatch) -> None:
        self.packets = packets
        self.replies: list[bytes | None] = []
        self.losses = 0
        self.now_ns = 10**12
        monkeypatch.setattr(time, "monotonic_ns", lambda: self.now_ns)

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        packet = self.packets.pop(0)
        self.now_ns += 1_000_000
        if packet is None:
            return False
        if packet == b"down":
            self.losses += 1
            return False
        self.replies.append(answer(packet))
        return True

    def fileno(self) -> int:
        return -1

    def close(self) -> None:
        self.packets.clear()

    def running(self) -> bool:
        return bool(self.packets)


@pytest.mark.parametrize("cycle_ns", [0, 1_000_000])
def test_frames_are_answered_in_time(monkeypatch: pytest.MonkeyPatch, cycle_ns: int) -> None:
    segment = Segment([Slave(Loopback()), Slave(Loopback())], cycle_ns=cycle_ns)
    link = Script([BRD.encode(), None, None, BRD.encode()], monkeypatch)
    serving.serve_segment(segment, link, link.running)
    assert [EthercatFrame.decode(reply or b"").datagrams[0].counter for reply in link.replies] == [
        2,
        2,
    ]
    assert segment.time.now_ns == (0 if cycle_ns else 4_000_000)


def test_time_in_which_the_machine_held_everything_up_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    segment = Segment([Slave(Loopback())])
    link = Script([None, BRD.encode(), None], monkeypatch)
    rounds = iter([True, True, True, False])

    def running() -> bool:
        if len(link.packets) == 2:
            link.now_ns += 500_000_000
        return next(rounds)

    serving.serve_segment(segment, link, running)
    assert segment.time.now_ns == 1_000_000 + 20_000_000 + 1_000_000


def test_others_get_their_turn_between_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    link = Script([BRD.encode()] * 21, monkeypatch)
    turns: list[int] = []
    serving.serve_segment(
        Segment([Slave(Loopback())]), link, link.running, lambda: turns.append(len(link.packets))
    )
    assert turns == [20, 15, 10, 5, 0]


def test_a_segment_closed_by_dl_control_opens_again_with_the_link(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Before, one frame that held all ports open made the segment dark until the program ended."""
    void = EthercatFrame([Datagram.at(DatagramCommand.BWR, 0, 0x0101, b"\xaa")]).encode()
    segment = Segment([Slave(Loopback()), Slave(Loopback())])
    link = Script([BRD.encode(), void, BRD.encode(), b"down", BRD.encode()], monkeypatch)
    serving.serve_segment(segment, link, link.running)
    counters = [
        reply and EthercatFrame.decode(reply).datagrams[0].counter for reply in link.replies
    ]
    assert counters == [2, 2, None, 2]


def test_udp_payloads_are_answered() -> None:
    segment = Segment([Slave(Loopback())])
    link = UdpLink("127.0.0.1", 0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as master:
        master.sendto(BRD.encode_payload(), link.address)
        rounds = iter([True, False])
        serving.serve_segment(segment, link, lambda: next(rounds))
        reply = EthercatFrame.decode_payload(master.recv(2000))
    assert reply.datagrams[0].counter == 1
    link.close()
