"""Cost of one NC cycle, every axis moving: the plain kernel, the compiled one, the same in C.

Each axis runs long jerk-limited moves, back and forth, so that planning is in the numbers as often
as an axis of that kind plans. "real time" is how many times faster than a 2 ms cycle that is. The
row "C" has the same instructions compiled by gcc -O2 (`as_c.py`), on the most axes; it is left out
without gcc and below 0.1 s per row. Its states are equal to ours, bit by bit.
The rows "cams": of 255 axes 128 follow 64 masters by a cyclic cam joined by a spline.
Usage: python benchmarks/nc_cycle.py [SECONDS_PER_ROW [MOST_CAM_ROWS]]
"""

import random
import statistics
import sys
import time
from collections.abc import Callable
from functools import cache, partial
from math import pi, sin
from typing import Any

import as_c

from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import AxisParameters, Nc, commands
from achse.motion.compiled import KERNEL
from achse.motion.states import CamInterpolation, SlaveType
from achse.motion.tables import TableParameters
from achse.native.backend import compiler_installed
from achse.native.kernels.translate import translate

CYCLE_NS = 2_000_000
MOST = 255
MASTERS = 64
SLAVES = 128
CAM_ROWS = (100, 10_000, 1_000_000)
CHUNK = 25
"""Cycles between two looks whether an axis needs its next move; not timed."""


def standing(count: int, *, compiled: bool) -> Nc:
    """An NC whose axes are ready."""
    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    nc = Nc(
        CYCLE_NS,
        [AxisParameters(number, values=presets) for number in range(1, count + 1)],
        compiled=compiled,
    )
    nc.cycle()
    return nc


def moving(count: int, *, compiled: bool) -> Nc:
    """An NC whose axes all move."""
    nc = standing(count, compiled=compiled)
    keep_moving(nc, random.Random(1))
    return nc


def keep_moving(nc: Nc, dice: random.Random) -> None:
    """Give each axis without a job its next one."""
    for axis in nc:
        if axis.set_motion_phase == 0:
            commands.start(axis, 1, dice.uniform(-1000.0, 1000.0), dice.uniform(100.0, 1000.0))


def following(rows: int, *, compiled: bool) -> Nc:
    """An NC of 255 axes, of which 128 follow 64 of the others by a spline through so many rows."""
    nc = standing(MOST, compiled=compiled)
    turn = [10.0 * sin(2.0 * pi * row / (rows - 1)) for row in range(rows)]
    places = [360.0 * row / (rows - 1) for row in range(rows)]
    nc.tables.add_configured(
        TableParameters(
            *(1, list(zip(places, turn, strict=True)), "", TableSubType.EQUIDISTANT_CYCLIC),
            TableType.CAMMING,
        )
    )
    cam = commands.CamDemand(1, CamInterpolation.SPLINE, master_absolute=1)
    for number in range(1, SLAVES + 1):
        slave, master = MASTERS + number, (number - 1) % MASTERS + 1
        refused = commands.couple_by_cam(nc.axis(slave), SlaveType.TABULAR, master, cam)
        assert refused == 0, f"axis {slave}: 0x{refused:X}"
    keep_moving(nc, random.Random(1))
    return nc


def cost(nc: Nc, seconds: float) -> tuple[float, float, float]:
    """Mean, median and 99 % quantile of a cycle in microseconds; chunks are the samples."""
    dice = random.Random(2)
    samples: list[float] = []
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or len(samples) < 3:
        begin = time.perf_counter_ns()
        for _ in range(CHUNK):
            nc.cycle()
        samples.append((time.perf_counter_ns() - begin) / CHUNK / 1000.0)
        keep_moving(nc, dice)
    late = sorted(samples)[int(0.99 * (len(samples) - 1))]
    return statistics.fmean(samples), statistics.median(samples), late


@cache
def program_in_c() -> Any:
    """The cycle, compiled by gcc."""
    kernel = translate(KERNEL.plain, KERNEL.layouts)  # type: ignore[arg-type]
    return as_c.compiled_by_gcc(kernel.assembly())


def in_c(make: Callable[[], Nc]) -> Nc:
    """An NC like this, by the program in C."""
    function = program_in_c()
    ours, theirs = make(), make()
    kinds: Any = KERNEL.function.argtypes  # type: ignore[attr-defined]  # of ctypes
    function.argtypes, function.restype = kinds, None
    arguments = zip(kinds, theirs.kernel_arguments, strict=False)
    theirs._cycles = partial(function, *(kind(value) for kind, value in arguments))
    for nc in (ours, theirs):
        nc.cycle(1000)
    assert ours.digest() == theirs.digest(), "the program in C computes something else"
    return theirs


def show(count: int, name: str, nc: Nc, seconds: float) -> None:
    mean, median, late = cost(nc, seconds)
    print(f"{count:>5} {name:>18} {mean:>9.2f} {median:>9.2f} {late:>9.2f}", end="")
    print(f" {1000.0 * mean / count:>9.0f} {CYCLE_NS / 1000.0 / mean:>9.0f}×")


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    most = int(sys.argv[2]) if len(sys.argv) > 2 else max(CAM_ROWS)
    print(f"{'axes':>5} {'kernel':>18} {'mean µs':>9} {'median':>9} {'99 %':>9}", end="")
    print(f" {'ns/axis':>9} {'real time':>10}")
    for count in (1, 4, 50, MOST):
        for compiled in (False, True):
            if compiled and not compiler_installed():
                continue
            name = "compiled" if compiled else "plain"
            show(count, name, moving(count, compiled=compiled), seconds)
    if compiler_installed() and as_c.gcc_installed() and seconds >= 0.1:
        show(MOST, "C", in_c(partial(moving, MOST, compiled=True)), seconds)
    for rows in CAM_ROWS if compiler_installed() else (100,):
        if rows > most:
            continue
        name = f"cams {rows:,}"
        if compiler_installed():
            show(MOST, name, following(rows, compiled=True), seconds)
        else:
            show(MOST, f"{name} plain", following(rows, compiled=False), seconds)
    if compiler_installed() and as_c.gcc_installed() and seconds >= 0.1:
        show(MOST, "cams 10,000 C", in_c(partial(following, 10_000, compiled=True)), seconds)


if __name__ == "__main__":
    main()
