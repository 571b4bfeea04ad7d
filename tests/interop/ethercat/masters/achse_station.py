"""A station whose bus is on an interface, and what happens to it: `achse_station.py INTERFACE MS`.

Slaves are a process of their own at the other end. In each situation axes move, something breaks,
their errors are read over ADS (TCP), it is mended, and the axes are reset and move again. JSON on
stdout: for each situation the errors of both axes, and whether they came where they should.
"""

import asyncio
import json
import logging
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import achse
from achse.ams import NetId
from achse.client import Client
from achse.client.nc.errors import AxisError
from achse.station import Station
from achse.station.configuration.station_file import parse

HERE = Path(__file__).parents[1]
FAR = "cable1"
DYNAMICS = {"max_velocity": 400.0, "default_acceleration": 2000.0, "default_deceleration": 2000.0,
            "default_jerk": 20_000.0}  # fmt: skip
PROGRAM = """
PROGRAM MAIN
VAR
    bLamp AT %QX20.5 : BOOL;
    bEcho AT %IX10.5 : BOOL;
END_VAR
END_PROGRAM
"""
INVALID, NOT_READY = 0x4655, 0x4650
ERROR_OF = {"cable": INVALID, "killed": INVALID, "safeop": INVALID, "alarm": NOT_READY}


_OP = 8
_PATIENCE = 100
"""Looks at a bus that is not well, until Op is requested again."""


class Line:
    """The process with the slaves."""

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, str(HERE / "drives_and_terminals.py"), FAR],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"

    def say(self, word: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(word + "\n")
        self.process.stdin.flush()

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


async def until(condition: Callable[[], Any]) -> None:
    """Wait for what a coroutine or a function says."""
    while True:
        outcome = condition()
        if await outcome if asyncio.iscoroutine(outcome) else outcome:
            return
        await asyncio.sleep(0.02)


class Axes:
    """Both axes over ADS, and the master of their bus."""

    def __init__(self, nc: Client, bus: Any) -> None:
        self._nc, self._bus = nc, bus
        self._looks = 0

    async def errors(self) -> list[int]:
        codes = [await self._nc.read_raw(0x4100 + n, 0x01, 4) for n in (1, 2)]
        return [int.from_bytes(each, "little") for each in codes]

    async def position(self, axis: int) -> float:
        return await self._nc.nc.axis(axis).position()

    async def bus_is_well(self) -> bool:
        """DevState of the bus: no link error, all slaves in Op.

        A slave whose synchronization a busy machine has spoiled three times is left where it is: Op
        is requested now and then, as by a user.
        """
        if await self._bus.read_raw(0x45, 0, 2) == bytes(2):
            return True
        self._looks += 1
        if self._looks % _PATIENCE == 0:
            await self._bus.write_raw(0x03, _OP, b"")
        return False

    async def enable(self) -> None:
        """Wait for the bus; reset and enable, again if the machine was busy meanwhile."""
        while True:
            try:
                await until(self.bus_is_well)
                for n in (1, 2):
                    axis = self._nc.nc.axis(n)
                    await axis.reset()
                    await axis.enable()
                return
            except AxisError:
                await asyncio.sleep(0.2)

    async def start(self, target: float) -> None:
        for n in (1, 2):
            await self._nc.nc.axis(n).move_to(target, velocity=20.0, wait=False)

    async def reach(self, target: float) -> bool:
        """Move both there; again from the reset on if the machine was busy meanwhile."""
        while True:
            await self.enable()
            try:
                for n in (1, 2):
                    await self._nc.nc.axis(n).move_to(target, velocity=100.0)
                return True
            except AxisError:
                await asyncio.sleep(0.2)


def breaks(line: Line, situation: str) -> None:
    if situation == "cable":
        subprocess.run(["ip", "link", "set", FAR, "down"], check=True)
    elif situation == "killed":
        line.end()
    else:
        line.say({"safeop": "hang", "alarm": "alarm"}[situation])


def is_mended(line: Line, situation: str) -> None:
    if situation == "cable":
        subprocess.run(["ip", "link", "set", FAR, "up"], check=True)
    elif situation == "killed":
        line.start()
    else:
        line.say("mend")


async def go_through(axes: Axes, line: Line, situation: str) -> dict[str, Any]:
    """Break, see the error over ADS, mend, reset, move."""
    expected = ERROR_OF[situation]
    await axes.reach(0.0)
    for _ in range(20):
        await axes.start(200.0)
        breaks(line, situation)

        async def failed() -> bool:
            errors = await axes.errors()
            return all(errors) if situation in ("cable", "killed") else bool(errors[0])

        await until(failed)
        errors = await axes.errors()
        is_mended(line, situation)
        if errors[0] == expected:
            break
        await axes.enable()  # the machine was busy, and that was an error before ours
    return {"errors": errors, "recovered": await axes.reach(10.0)}


async def run(interface: str, station: Station, line: Line) -> dict[str, Any]:
    report: dict[str, Any] = {}
    async with station.running("127.0.0.1", 0) as running:
        where = f"127.0.0.1:{running.tcp_port}"
        async with (
            achse.connect(where, port=501) as nc,
            achse.connect(where, port=851) as plc,
        ):
            net_id = station.router.net_id[:4] + b"\x02\x01"
            axes = Axes(nc, nc.at_port(0xFFFF, NetId(net_id)))
            await until(axes.bus_is_well)
            await plc.write("MAIN.bLamp", True)

            async def echoed() -> bool:
                return bool(await plc.read("MAIN.bEcho"))

            await until(echoed)
            report["echo"] = True
            for situation in ERROR_OF:
                report[situation] = await go_through(axes, line, situation)
        report["statistics"] = station.statistics()["buses"][0]
    return report


def main() -> None:
    interface = sys.argv[1]
    logging.basicConfig(level=logging.WARNING)
    line = Line()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "main.st").write_text(PROGRAM)
        document = {
            "plc": [{"sources": "main.st"}],
            "bus": [{"interface": interface}],
            "axis": [{"id": n, "name": f"A{n}", **DYNAMICS} for n in (1, 2)],
            "drive": [{"axis": n} for n in (1, 2)],
            "terminal": [{"name": "T", "input_address": 10, "output_address": 20}],
        }
        station = Station(parse(document, "test"), base=Path(folder))
        report = asyncio.run(run(interface, station, line))
    line.end()
    print(json.dumps(report))


if __name__ == "__main__":
    main()
