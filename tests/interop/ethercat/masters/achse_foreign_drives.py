"""A station enables and moves foreign drives: `achse_foreign_drives.py INTERFACE MS [KEY…]`.

KEY names what the drives leave out. JSON on stdout: for each axis where it came, or why it did not.
"""

import asyncio
import json
import sys
from typing import Any

import achse
from achse.ams import NetId
from achse.client.nc.errors import AxisError
from achse.station import Station
from achse.station.configuration.station_file import parse

COUNT = 2
TARGET = 50.0
DYNAMICS = {"max_velocity": 400.0, "default_acceleration": 500.0, "default_deceleration": 500.0,
            "default_jerk": 5000.0}  # fmt: skip
MAPPING = {"outputs": [0x6040, 0x607A, 0x60FF, 0x6060], "inputs": [0x6041, 0x6064, 0x606C, 0x6061]}


async def run(station: Station) -> list[Any]:
    positions: list[Any] = []
    async with station.running("127.0.0.1", 0) as running:
        where = f"127.0.0.1:{running.tcp_port}"
        async with achse.connect(where, port=501) as nc:
            bus = nc.at_port(0xFFFF, NetId(station.router.net_id[:4] + b"\x02\x01"))
            while True:
                if await bus.read_raw(0x45, 0, 2) == bytes(2):  # all slaves in Op
                    break
                await asyncio.sleep(0.05)
            for n in range(1, COUNT + 1):
                axis = nc.nc.axis(n)
                try:
                    await axis.enable(within=3.0)
                    await axis.move_to(TARGET, velocity=100.0)
                    positions.append(await axis.position())
                except AxisError as failure:
                    positions.append(str(failure))
    return positions


def main() -> None:
    interface, _, *left_out = sys.argv[1:]
    drive = MAPPING | dict.fromkeys(left_out, False)
    document = {
        "bus": [{"interface": interface}],
        "axis": [{"id": n, "name": f"A{n}", **DYNAMICS} for n in range(1, COUNT + 1)],
        "drive": [{"axis": n, **drive} for n in range(1, COUNT + 1)],
    }
    print(json.dumps(asyncio.run(run(Station(parse(document, "test"))))))


if __name__ == "__main__":
    main()
