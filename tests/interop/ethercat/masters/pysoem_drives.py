"""pysoem finds CiA 402 drives, enables and moves them, is silent, recovers; JSON on stdout.

`pysoem_drives.py INTERFACE MS WHAT`; WHAT is `move CYCLES` or `remap`.
"""

import struct
import sys
import time
from typing import Any

import pysoem
from pysoem_bus import (
    DEFAULT,
    DISABLED,
    ENABLED,
    FAULT,
    FAULT_STATE,
    PATIENCE_US,
    READY,
    STATE,
    SWITCHED_ON,
    Bus,
    Report,
    abort_of,
    number,
    run,
)

OUTPUTS = struct.Struct("<HbHiHI")  # 1600h: controlword, mode, max torque, target, probe, outputs
INPUTS = struct.Struct("<HHbiHiiI")  # 1A00h: error, statusword, mode, position, probe, …
CSP = 8
STEP = 400
RAMP = 250
SYNC0_NS = 4_000_000


def find(master: Any, report: Report) -> None:
    report["count"] = master.config_init()
    report["identity"] = [[drive.man, drive.id] for drive in master.slaves]
    report["1018h"] = [
        [number(drive, 0x1018, subindex) for subindex in range(5)] for drive in master.slaves
    ]


def until(bus: Bus, state: int, *outputs: int, mask: int = STATE) -> list[int]:
    """Cycles until every statusword shows the state; the statuswords."""
    for _ in range(200):
        seen = [inputs[1] for inputs in bus.exchange(*outputs)]
        if all(word & mask == state for word in seen):
            break
    return [word & mask for word in seen]


def move(master: Any, report: Report) -> None:
    find(master, report)
    emergencies: list[int] = []
    bus = Bus(master, OUTPUTS, INPUTS)
    for drive in bus.drives:
        drive.add_emergency_callback(lambda message: emergencies.append(message.error_code))
    report["map size"] = master.config_map()
    report["dc"] = master.config_dc()
    for drive in bus.drives:
        drive.dc_sync(True, SYNC0_NS)
    report["0981h"] = [drive._fprd(0x0981, 1, PATIENCE_US)[0] for drive in bus.drives]
    report["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 500_000)
    report["expected"] = master.expected_wkc
    bus.put(0, CSP, 3000, 0, 0, 0)
    report["op"] = bus.go(pysoem.OP_STATE)
    report["1C32h"] = [
        [number(drive, 0x1C32, subindex) for subindex in (1, 2)] for drive in bus.drives
    ]
    start = bus.inputs()[0][3]
    report["ready"] = until(bus, READY, 6, CSP, 3000, start, 0, 0)
    report["switched on"] = until(bus, SWITCHED_ON, 7, CSP, 3000, start, 0, 0)
    report["enabled"] = until(bus, ENABLED, 15, CSP, 3000, start, 0, 0)
    bus.counters.clear()
    worst = 0
    target = start
    for _ in range(RAMP):
        target += STEP
        positions = [inputs[3] for inputs in bus.exchange(15, CSP, 3000, target, 0, 0)]
        worst = max(worst, *(abs(target - position) for position in positions))
    for _ in range(50):
        inputs = bus.exchange(15, CSP, 3000, target, 0, 0)
    report["worst"] = worst
    report["way"] = target - start
    report["rest"] = [target - each[3] for each in inputs]
    report["mode"] = [each[2] for each in inputs]
    for _ in range(int(sys.argv[4]) - RAMP - 50):
        bus.send()
    report["counters"] = sorted(bus.counters)
    bus.watchdog(DEFAULT)
    time.sleep(0.15)
    master.read_state()
    report["silent"] = [[drive.state, drive.al_status] for drive in bus.drives]
    bus.send()
    report["fault"] = [each[1] & FAULT_STATE for each in bus.inputs()]
    report["603Fh"] = [each[0] for each in bus.inputs()]
    for drive in bus.drives:
        drive.sdo_read(0x603F, 0)
        drive.mbx_receive()
    report["emergencies"] = emergencies
    report["acknowledged"] = bus.go(pysoem.SAFEOP_STATE | pysoem.STATE_ACK)
    report["recovered"] = bus.go(pysoem.OP_STATE)
    until(bus, FAULT, 0, CSP, 3000, target, 0, 0, mask=FAULT_STATE)
    report["reset"] = until(bus, DISABLED, 0x80, CSP, 3000, target, 0, 0, mask=FAULT_STATE)
    here = bus.inputs()[0][3]
    until(bus, READY, 6, CSP, 3000, here, 0, 0)
    report["again"] = until(bus, ENABLED, 15, CSP, 3000, here, 0, 0)
    until(bus, DISABLED, 0, CSP, 3000, here, 0, 0, mask=FAULT_STATE)


def remap(master: Any, report: Report) -> None:
    """607Fh is added to 1600h as in the manual's example; then 607Fh is the last output."""
    find(master, report)
    drive = master.slaves[0]
    for index, subindex, data in (
        (0x1C12, 0, b"\0"),
        (0x1600, 0, b"\0"),
        (0x1600, 7, struct.pack("<I", 0x607F0020)),
        (0x1600, 0, b"\7"),
        (0x1C12, 1, struct.pack("<H", 0x1600)),
        (0x1C12, 0, b"\1"),
    ):
        drive.sdo_write(index, subindex, data)
    master.config_map()
    report["sizes"] = [[len(each.output), len(each.input)] for each in master.slaves]
    report["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 500_000)
    report["in SafeOp"] = abort_of(lambda: drive.sdo_write(0x1C12, 0, b"\0"))
    bus = Bus(master, OUTPUTS, INPUTS)
    for each in master.slaves:
        each.output = OUTPUTS.pack(0, CSP, 3000, 0, 0, 0)
    drive.output = OUTPUTS.pack(0, CSP, 3000, 0, 0, 0) + struct.pack("<I", 4711)
    report["op"] = bus.go(pysoem.OP_STATE)
    for _ in range(20):
        bus.send()
        time.sleep(0.002)
    report["607Fh"] = number(drive, 0x607F)


if __name__ == "__main__":
    run({"move": move, "remap": remap})
