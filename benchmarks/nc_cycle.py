"""Cost of one NC cycle, every axis moving: the plain kernel beside the compiled one.

Each axis runs long jerk-limited moves, back and forth, so that planning is in the numbers as often
as an axis of that kind plans. "real time" is how many times faster than a 2 ms cycle that is.
Usage: python benchmarks/nc_cycle.py [SECONDS_PER_ROW]
"""

import random
import statistics
import sys
import time

from achse.motion import AxisParameters, Nc, commands
from achse.native.compiled import compiler_installed

CYCLE_NS = 2_000_000
CHUNK = 25
"""Cycles between two looks whether an axis needs its next move; not timed."""


def moving(count: int, *, compiled: bool) -> Nc:
    """An NC whose axes all move."""
    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    nc = Nc(
        CYCLE_NS,
        [AxisParameters(number, values=presets) for number in range(1, count + 1)],
        compiled=compiled,
    )
    nc.cycle()
    keep_moving(nc, random.Random(1))
    return nc


def keep_moving(nc: Nc, dice: random.Random) -> None:
    """Give each axis without a job its next one."""
    for axis in nc:
        if axis.set_motion_phase == 0:
            commands.start(axis, 1, dice.uniform(-1000.0, 1000.0), dice.uniform(100.0, 1000.0))


def cost(nc: Nc, seconds: float) -> tuple[float, float, float]:
    """Mean, median and 99 % quantile of a cycle in microseconds; chunks are the samples."""
    dice = random.Random(2)
    samples = []
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or len(samples) < 3:
        begin = time.perf_counter_ns()
        for _ in range(CHUNK):
            nc.cycle()
        samples.append((time.perf_counter_ns() - begin) / CHUNK / 1000.0)
        keep_moving(nc, dice)
    late = sorted(samples)[int(0.99 * (len(samples) - 1))]
    return statistics.fmean(samples), statistics.median(samples), late


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    print(f"{'axes':>5} {'kernel':>9} {'mean µs':>9} {'median':>9} {'99 %':>9}", end="")
    print(f" {'ns/axis':>9} {'real time':>10}")
    for count in (1, 4, 50, 255):
        for compiled in (False, True):
            if compiled and not compiler_installed():
                continue
            nc = moving(count, compiled=compiled)
            mean, median, late = cost(nc, seconds)
            name = "compiled" if compiled else "plain"
            print(f"{count:>5} {name:>9} {mean:>9.2f} {median:>9.2f} {late:>9.2f}", end="")
            print(f" {1000.0 * mean / count:>9.0f} {CYCLE_NS / 1000.0 / mean:>9.0f}×")


if __name__ == "__main__":
    main()
