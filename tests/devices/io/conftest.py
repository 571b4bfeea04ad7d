"""A router with the devices of one bus, and a client that asks by frames while the bus runs."""

import struct
from collections.abc import Callable

import pytest

from achse.ams import AmsAddress, Command, Flags, Frame, NetId
from achse.codes import AlState
from achse.devices.io import AttachedBuses, ServedBus, default_net_id
from achse.drive import Drive
from achse.drive.firmware import Firmware
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.master import (
    BusConfiguration,
    ClockConfiguration,
    Master,
    Ring,
    from_description,
)
from achse.router import Router

STATION = NetId("10.1.2.3.1.1")
BUS = NetId("10.1.2.3.2.1")
MASTER, FIRST = 0xFFFF, 1001


class Refused(Exception):
    """The ADS or AMS error of an answer."""

    def __init__(self, code: int) -> None:
        super().__init__(f"0x{code:X}")
        self.code = code


class IoBus:
    """A bus of a drive and loopbacks with its ADS devices."""

    def __init__(
        self,
        boxes: int = 2,
        kind: Callable[..., Loopback] = Loopback,
        drive_firmware: Firmware | None = None,
    ) -> None:
        self.drive = Drive(firmware=drive_firmware)
        self.line = [kind(serial_number=number) for number in range(boxes)]
        applications: list[Drive | Loopback] = [self.drive, *self.line]
        self.segment = Segment(Slave(each) for each in applications)
        slaves = tuple(
            from_description(
                describe(each),
                f"Box {number}",
                clock=ClockConfiguration() if each is self.drive else None,
            )
            for number, each in enumerate(applications, 1)
        )
        self.master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
        self.ring = Ring(self.master, self.segment)
        self.router = Router(STATION)
        self.served = ServedBus(1, self.master, default_net_id(STATION, 1), "a comment")
        self.attached = AttachedBuses(self.router, [self.served], clock=lambda: 0)
        self.answers: list[Frame] = []
        self.client = self.router.register(0, self)

    def deliver(self, frame: Frame) -> bool:
        """Take an answer."""
        self.answers.append(frame)
        return True

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.ring.exchange(self.master.now_ns + 1_000_000)

    def up(self, state: AlState = AlState.OP) -> "IoBus":
        self.master.request(state)
        for _ in range(2000):
            if self.master.state == state:
                return self
            self.run()
        raise AssertionError(self.master.take_events())

    def ask(self, port: int, command: Command, payload: bytes, net_id: NetId = BUS) -> bytes:
        """The payload of the answer behind its result; raises `Refused`."""
        if port == 300:
            net_id = STATION
        frame = Frame(
            AmsAddress.of(net_id, port),
            self.client,
            command,
            Flags.ADS_COMMAND,
            invoke_id=7,
            data=payload,
        )
        self.answers.clear()
        self.router.deliver(frame)
        for _ in range(8000):
            if self.answers:
                break
            self.run()
        (answer,) = self.answers
        if answer.error:
            raise Refused(answer.error)
        (result,) = struct.unpack_from("<I", answer.data)
        if result:
            raise Refused(result)
        return answer.data[4:]

    def read(self, port: int, group: int, offset: int, length: int = 1024) -> bytes:
        return self.ask(port, Command.READ, struct.pack("<III", group, offset, length))[4:]

    def write(self, port: int, group: int, offset: int, data: bytes = b"") -> None:
        self.ask(port, Command.WRITE, struct.pack("<III", group, offset, len(data)) + data)

    def read_write(self, port: int, group: int, offset: int, length: int, data: bytes) -> bytes:
        head = struct.pack("<IIII", group, offset, length, len(data))
        return self.ask(port, Command.READ_WRITE, head + data)[4:]

    def code(self, ask: Callable[[], object]) -> int:
        """The code a request is refused with."""
        with pytest.raises(Refused) as refused:
            ask()
        return refused.value.code


@pytest.fixture
def io() -> IoBus:
    return IoBus()
