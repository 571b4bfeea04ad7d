"""What snapshots of persistent data cost: the loop, the thread that writes, a whole station.

For data of several sizes: microseconds that the loop waits for an image and its comparison, and for
a snapshot the processor time and the time until it is on the disk of FOLDER. Then the share of a
core of a station in real time whose data change in each cycle, by interval.
Usage: python benchmarks/snapshots.py [SECONDS] [FOLDER]   (default: 2 s for each, a temporary one)
"""

import asyncio
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.station.persistence.persistent_image import (
    PersistentImage,
    PersistentLayout,
    PersistentValues,
)
from achse.station.persistence.snapshot_file import SnapshotFile
from achse.station.persistence.snapshots import Snapshots

TURNS = 40
PLC = """
PROGRAM MAIN
VAR PERSISTENT nTotal : LINT; aBulk : ARRAY [0..{last}] OF LINT; END_VAR
nTotal := nTotal + 1;
END_PROGRAM
"""


def station(folder: Path, numbers: int, axes: int, interval: str = "100ms") -> Station:
    (folder / "a.st").write_text(PLC.replace("{last}", str(numbers)))
    document: dict[str, Any] = {
        "system": {"persistent_data": "kept.json", "persistent_data_interval": interval},
        "plc": [{"sources": "a.st"}],
        "axis": [{"id": number, "name": f"A{number}"} for number in range(1, axes + 1)],
    }
    return Station(parse(document, ""), base=folder)


def of_snapshots(folder: Path) -> None:
    for name, numbers, axes in (
        ("1 variable", 1, 0),
        ("64 kB", 8192, 0),
        ("1 MB", 131072, 0),
        ("255 axes", 1, 255),
    ):
        built = station(folder, numbers, axes)
        layout = PersistentLayout.of(built.nc, built.plcs, PersistentValues())
        snapshots = Snapshots(SnapshotFile(folder / "kept.snapshot"), 0.1)
        last = PersistentImage(layout, layout.image(built.nc, built.plcs), 0)
        snapshots.write(last)
        waits, busy, until = [], [], []
        for _ in range(TURNS):
            began = time.perf_counter()
            image = PersistentImage(layout, layout.image(built.nc, built.plcs), 0)
            assert image.is_like(last)
            taken, used = time.perf_counter(), time.thread_time()
            snapshots.write(image)
            busy.append(time.thread_time() - used)
            until.append(time.perf_counter() - taken)
            waits.append(taken - began)
        loop, thread, disk = (1e6 * statistics.median(each) for each in (waits, busy, until))
        print(f"{name:<12} loop {loop:6.0f} µs   thread {thread:6.0f} µs   on disk {disk:7.0f} µs")


async def share(folder: Path, interval: str, seconds: float) -> float:
    built = station(folder, 512, 1, interval)
    async with built.running("127.0.0.1", 0):
        await asyncio.sleep(0.3)
        began, used = time.perf_counter(), time.process_time()
        await asyncio.sleep(seconds)
        return (time.process_time() - used) / (time.perf_counter() - began)


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    with tempfile.TemporaryDirectory(dir=sys.argv[2] if len(sys.argv) > 2 else None) as name:
        of_snapshots(Path(name))
        for interval in ("0s", "1s", "100ms", "10ms"):
            part = asyncio.run(share(Path(name), interval, seconds))
            print(f"station, interval {interval:<6} {part:7.2%} of a core")


if __name__ == "__main__":
    main()
