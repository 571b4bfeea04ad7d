"""A small master of the tests' own, and segments of loopback slaves."""

import struct
from collections.abc import Callable

import pytest

from achse.codes import AlState
from achse.ethercat import Datagram, DatagramCommand, EthercatFrame, Loopback, Segment, Slave

STATION = 0x1001
LOGICAL_INPUTS = 0x100
_MAILBOX = struct.Struct("<HHBB")


class Master:
    """Drives a segment by frames alone; `line[n]` is the application of slave n."""

    def __init__(self, segment: Segment) -> None:
        self.segment = segment
        self._counter = 0

    @property
    def line(self) -> list[Loopback]:
        return [slave.application for slave in self.segment.slaves]  # type: ignore[misc]

    def send(self, *datagrams: Datagram) -> list[Datagram]:
        """Send datagrams in one frame; as they come back."""
        reply = self.segment.process(EthercatFrame(datagrams).encode())
        assert reply is not None, "the frame is lost"
        return list(EthercatFrame.decode(reply).datagrams)

    def one(self, command: DatagramCommand, station: int, offset: int, data: bytes) -> Datagram:
        """One datagram to the memory of a slave."""
        return self.send(Datagram.at(command, station, offset, data))[0]

    def read(self, offset: int, length: int, station: int = STATION) -> bytes:
        """Read registers or memory; the access must count."""
        reply = self.one(DatagramCommand.FPRD, station, offset, bytes(length))
        assert reply.counter == 1, f"reading 0x{offset:04X} is refused"
        return reply.data

    def number(self, offset: int, length: int, station: int = STATION) -> int:
        return int.from_bytes(self.read(offset, length, station), "little")

    def write(self, offset: int, data: bytes, station: int = STATION) -> int:
        """Write registers or memory; the working counter."""
        return self.one(DatagramCommand.FPWR, station, offset, data).counter

    def address(self) -> None:
        """Give each slave its station address, 0x1001 on."""
        for position in range(len(self.segment.reachable)):
            station = (STATION + position).to_bytes(2, "little")
            self.one(DatagramCommand.APWR, -position, 0x0010, station)

    def request(self, state: int, station: int = STATION) -> tuple[int, int]:
        """Ask for a state; AL status and code afterwards."""
        self.write(0x0120, state.to_bytes(2, "little"), station)
        return self.status(station)

    def status(self, station: int = STATION) -> tuple[int, int]:
        """AL status and AL status code."""
        data = self.read(0x0130, 6, station)
        return data[0] | data[1] << 8, data[4] | data[5] << 8

    def mailboxes(self, station: int = STATION) -> None:
        """Set SyncManagers 0 and 1 up."""
        self.write(
            0x0800, sync_manager(0x1000, 256, 0x26) + sync_manager(0x1100, 256, 0x22), station
        )

    def process_data(self, station: int = STATION, size: int = 4) -> None:
        """Set SyncManagers 2 and 3 up, and FMMUs: outputs from logical 0, inputs from 0x100."""
        self.write(
            0x0810, sync_manager(0x1200, size, 0x64) + sync_manager(0x1300, size, 0x20), station
        )
        logical = (station - STATION) * size
        self.write(
            0x0600,
            fmmu(logical, size, 0x1200, 2) + fmmu(LOGICAL_INPUTS + logical, size, 0x1300, 1),
            station,
        )

    def bring(self, state: AlState, *stations: int) -> None:
        """Bring slaves from Init to a state, by default all."""
        self.address()
        for station in stations or range(STATION, STATION + len(self.segment.reachable)):
            if state >= AlState.PREOP:
                self.mailboxes(station)
                assert self.request(AlState.PREOP, station) == (AlState.PREOP, 0)
            if state >= AlState.SAFEOP:
                self.process_data(station)
                assert self.request(AlState.SAFEOP, station) == (AlState.SAFEOP, 0)
            if state == AlState.OP:
                size = len(self.segment.slaves) * 4
                self.send(Datagram(DatagramCommand.LWR, 0, bytes(size)))
                assert self.request(AlState.OP, station) == (AlState.OP, 0)

    def exchange(self, outputs: bytes) -> tuple[bytes, int]:
        """Write outputs and read inputs as two datagrams of a frame; the sum of the counters."""
        out, into = self.send(
            Datagram(DatagramCommand.LWR, 0, outputs),
            Datagram(DatagramCommand.LRD, LOGICAL_INPUTS, bytes(len(outputs))),
        )
        return into.data, out.counter + into.counter

    def advance(self, milliseconds: float) -> None:
        """Let time pass."""
        self.segment.advance(self.segment.time.now_ns + round(milliseconds * 1e6))

    # mailbox

    def post(self, data: bytes, protocol: int = 3, station: int = STATION) -> int:
        """Write a message to the mailbox; the working counter."""
        self._counter = self._counter % 7 + 1
        message = _MAILBOX.pack(len(data), 0, 0, protocol | self._counter << 4) + data
        return self.write(0x1000, message.ljust(256, b"\0"), station)

    def fetch(self, station: int = STATION) -> tuple[int, bytes] | None:
        """The protocol and data of the message that waits, None if there is none."""
        if not self.number(0x080D, 1, station) & 0x08:
            return None
        data = self.read(0x1100, 256, station)
        length, _, _, kind = _MAILBOX.unpack_from(data)
        return kind & 0x0F, data[6 : 6 + length]

    def coe(self, service: int, body: bytes, station: int = STATION) -> tuple[int, bytes]:
        """A CoE message and its answer: service and body."""
        assert self.post((service << 12).to_bytes(2, "little") + body, station=station) == 1
        answer = self.fetch(station)
        assert answer is not None
        assert answer[0] == 3
        return int.from_bytes(answer[1][:2], "little") >> 12, answer[1][2:]


def sync_manager(start: int, length: int, control: int) -> bytes:
    return struct.pack("<HHBBBB", start, length, control, 0, 1, 0)


def fmmu(logical: int, length: int, physical: int, direction: int) -> bytes:
    return struct.pack("<IHBBHBBB3x", logical, length, 0, 7, physical, 0, direction, 1)


@pytest.fixture
def line() -> Callable[..., Master]:
    """`line(3)` is a master on three loopbacks; `line(3, cycle_ns=…)` is clocked by frames."""

    def make(count: int = 1, **options: int) -> Master:
        return Master(Segment((Slave(Loopback(serial_number=n)) for n in range(count)), **options))

    return make


@pytest.fixture
def master(line: Callable[..., Master]) -> Master:
    """A master on one loopback slave, in Init, with its station address."""
    result = line(1)
    result.address()
    return result
