"""pysoem homes a drive and moves it in pp, pv and tq; JSON on stdout. `… INTERFACE MS modes`."""

import struct
from typing import Any

import pysoem
from pysoem_bus import ENABLED, READY, STATE, Bus, Report, number, run

OUTPUTS = struct.Struct("<HbhHiHiI")  # 1603h: controlword, mode, torque, max torque, position, …
INPUTS = struct.Struct("<HbiihHiI")  # 1A03h: statusword, mode, position, velocity, torque, …
PP, PV, TQ, HM = 1, 3, 4, 6
REACHED, BIT_12, BIT_13 = 0x0400, 0x1000, 0x2000
MAX_TORQUE = 3000


class Axis:
    """One drive, by process data."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.torque = self.velocity = self.target = 0
        self.mode = PP
        self.word = 0
        self.inputs: tuple[int, ...] = ()

    @property
    def status(self) -> int:
        return self.inputs[0]

    @property
    def position(self) -> int:
        return self.inputs[2]

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            [self.inputs] = self.bus.exchange(
                self.word, self.mode, self.torque, MAX_TORQUE, self.target, 0, self.velocity, 0
            )

    def until(self, mask: int, value: int, cycles: int = 2000) -> bool:
        for _ in range(cycles):
            self.cycle()
            if self.status & mask == value:
                return True
        return False

    def control(self, word: int) -> None:
        self.word = word
        self.cycle()

    def enter(self, mode: int) -> bool:
        self.mode = mode
        for _ in range(100):
            self.cycle()
            if self.inputs[1] == mode:
                return True
        return False


def modes(master: Any, report: Report) -> None:
    master.config_init()
    drive = master.slaves[0]
    for assignment, pdo in ((0x1C12, 0x1603), (0x1C13, 0x1A03)):
        drive.sdo_write(assignment, 0, b"\0")
        drive.sdo_write(assignment, 1, struct.pack("<H", pdo))
        drive.sdo_write(assignment, 0, b"\1")
    master.config_map()
    report["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 500_000)
    bus = Bus(master, OUTPUTS, INPUTS, cycle=0.002)
    axis = Axis(bus)
    report["op"] = bus.go(pysoem.OP_STATE)
    axis.cycle(5)
    axis.control(6)
    axis.until(STATE, READY)
    axis.control(15)
    report["enabled"] = axis.until(STATE, ENABLED)
    home(axis, drive, report)
    position(axis, drive, report)
    velocity(axis, drive, report)
    torque(axis, drive, report)
    axis.control(0)
    axis.cycle(10)


def home(axis: Axis, drive: Any, report: Report) -> None:
    """Method 33: to the next index pulse in negative direction."""
    result: dict[str, Any] = {"mode": axis.enter(HM)}
    report["hm"] = result
    drive.sdo_write(0x6098, 0, struct.pack("<b", 33))
    drive.sdo_write(0x6099, 2, struct.pack("<I", 60_000))
    drive.sdo_write(0x607C, 0, struct.pack("<i", 1000))
    axis.control(0x0F)
    axis.control(0x1F)
    result["done"] = axis.until(REACHED | BIT_12 | BIT_13, REACHED | BIT_12)
    axis.cycle(20)
    result["position"] = axis.position
    axis.control(0x0F)


def position(axis: Axis, drive: Any, report: Report) -> None:
    """Absolute, then relative; the handshake of each."""
    result: dict[str, Any] = {"mode": axis.enter(PP)}
    report["pp"] = result
    drive.sdo_write(0x6081, 0, struct.pack("<I", 200_000))
    drive.sdo_write(0x6083, 0, struct.pack("<I", 2_000_000))
    drive.sdo_write(0x6084, 0, struct.pack("<I", 2_000_000))
    for name, target, bits in (("absolute", 100_000, 0x10), ("relative", -30_000, 0x50)):
        axis.target = target
        axis.cycle()
        axis.control(0x0F | bits)
        taken = axis.until(BIT_12, BIT_12, 50)
        axis.control(0x0F)
        released = axis.until(BIT_12, 0, 50)
        reached = axis.until(REACHED, REACHED)
        axis.cycle(50)
        result[name] = [taken, released, reached, axis.position]


def velocity(axis: Axis, drive: Any, report: Report) -> None:
    result: dict[str, Any] = {"mode": axis.enter(PV)}
    report["pv"] = result
    axis.velocity = 150_000
    axis.cycle(20)
    result["reached"] = axis.until(REACHED, REACHED)
    axis.cycle(100)
    result["velocity"] = axis.inputs[3]
    axis.velocity = 0
    axis.cycle(20)
    result["stopped"] = axis.until(REACHED | BIT_12, REACHED | BIT_12)


def torque(axis: Axis, drive: Any, report: Report) -> None:
    drive.sdo_write(0x6087, 0, struct.pack("<I", 10_000))
    axis.torque = 0
    result: dict[str, Any] = {"mode": axis.enter(TQ)}
    report["tq"] = result
    axis.torque = 60
    axis.cycle(50)
    result["6077h"] = axis.inputs[4]
    result["faster"] = axis.inputs[3]
    axis.torque = 0
    axis.cycle(50)
    result["zero"] = axis.inputs[4]
    result["6041h"] = axis.status & STATE
    result["603Fh"] = number(drive, 0x603F)


if __name__ == "__main__":
    run({"modes": modes})
