"""What a sample of a scope costs in the cycle, beside a loop in C, and a long recording.

Per channel-sample: values in memory by machine code, with a trigger on each of 64 channels, by
plain Python, values that are computed; and a bare loop that copies as many words, called as our
kernel is (C by gcc -O2, without gcc NumPy's `take`). Then a station with a PLC task of 1 ms whose
64 channels are recorded and read while they go, and how many samples were lost.
Usage: python benchmarks/scope.py [SECONDS [ROWS]]
"""

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

from achse import Station
from achse.native.backend import compiler_installed
from achse.native.memory import MemoryCell
from achse.scope import SCOPE_TYPES, Recorder, ScopeChannel, ScopeSource, definition_of

MS = 1_000_000
ROWS = 20_000
"""Samples of each channel, for one figure."""

BARE = """#include <stdint.h>
void copy(int64_t **places, int64_t count, int64_t *ring, int64_t row) {
    for (int64_t n = 0; n < count; n++) ring[row * count + n] = *places[n];
}"""


def recorder(channels: int, compiled: bool, triggers: bool, called: bool) -> Recorder:
    """Of LREALs that are in memory, or that a function gives."""
    memory = bytearray(8 * channels)
    type = SCOPE_TYPES["REAL64"]

    def bind(channel: ScopeChannel) -> ScopeSource:
        cell = MemoryCell(memory, 8 * int(channel.symbol), 8)
        return ScopeSource((lambda: cell()) if called else cell, type, MS)

    document = {
        "channels": [{"name": f"c{n}", "symbol": str(n)} for n in range(channels)],
        "triggers": [f"c{n} rising 1" for n in range(min(channels, 64))] if triggers else [],
        "record_length": 1.0,
    }
    return Recorder(definition_of(document), bind, compiled=compiled)


def nanoseconds(channels: int, count: int, **how: bool) -> float:
    """Per channel-sample, everything a cycle does for a scope included."""
    recording = recorder(channels, **how)
    recording.start(0)
    rows = count if how["compiled"] else count // 20
    begin = time.perf_counter()
    for now in range(MS, rows * MS, MS):
        if recording.due_ns <= now:
            recording.sample(now)
    return (time.perf_counter() - begin) / rows / channels * 1e9


def bare(channels: int, rows: int) -> tuple[str, float]:
    """The same words, copied and nothing else."""
    source = array("q", bytes(8 * channels))
    ring = array("q", bytes(8 * channels * 1000))
    name, take = _in_c(source, ring) if shutil.which("gcc") else _by_numpy(source, ring)
    begin = time.perf_counter()
    for row in range(rows):
        take(row % 1000)
    return name, (time.perf_counter() - begin) / rows / channels * 1e9


def _in_c(source: "array[int]", ring: "array[int]") -> tuple[str, Callable[[int], Any]]:
    count, address = len(source), source.buffer_info()[0]
    places = (ctypes.c_void_p * count)(*(address + 8 * n for n in range(count)))
    with tempfile.TemporaryDirectory() as folder:
        file, library = Path(folder, "bare.c"), Path(folder, "bare.so")
        file.write_text(BARE, encoding="utf-8")
        subprocess.run(
            ["gcc", "-O2", "-shared", "-fPIC", str(file), "-o", str(library)], check=True
        )
        copy = ctypes.PyDLL(str(library)).copy
    whole = ctypes.c_int64(count)
    to = ctypes.c_void_p(ring.buffer_info()[0])
    return "C", lambda row: copy(places, whole, to, ctypes.c_int64(row))


def _by_numpy(source: "array[int]", ring: "array[int]") -> tuple[str, Callable[[int], Any]]:
    import numpy

    rows = numpy.frombuffer(ring, numpy.int64).reshape(1000, -1)
    values, order = numpy.frombuffer(source, numpy.int64), numpy.arange(len(source))
    return "NumPy", lambda row: values.take(order, out=rows[row])


def long_recording(seconds: float) -> str:
    """64 channels at 1 ms in a station, read every 10 s of its time."""
    with tempfile.TemporaryDirectory() as folder:
        names = [f"n{n}" for n in range(64)]
        variables = " ".join(f"{name} : UDINT;" for name in names)
        body = " ".join(f"{name} := {name} + 1;" for name in names[:4])
        Path(folder, "main.st").write_text(
            f"PROGRAM MAIN VAR {variables} END_VAR {body} END_PROGRAM", encoding="utf-8"
        )
        Path(folder, "station.toml").write_text(
            '[[plc]]\nsources = "main.st"\n[[plc.task]]\ncycle = "1ms"\nprograms = ["MAIN"]\n',
            encoding="utf-8",
        )
        station = Station.load(Path(folder, "station.toml"))
        ring_s = 10.0
        seen, expected = 0, 0
        begin = time.perf_counter()
        with station.scope([f"MAIN.{name}" for name in names], length=ring_s) as scope:
            while expected < round(seconds * 1000):
                stretch = min(ring_s, seconds - expected / 1000)
                station.advance(stretch)
                expected += round(stretch * 1000)
                data = scope.data()
                last = data["MAIN.n0"].block.words[:: len(names)]
                fresh = [word for word in last if word > seen]
                seen += len(fresh) if fresh and fresh[0] == seen + 1 else 0
            ring = sum(8 * block.count * len(block.channels) for block in data.blocks)
        took = time.perf_counter() - begin
    return (
        f"{seconds:g} s of a station, 64 channels at 1 ms: {took:.1f} s,"
        f" {(expected - seen) * 64} samples lost, ring {ring / 1e6:.1f} MB"
    )


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    rows = int(sys.argv[2]) if len(sys.argv) > 2 else ROWS
    print("channels  compiled  triggers  plain  computed   bare    (ns per channel-sample)")
    for channels in (1, 64, 1024):
        fast = compiler_installed()
        cells = [
            nanoseconds(channels, rows, compiled=fast, triggers=False, called=False),
            nanoseconds(channels, rows, compiled=fast, triggers=True, called=False),
            nanoseconds(channels, rows, compiled=False, triggers=False, called=False),
            nanoseconds(channels, rows, compiled=fast, triggers=False, called=True),
        ]
        name, alone = bare(channels, rows)
        print(f"{channels:8} {' '.join(f'{cell:8.1f}' for cell in cells)} {alone:8.1f}  {name}")
    print(long_recording(seconds))


if __name__ == "__main__":
    main()
