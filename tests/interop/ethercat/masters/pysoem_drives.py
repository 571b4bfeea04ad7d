"""pysoem finds CiA 402 drives, enables and moves them, is silent, recovers; JSON on stdout.

`pysoem_drives.py INTERFACE WHAT`; WHAT is `move` or `remap`. A run in which the machine held this
process or the drives up for longer than their watchdog allows is begun anew.
"""

import json
import struct
import sys
import time
from collections.abc import Callable
from typing import Any

import pysoem

OUTPUTS = struct.Struct("<HbHiHI")  # 1600h: controlword, mode, max torque, target, probe, outputs
INPUTS = struct.Struct("<HHbiHiiI")  # 1A00h: error, statusword, mode, position, probe, …
CSP = 8
CYCLE = 0.004
LONGEST_GAP = 0.08
ATTEMPTS = 6
STEP = 400
CYCLES = 250


class Late(Exception):
    """The machine was too busy for this master or for the drives."""


class Bus:
    """A master whose drives all get the same outputs, and the time since it last spoke."""

    def __init__(self, master: Any) -> None:
        self.master = master
        self.counters: set[int] = set()
        self.spoken = time.monotonic()

    @property
    def drives(self) -> list[Any]:
        return self.master.slaves  # type: ignore[no-any-return]

    def exchange(self, *outputs: int) -> list[tuple[int, ...]]:
        """One cycle: the inputs of every drive."""
        before, after = self.spoken, time.monotonic()
        for drive in self.drives:
            if outputs:
                drive.output = OUTPUTS.pack(*outputs)
        self.master.send_processdata()
        self.counters.add(self.master.receive_processdata(50_000))
        self.spoken = after
        if time.monotonic() - before > LONGEST_GAP:
            raise Late
        time.sleep(CYCLE)
        return [INPUTS.unpack(drive.input) for drive in self.drives] if outputs else []

    def until(self, state: int, *outputs: int, mask: int = 0x6F) -> list[int]:
        """Cycles until every statusword shows the state; the statuswords."""
        for _ in range(200):
            seen = [inputs[1] for inputs in self.exchange(*outputs)]
            if all(word & mask == state for word in seen):
                break
        return [word & mask for word in seen]

    def go(self, state: int) -> int:
        """Ask for a state; the one reached."""
        self.spoken = time.monotonic()
        self.exchange()  # outputs must have come before Op, and the watchdog must be fed
        self.master.state = state
        self.master.write_state()
        reached: int = self.master.state_check(state & 0xF, 500_000)
        self.spoken = time.monotonic()
        return reached


def number(drive: Any, index: int, subindex: int = 0) -> int:
    return int.from_bytes(drive.sdo_read(index, subindex), "little")


def find(master: Any, found: dict[str, Any]) -> None:
    found["count"] = master.config_init()
    found["identity"] = [[drive.man, drive.id] for drive in master.slaves]
    found["1018h"] = [
        [number(drive, 0x1018, subindex) for subindex in range(5)] for drive in master.slaves
    ]


