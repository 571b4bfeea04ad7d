"""A sweep on all cores beside the same sweep in one process: how much of the cores is used.

Each run is a station with one axis that moves (the example of docs/how-to/sweep-a-scenario.md).
Efficiency is the time of all runs ÷ (workers × duration), the start and end of the cluster counted;
the digests must be equal. Other programs on the machine count as loss: measure on a quiet one.
Usage: python benchmarks/sweeps.py [RUNS] [WORKERS]
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import achse

SCENARIO = """
import asyncio
import random
import achse
from achse.station.configuration.station_file import parse

def run(*, velocity: float, seed: int) -> dict[str, float]:
    station = achse.Station(parse({"axis": [{"id": 1, "name": "X"}]}, "sweep"))
    target = 100 + random.Random(seed).uniform(-1, 1)

    async def move() -> dict[str, float]:
        async with achse.connect(station.router, advance=station.advance) as client:
            x = client.nc.axis("X")
            await x.enable()
            began = station.time_ns
            await x.move_to(target, velocity=velocity)
            return {"took": (station.time_ns - began) / 1e9}

    return asyncio.run(move())
"""


def main(runs: int, workers: int) -> None:
    seeds = max(runs // 4, 1)
    parameters = {"velocity": [50.0, 100.0, 150.0, 200.0]}
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "scenario.py"
        file.write_text(SCENARIO)
        start = time.perf_counter()
        many = achse.sweep(file, parameters, seeds=seeds, workers=workers)
        whole = time.perf_counter() - start
        start = time.perf_counter()
        one = achse.sweep(file, parameters, seeds=seeds, workers=0)
        alone = time.perf_counter() - start
    print(
        f"{len(many.rows)} runs: in one process {alone:.1f} s, by {workers} workers {whole:.1f} s"
    )
    print(f"efficiency {many.efficiency:.1%}, beside one process {alone / workers / whole:.1%}")
    print("digests", "equal" if many.digest == one.digest else "DIFFER", many.digest)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:] or ["1000", str(os.cpu_count() or 1)]))
