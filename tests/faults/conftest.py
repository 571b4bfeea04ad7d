"""A station and a client that does not wait, for all faults of stations."""

import pytest

from achse import ethercat
from achse.ams import Command, Frame
from achse.ams.commands import ReadRequest
from achse.codes import AlState, AlStatus
from achse.drive import Drive
from achse.ethercat import Datagram, Segment, Slave
from achse.faults.drive_list import DriveFaults
from achse.station import Station

MS = 1_000_000


@pytest.fixture
def station() -> Station:
    return Station.demo()


class Sender:
    """Sends requests without waiting and keeps what comes."""

    def __init__(self, station: Station, port: int = 851) -> None:
        self.router = station.router
        self.address = self.router.register(0, self)
        self.target = self.address.of(self.router.net_id, port)
        self.frames: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True

    def send(self, number: int, command: int = Command.READ_STATE, data: bytes = b"") -> None:
        self.router.deliver(Frame(self.target, self.address, command, 4, 0, number, data))

    def read(self, number: int, group: int, offset: int) -> None:
        self.send(number, Command.READ, ReadRequest(group, offset, 4).encode())

    @property
    def numbers(self) -> list[int]:
        """The invoke ids that came since the last look."""
        frames, self.frames = self.frames, []
        return [frame.invoke_id for frame in frames]


@pytest.fixture
def client(station: Station) -> Sender:
    return Sender(station)


@pytest.fixture
def sender() -> type[Sender]:
    """`sender(station, 851)`: one more client."""
    return Sender


class Bus:
    """Two drives, communication in PreOp at the application's side, time as it is let."""

    def __init__(self) -> None:
        self.segment = Segment([Slave(Drive()), Slave(Drive())])
        self.faults = DriveFaults(self.segment)
        for drive in self.drives:
            drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
        self.run(5)

    @property
    def drives(self) -> list[Drive]:
        return [slave.application for slave in self.segment.slaves]  # type: ignore[misc]

    def run(self, milliseconds: float) -> None:
        self.segment.advance(self.segment.time.now_ns + round(milliseconds * MS))
        self.faults.tick()

    def counter(
        self, command: ethercat.DatagramCommand = ethercat.DatagramCommand.BRD, address: int = 0
    ) -> int | None:
        reply = self.segment.process(
            ethercat.EthercatFrame([Datagram.at(command, address, 0, bytes(1))]).encode()
        )
        return None if reply is None else ethercat.EthercatFrame.decode(reply).datagrams[0].counter


@pytest.fixture
def bus() -> Bus:
    return Bus()
