"""What one virtual drive costs per communication cycle, outputs and inputs included.

Both kernels, at 250 µs and 1 ms, moving in csp, standing and switched off; best of several runs.
Usage: python benchmarks/drive_step.py [CYCLES]
"""

import struct
import sys
import time

from achse.codes import AlState, AlStatus
from achse.drive import Drive
from achse.native.compiled import compiler_installed

OUTPUTS = struct.Struct("<HbHiHI")  # 1600h: controlword, mode, max torque, target, probe, outputs
CSP = 8


def started(compiled: bool) -> Drive:
    """A drive in Op with operation enabled."""
    drive = Drive(compiled=compiled)
    for state in (AlState.PREOP, AlState.SAFEOP, AlState.OP):
        drive.enter(state, 0, AlStatus.NO_ERROR)
    for word in (0x00, 0x06, 0x07, 0x0F, 0x0F):
        drive.write_outputs(OUTPUTS.pack(word, CSP, 3000, 0, 0, 0))
        drive.step(1_000_000)
    return drive


def cost(drive: Drive, cycle_ns: int, word: int, speed: int, cycles: int) -> float:
    """Microseconds per cycle, best of five; `speed` in inc per cycle."""
    best = float("inf")
    at = drive.record.position_demand
    for _ in range(5):
        frames = [OUTPUTS.pack(word, CSP, 3000, at + speed * n, 0, 0) for n in range(cycles)]
        at += speed * (cycles - 1)
        start = time.perf_counter()
        for frame in frames:
            drive.write_outputs(frame)
            drive.step(cycle_ns)
            drive.read_inputs()
        best = min(best, time.perf_counter() - start)
    return best / cycles * 1e6


def main() -> None:
    cycles = int(sys.argv[1]) if len(sys.argv) > 1 else 5_000
    for compiled in (False, True):
        if compiled and not compiler_installed():
            continue
        for cycle_ns in (250_000, 1_000_000):
            drive = started(compiled)
            figures = (
                cost(drive, cycle_ns, 0x0F, 200, cycles),
                cost(drive, cycle_ns, 0x0F, 0, cycles),
                cost(drive, cycle_ns, 0x00, 0, cycles),
            )
            kernel = "compiled" if compiled else "plain"
            print(
                f"{kernel:8} {cycle_ns / 1000:5.0f} µs cycle: "
                "moving {:5.2f}, standing {:5.2f}, off {:5.2f} µs".format(*figures)
            )


if __name__ == "__main__":
    main()
