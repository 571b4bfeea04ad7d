"""A station between both ends of a line, while cables are cut: `achse_ring.py INTERFACE MS`.

The slaves are `achse drive serve` on two interfaces. Axes move, one link after the other goes away
and comes back; then both are away. JSON on stdout: for each interface the state of the bus while
its link is away, what the log and ADS told, whether the axes moved on, and their errors; and their
errors with both links away, and whether they came where they should afterwards.
"""

import asyncio
import json
import logging
import subprocess
import sys
from typing import Any

from achse_station import DYNAMICS, FAR, Axes, until

import achse
from achse.ams import NetId
from achse.client.nc.errors import AxisError
from achse.station import Station
from achse.station.configuration.station_file import parse

SECOND, FAR_SECOND = "cable2", "cable3"
LINK, SECOND_LINK, OPEN = 0x0001, 0x0004, 0x0008
EXPECTED = {
    **dict.fromkeys((FAR, "cable0"), LINK | OPEN),
    **dict.fromkeys((FAR_SECOND, SECOND), SECOND_LINK | OPEN),
}
"""The state of the bus when an interface is down."""
TRIES = 20
AWAY_S = 0.5


def set_link(interface: str, state: str) -> None:
    subprocess.run(["ip", "link", "set", interface, state], check=True)


def slaves() -> subprocess.Popen[str]:
    """Two drives between the far ends of two cables."""
    end = ("link", "add", SECOND, "type", "veth", "peer", "name", FAR_SECOND)
    subprocess.run(["ip", *end], check=True)
    for each in (SECOND, FAR_SECOND):
        set_link(each, "up")
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "achse", "drive", "serve", "--count", "2"),
            *("--interface", FAR, "--interface", FAR_SECOND, "--control", "none"),
        ],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline().startswith("achse drive ready")
    return process


async def cut_one(axes: Axes, bus: Any, interface: str) -> dict[str, Any]:
    """One link is away while the axes move."""
    report: dict[str, Any] = {}
    for _ in range(TRIES):
        await axes.reach(0.0)
        try:
            await axes.start(200.0)
        except AxisError:
            continue
        set_link(interface, "down")

        async def state() -> int:
            return int.from_bytes(await bus.read_raw(0x45, 0, 2), "little")

        async def reported() -> bool:
            return bool(await state() & OPEN)

        await until(reported)
        before = await axes.position(1)
        await asyncio.sleep(AWAY_S)
        report = {
            "state": await state(),
            "opening": (await bus.read_raw(0x102, 3, 256)).rstrip(b"\0").decode(),
            "moved": await axes.position(1) > before + 1.0,
            "errors": await axes.errors(),
        }
        set_link(interface, "up")
        await until(axes.bus_is_well)
        if not any(report["errors"]) and report["state"] == EXPECTED[interface]:
            break  # else the machine was busy for longer than the watchdogs
    return report


async def cut_both(axes: Axes) -> dict[str, Any]:
    """Both links are away: an error of the axes, which the documented steps end."""
    await axes.reach(0.0)
    await axes.start(200.0)
    for each in (FAR, FAR_SECOND):
        set_link(each, "down")

    async def failed() -> bool:
        return all(await axes.errors())

    await until(failed)
    errors = await axes.errors()
    for each in (FAR_SECOND, FAR):
        set_link(each, "up")
    return {"errors": errors, "recovered": await axes.reach(10.0)}


async def run(interface: str) -> dict[str, Any]:
    document = {
        "bus": [{"interface": interface, "redundant": SECOND}],
        "axis": [{"id": n, "name": f"A{n}", **DYNAMICS} for n in (1, 2)],
        "drive": [{"axis": n} for n in (1, 2)],
    }
    station = Station(parse(document, "test"))
    async with station.running("127.0.0.1", 0) as running:
        async with achse.connect(f"127.0.0.1:{running.tcp_port}", port=501) as nc:
            bus = nc.at_port(0xFFFF, NetId(station.router.net_id[:4] + b"\x02\x01"))
            axes = Axes(nc, bus)
            report = {each: await cut_one(axes, bus, each) for each in EXPECTED}
            report["both"] = await cut_both(axes)
        report["statistics"] = station.statistics()["buses"][0]
    return report


def main() -> None:
    logging.basicConfig(level=logging.WARNING)
    process = slaves()
    try:
        report = asyncio.run(run(sys.argv[1]))
    finally:
        process.terminate()
        process.communicate()
    print(json.dumps(report))


if __name__ == "__main__":
    main()
