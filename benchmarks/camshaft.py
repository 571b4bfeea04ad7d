"""What a cycle of a camshaft controller with 128 cams costs: plain, and as machine code.

Beside it a bare responder: the same 128 angles compared in a C loop (gcc -O2), without dead time,
hysteresis, strokes or monitoring; without gcc that line is left out. Then a station with four such
controllers at 1 ms, in virtual time.
Usage: python benchmarks/camshaft.py [CYCLES]
"""

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from achse import Station
from achse.camshaft import CAMS, CamController, CamEncoder
from achse.native.backend import compiler_installed
from achse.station.configuration.station_file import parse

BARE = """#include <math.h>
#include <stdint.h>
int64_t cams(double position, const double *starts, const double *ends, int64_t count) {
    double angle = fmod(position, 4096.0) * 360.0 / 4096.0;
    int64_t bits = 0;
    for (int64_t n = 0; n < count; n++)
        if (starts[n] <= angle && angle < ends[n]) bits |= (int64_t)1 << (n % 32);
    return bits;
}"""
KINDS = (1, 2, 3, 4)


def cam(number: int) -> dict[str, int]:
    """Cams of all kinds, all with dead time and hysteresis."""
    return {
        "type": KINDS[number % 4], "start": number, "end": number + 90, "track": number % 32,
        "dynamic": 1, "dead_time": 100, "hysteresis_on": 1, "hysteresis": 10,
    }  # fmt: skip


def measured(cycle: Callable[[float], object], cycles: int) -> float:
    """Microseconds per cycle, the best of five parts."""
    best, position = float("inf"), 0.0
    for _ in range(5):
        begin = time.perf_counter()
        for _ in range(max(cycles // 5, 1)):
            position += 41.0
            cycle(position)
        best = min(best, (time.perf_counter() - begin) / max(cycles // 5, 1))
    return best * 1e6


def controller(compiled: bool) -> Callable[[float], object]:
    cams = CamController(encoder=CamEncoder(4096.0), compiled=compiled)
    for number in range(1, CAMS + 1):
        cams.set_cam(number, cam(number))

    def cycle(position: float) -> int:
        cams.take_position(position)
        return cams.cycle()

    return cycle


def bare(folder: str) -> Callable[[float], object]:
    source, library = Path(folder, "cams.c"), Path(folder, "cams.so")
    source.write_text(BARE, encoding="utf-8")
    command = ["gcc", "-O2", "-shared", "-fPIC", str(source), "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    function = ctypes.PyDLL(str(library)).cams
    table = ctypes.c_double * CAMS
    starts, ends = table(*range(1, CAMS + 1)), table(*range(91, CAMS + 91))
    function.restype = ctypes.c_int64
    function.argtypes = [ctypes.c_double, table, table, ctypes.c_int64]
    return lambda position: function(position, starts, ends, CAMS)


def station(seconds: float) -> float:
    """Wall time for so many seconds of a station with four controllers of 128 cams at 1 ms."""
    cams = [
        {"type": "way", "start": n, "end": n + 90, "track": n % 32, "dynamic": True,
         "dead_time": 100, "hysteresis": 10} for n in range(CAMS)
    ]  # fmt: skip
    document = {
        "nc": {"cycle": "1ms"},
        "axis": [{"id": 1, "name": "C", "modulo": True}],
        "camshaft": [{"axis": "C", "cam": cams}] * 4,
    }
    running = Station(parse(document, "benchmark"))
    begin = time.perf_counter()
    running.advance(seconds)
    return time.perf_counter() - begin


def main() -> None:
    cycles = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    print(f"plain          {measured(controller(False), cycles // 20):8.1f} µs per cycle, 128 cams")
    if compiler_installed():
        print(f"machine code   {measured(controller(True), cycles):8.2f} µs per cycle, 128 cams")
    if shutil.which("gcc"):
        with tempfile.TemporaryDirectory() as folder:
            print(f"bare loop in C {measured(bare(folder), cycles):8.2f} µs per cycle, 128 angles")
    seconds = cycles / 10_000
    took = station(seconds)
    print(
        f"{seconds:g} s of a station, 4 controllers of 128 cams at 1 ms: {took:.2f} s,"
        f" {took / seconds:.1%} of the time"
    )


if __name__ == "__main__":
    main()
