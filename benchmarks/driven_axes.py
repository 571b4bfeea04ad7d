"""Axes on virtual drives in virtual time: how many times faster than the clock a station runs.

Four axes on csp drives behind the EtherCAT master, all moving, cycle 2 ms. "kernel" does the cycles
in which nothing but valid process data travels without frames, "frames" does all by frames; both
leave the same state, which is printed as a hash.
Usage: python benchmarks/driven_axes.py [SECONDS_OF_STATION_TIME [AXES]]
"""

import sys
import time

from achse.codes.axis import StartType
from achse.motion import commands
from achse.native.backend import compiler_installed
from achse.station.buses.whole_cycle import KERNEL
from achse.station.configuration.station_file import parse
from achse.station.station import Station


def station(axes: int) -> Station:
    """A station whose axes are enabled."""
    dynamics = {"max_velocity": 400.0, "default_acceleration": 2000.0,
                "default_deceleration": 2000.0, "default_jerk": 20_000.0}  # fmt: skip
    document = {
        "bus": [{}],
        "axis": [{"id": n, "name": f"A{n}", **dynamics} for n in range(1, axes + 1)],
        "drive": [{"axis": n} for n in range(1, axes + 1)],
    }
    running = Station(parse(document, "benchmark"))
    assert running.nc is not None
    for axis in running.nc:
        axis.control_dword, axis.velocity_override = 7, 1_000_000
    running.advance(2.0)
    return running


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    axes = int(sys.argv[2]) if len(sys.argv) > 2 else 4
    if compiler_installed():
        _ = KERNEL.function
    for name, allowed in (("kernel", True), ("frames", False)):
        driven = station(axes)
        shortcut = driven.buses[0].shortcut
        assert driven.nc is not None
        assert shortcut is not None
        shortcut.allowed &= allowed
        for axis in driven.nc:
            code = commands.start(axis, StartType.ABSOLUTE, 300.0 * seconds, 200.0)
            assert code == 0, hex(code)
        wall, used = time.perf_counter(), time.process_time()
        driven.advance(seconds)
        wall, used = time.perf_counter() - wall, time.process_time() - used
        print(
            f"{axes} axes on drives, {name}: {seconds / wall:6.1f} × real time, "
            f"{seconds / used:6.1f} × of processor time, state {driven.digest()}",
            flush=True,
        )


if __name__ == "__main__":
    main()
