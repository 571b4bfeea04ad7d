"""Virtual time: how many times faster than the wall clock a station runs.

The demo station without clients, then four axes at 2 ms that a client in another process watches,
20 values of each every 10 ms, over TCP; the client takes what comes and looks at nothing. Beside
the rate by the clock stands that by the CPU time of the station, which other processes on the
machine slow down less.
Usage: python benchmarks/virtual_time.py [SECONDS] [RUNS]
"""

import asyncio
import multiprocessing
import socket
import statistics
import struct
import sys
import time
from typing import NamedTuple

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY
from achse.native.backend import compiler_installed
from achse.station import Station
from achse.station.configuration.station_file import parse

CYCLE_MS = 10
ON_CHANGE = 4
VALUES = (
    (0x01, 4), (0x0A, 8), (0x0B, 8), (0x0C, 4), (0x0D, 8), (0x0E, 8), (0x0F, 8), (0x10, 8),
    (0x11, 8), (0x12, 8), (0x13, 8), (0x14, 16), (0x15, 4), (0x16, 8), (0x17, 8), (0x1A, 8),
    (0x1D, 8), (0x1E, 8), (0x1F, 8), (0x20, 4),
)  # fmt: skip
"""Offset and size of the axis states that are watched."""


def move_all(station: Station, axes: range) -> None:
    """Enable the axes and send each on an endless move."""
    nc = next(device for device in station.devices if 0x4201 in device.services.by_index)
    for axis in axes:
        nc.write(0x4300 + axis, 0x01, struct.pack("<I", 7))
        nc.write(0x4300 + axis, 0x21, struct.pack("<I", 1_000_000))
    station.advance(0.1)
    for axis in axes:
        nc.write(0x4200 + axis, 0x20, struct.pack("<I4xdd", 3, 0.0, 100.0))


class Clocks(NamedTuple):
    """A number by the wall clock and by the CPU time of this process."""

    wall: float
    cpu: float

    def __str__(self) -> str:
        return f"{self.wall:8.0f} × real time, {self.cpu:8.0f} × CPU time"


def now() -> Clocks:
    return Clocks(time.perf_counter(), time.process_time())


def rates(seconds: float, begin: Clocks) -> Clocks:
    """Station seconds per second since `begin`."""
    end = now()
    return Clocks(seconds / (end.wall - begin.wall), seconds / (end.cpu - begin.cpu))


def median(runs: list[Clocks]) -> Clocks:
    return Clocks(*map(statistics.median, zip(*runs, strict=True)))


def alone(seconds: float, moving: bool) -> Clocks:
    """How fast, idle or with all axes on an endless move."""
    station = Station.demo()
    if moving:
        move_all(station, range(1, 4))
    start = now()
    station.advance(seconds)
    return rates(seconds, start)


def watch(port: int, net_id: str, ready: "multiprocessing.synchronize.Event") -> None:
    """Subscribe to all values of four axes, then take whatever comes until the station ends."""
    target, source = AmsAddress(f"{net_id}:501"), AmsAddress("127.0.0.1.1.2:40000")
    with socket.create_connection(("127.0.0.1", port)) as connection:
        for axis in range(1, 5):
            for offset, size in VALUES:
                body = ADD_NOTIFICATION_BODY.pack(
                    0x4100 + axis, offset, size, ON_CHANGE, 0, CYCLE_MS * 10_000
                )
                frame = Frame(target, source, Command.ADD_NOTIFICATION, invoke_id=1, data=body)
                connection.sendall(frame.encode_tcp())
        ready.set()
        while connection.recv(1 << 20):
            pass


async def watched(seconds: float, moving: bool, compiled: bool) -> Clocks:
    """How fast with a client."""
    axes = [{"id": n, "name": f"A{n}"} for n in range(1, 5)]
    code = "machine" if compiled else "plain"
    station = Station(parse({"axis": axes, "nc": {"cycle": "2ms", "code": code}}, "benchmark"))
    if moving:
        move_all(station, range(1, 5))
    ready = multiprocessing.Event()
    async with station.running("127.0.0.1", 0, speed=0) as running:
        client = multiprocessing.Process(
            target=watch, args=(running.tcp_port, str(station.router.net_id), ready), daemon=True
        )
        client.start()
        await asyncio.to_thread(ready.wait)
        await asyncio.sleep(0.5)  # until all are subscribed
        end = station.time_ns + round(seconds * 1e9)
        start = now()
        while station.time_ns < end:
            turn = time.perf_counter() + 0.02
            while station.time_ns < end and time.perf_counter() < turn:
                station.advance(0.1)
            await asyncio.sleep(0)
        clocks = rates(seconds, start)
    client.join()
    return clocks


def main(seconds: float = 20.0, count: float = 5) -> None:
    print(f"demo station, 3 axes at 2 ms, PLC at 10 ms; median of {count:g} runs of {seconds:g} s")
    for name, moving in (("axes at rest", False), ("axes moving", True)):
        runs = [alone(seconds, moving) for _ in range(int(count))]
        print(f"  {name:18} {median(runs)}")
    print(f"4 axes at 2 ms, a client watches {4 * len(VALUES)} values at {CYCLE_MS} ms")
    for compiled in (False, True)[: 1 + compiler_installed()]:
        for name, moving in (("at rest", False), ("moving", True)):
            runs = [asyncio.run(watched(seconds, moving, compiled)) for _ in range(int(count))]
            code = "machine" if compiled else "plain"
            print(f"  {code + ', ' + name:18} {median(runs)}")


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
