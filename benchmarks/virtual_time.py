"""Virtual time: how much faster than the wall clock the demo station runs without clients.

Usage: python benchmarks/virtual_time.py [SECONDS]
"""

import statistics
import struct
import sys
import time

from achse.station import Station


def factor(seconds: float, moving: bool) -> float:
    """Station seconds per wall-clock second, idle or with all axes on an endless move."""
    station = Station.demo()
    nc = next(device for device in station.devices if 0x4201 in device.services.by_index)
    if moving:
        for axis in (1, 2, 3):
            nc.write(0x4300 + axis, 0x01, struct.pack("<I", 7))
            nc.write(0x4300 + axis, 0x21, struct.pack("<I", 1_000_000))
        station.advance(0.1)
        for axis in (1, 2, 3):
            nc.write(0x4200 + axis, 0x20, struct.pack("<I4xdd", 3, 0.0, 100.0))
    start = time.perf_counter()
    station.advance(seconds)
    return seconds / (time.perf_counter() - start)


def main(seconds: float = 20.0) -> None:
    print(f"demo station, 3 axes at 2 ms, PLC at 10 ms; median of 5 runs of {seconds:g} s")
    for name, moving in (("axes at rest", False), ("axes moving", True)):
        rates = [factor(seconds, moving) for _ in range(5)]
        print(f"  {name:14} {statistics.median(rates):8.0f} × real time")


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
