"""A segment on a link, moved by the wall clock or by its frames."""

import socket

import pytest

from achse.ethercat import Command, Datagram, Frame, Loopback, Segment, Slave
from achse.station import fieldbus
from achse.transport.ethernet import Answer, UdpLink

BRD = Frame([Datagram.at(Command.BRD, 0, 0, bytes(1))])


class Script:
    """A link that delivers packets, None for silence, while a fake clock goes on."""

    def __init__(self, packets: list[bytes | None], monkeypatch: pytest.MonkeyPatch) -> None:
        self.packets = packets
        self.replies: list[bytes | None] = []
        self.now_ns = 10**12
        monkeypatch.setattr(fieldbus.time, "monotonic_ns", lambda: self.now_ns)

    def exchange(self, answer: Answer, timeout_s: float) -> bool:
        packet = self.packets.pop(0)
        self.now_ns += 1_000_000
        if packet is None:
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
    fieldbus.serve_segment(segment, link, link.running)
    assert [Frame.decode(reply or b"").datagrams[0].counter for reply in link.replies] == [2, 2]
    assert segment.time.now_ns == (0 if cycle_ns else 4_000_000)


def test_udp_payloads_are_answered() -> None:
    segment = Segment([Slave(Loopback())])
    link = UdpLink("127.0.0.1", 0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as master:
        master.settimeout(5)
        master.sendto(BRD.encode_payload(), link.address)
        rounds = iter([True, False])
        fieldbus.serve_segment(segment, link, lambda: next(rounds))
        reply = Frame.decode_payload(master.recv(2000))
    assert reply.datagrams[0].counter == 1
    link.close()
