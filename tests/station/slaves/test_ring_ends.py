"""A line of slaves between two links: frames go round, and turn where a link is away."""

import socket
from collections.abc import Iterator

import pytest

from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Slave
from achse.ethercat.registers import Register
from achse.ethercat.ring_segment import RingSegment
from achse.station.slaves.ring_ends import RingEnds
from achse.station.slaves.serving import serve_segment

COUNT = EthercatFrame([Datagram.at(DatagramCommand.BRD, 0, Register.TYPE, b"\0")]).encode()
SLAVES = 3


class End:
    """An interface whose other end is `far`."""

    def __init__(self) -> None:
        self.near, self.far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.near.setblocking(False)
        self.up = True

    def fileno(self) -> int:
        return self.near.fileno()

    def send(self, frame: bytes) -> bool:
        self.near.send(frame)
        return True

    def receive(self, timeout_s: float) -> bytes | None:
        try:
            return self.near.recv(2048)
        except BlockingIOError:
            return None

    def close(self) -> None:
        self.near.close()
        self.far.close()


class Line:
    """Slaves between two ends, and what serves them."""

    def __init__(self) -> None:
        self.ends = End(), End()
        self.ring = RingSegment(Slave(Loopback()) for _ in range(SLAVES))
        self.link = RingEnds(self.ring, self.ends, self.ends)

    def passed(self, adapter: int) -> tuple[int, int] | None:
        """How many slaves a frame sent at an adapter passes, and where it comes; None: nowhere."""
        self.ends[adapter].far.send(COUNT)
        assert self.link.exchange(self.link.process, 10.0)
        for number, end in enumerate(self.ends):
            end.far.setblocking(False)
            try:
                frame = end.far.recv(2048)
            except BlockingIOError:
                continue
            return EthercatFrame.decode(frame).datagrams[0].counter, number
        return None


@pytest.fixture
def line() -> Iterator[Line]:
    line = Line()
    yield line
    line.link.close()


def test_frames_go_round_and_turn_where_a_link_is_away(line: Line) -> None:
    assert line.link.fileno() == line.ends[0].fileno()
    assert (line.passed(0), line.passed(1)) == ((SLAVES, 1), (0, 0))
    line.ends[0].up = False
    assert (line.passed(0), line.passed(1)) == (None, (SLAVES, 1))
    line.ends[0].up, line.ends[1].up = True, False
    assert (line.passed(0), line.passed(1)) == ((SLAVES, 0), None)
    line.ends[1].up = True
    assert (line.passed(0), line.passed(1)) == ((SLAVES, 1), (0, 0))
    line.ring.cut(1)
    assert (line.passed(0), line.passed(1)) == ((1, 0), (SLAVES - 1, 1))


def test_silence_and_links_that_fail_end_in_time(
    line: Line, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not line.link.exchange(line.link.process, 0.0)
    breaths: list[float] = []
    monkeypatch.setattr("achse.station.slaves.ring_ends.time.sleep", breaths.append)
    monkeypatch.setattr(line.ends[0], "receive", lambda timeout_s: None)
    line.ends[0].far.send(COUNT)
    assert not line.link.exchange(line.link.process, 10.0)
    assert breaths == [0.001]


def test_it_is_served_like_any_link(line: Line) -> None:
    for end in line.ends:
        end.far.send(COUNT)
    rounds = iter([True, True, False])
    serve_segment(line.ring, line.link, lambda: next(rounds))
    counters = [EthercatFrame.decode(end.far.recv(2048)).datagrams[0].counter for end in line.ends]
    assert counters == [0, SLAVES]
    assert line.ring.time.now_ns > 0