def move(master: Any, found: dict[str, Any]) -> None:
    find(master, found)
    emergencies: list[int] = []
    bus = Bus(master)
    for drive in bus.drives:
        drive.add_emergency_callback(lambda message: emergencies.append(message.error_code))
    found["map size"] = master.config_map()
    found["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 500_000)
    found["expected"] = master.expected_wkc
    found["op"] = bus.go(pysoem.OP_STATE)
    start = INPUTS.unpack(bus.drives[0].input)[3]
    found["ready"] = bus.until(0x21, 6, CSP, 3000, start, 0, 0)
    found["switched on"] = bus.until(0x23, 7, CSP, 3000, start, 0, 0)
    found["enabled"] = bus.until(0x27, 15, CSP, 3000, start, 0, 0)
    bus.counters.clear()
    worst = 0
    target = start
    for _ in range(CYCLES):
        target += STEP
        positions = [inputs[3] for inputs in bus.exchange(15, CSP, 3000, target, 0, 0)]
        worst = max(worst, *(abs(target - position) for position in positions))
    for _ in range(50):
        inputs = bus.exchange(15, CSP, 3000, target, 0, 0)
    found["worst"] = worst
    found["rest"] = [target - each[3] for each in inputs]
    found["mode"] = [each[2] for each in inputs]
    found["counters"] = sorted(bus.counters)
    time.sleep(0.15)
    master.read_state()
    found["silent"] = [[drive.state, drive.al_status] for drive in bus.drives]
    bus.spoken = time.monotonic()
    bus.exchange()
    inputs = [INPUTS.unpack(drive.input) for drive in bus.drives]
    found["fault"] = [each[1] & 0x4F for each in inputs]
    found["603Fh"] = [each[0] for each in inputs]
    for drive in bus.drives:
        drive.sdo_read(0x603F, 0)
        drive.mbx_receive()
    found["emergencies"] = emergencies
    found["acknowledged"] = bus.go(pysoem.SAFEOP_STATE | pysoem.STATE_ACK)
    found["recovered"] = bus.go(pysoem.OP_STATE)
    bus.until(0x08, 0, CSP, 3000, target, 0, 0, mask=0x4F)
    found["reset"] = bus.until(0x40, 0x80, CSP, 3000, target, 0, 0, mask=0x4F)
    here = INPUTS.unpack(bus.drives[0].input)[3]
    bus.until(0x21, 6, CSP, 3000, here, 0, 0)
    found["again"] = bus.until(0x27, 15, CSP, 3000, here, 0, 0)
    bus.until(0x40, 0, CSP, 3000, here, 0, 0, mask=0x4F)


def remap(master: Any, found: dict[str, Any]) -> None:
    """607Fh is added to 1600h, step by step; and steps that are refused."""
    find(master, found)
    drive = master.slaves[0]
    found["aborts"] = aborts = {}

    def refused(name: str, index: int, subindex: int, data: bytes) -> None:
        try:
            drive.sdo_write(index, subindex, data)
        except pysoem.SdoError as error:
            aborts[name] = hex(error.abort_code)

    entry = struct.pack("<I", 0x607F0020)
    refused("assigned", 0x1600, 0, b"\0")
    drive.sdo_write(0x1C12, 0, b"\0")
    refused("counted", 0x1600, 7, entry)
    drive.sdo_write(0x1600, 0, b"\0")
    refused("not in the dictionary", 0x1600, 7, struct.pack("<I", 0x50000020))
    drive.sdo_write(0x1600, 7, entry)
    drive.sdo_write(0x1600, 0, b"\7")
    drive.sdo_write(0x1C12, 1, struct.pack("<H", 0x1600))
    drive.sdo_write(0x1C12, 0, b"\1")
    master.config_map()
    found["sizes"] = [[len(each.output), len(each.input)] for each in master.slaves]
    found["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 500_000)
    refused("in SafeOp", 0x1C12, 0, b"\0")
    bus = Bus(master)
    found["op"] = bus.go(pysoem.OP_STATE)
    for _ in range(20):
        drive.output = OUTPUTS.pack(0, CSP, 3000, 0, 0, 0) + struct.pack("<I", 4711)
        bus.exchange()
    found["607Fh"] = number(drive, 0x607F)


def main() -> None:
    interface, what = sys.argv[1:]
    scenario: Callable[[Any, dict[str, Any]], None] = {"move": move, "remap": remap}[what]
    master = pysoem.Master()
    master.open(interface)
    try:
        for attempt in range(ATTEMPTS):
            found: dict[str, Any] = {"attempt": attempt}
            try:
                scenario(master, found)
                break
            except Late:
                master.state = pysoem.INIT_STATE
                master.write_state()
        else:
            raise Late(f"{ATTEMPTS} attempts")
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
    print(json.dumps(found))


if __name__ == "__main__":
    main()
