"""Our client and a station over serial ports that socat links."""

import asyncio
import contextlib
import os
from asyncio.subprocess import Process
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

from achse.client import connect
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.transport.lines import until

PORTS = ("one", "other")


@asynccontextmanager
async def linked(folder: Path) -> AsyncIterator[tuple[str, str, Process]]:
    one, other = (str(folder / name) for name in PORTS)
    ends = [f"pty,raw,echo=0,link={name}" for name in (one, other)]
    socat = await asyncio.create_subprocess_exec("socat", *ends)
    try:
        await until(lambda: os.path.exists(one) and os.path.exists(other))
        yield one, other, socat
    finally:
        with contextlib.suppress(ProcessLookupError):
            socat.kill()
        await socat.wait()


async def test_a_client_reads_writes_and_subscribes(
    witness: Callable[[str], None], tmp_path: Path
) -> None:
    witness("socat")
    async with linked(tmp_path) as (one, other, _):
        document = {
            "serial": [{"port": one, "baud": 115_200}],
            "plc": [{"globals": ["achse.station.demo:GVL"]}],
        }
        station = Station(parse(document, "a.toml"), base=tmp_path)
        async with (
            station.running("127.0.0.1", 0),
            connect(f"serial:{other}?baud=115200") as plc,
        ):
            assert await plc.read("GVL.sString") == "axis"
            async with plc.subscribe("GVL.nInt", cycle_time=0.01) as samples:
                await anext(samples)
                await plc.write("GVL.nInt", 12)
                assert (await anext(samples)).value == 12


async def test_a_cable_that_is_pulled_is_reported_and_back_again(
    witness: Callable[[str], None], tmp_path: Path
) -> None:
    """socat ends, which is a USB adapter pulled out; both ends open their ports again."""
    witness("socat")
    async with linked(tmp_path) as (one, other, socat):
        document = {
            "serial": [{"port": one}],
            "plc": [{"globals": ["achse.station.demo:GVL"]}],
        }
        station = Station(parse(document, "a.toml"), base=tmp_path)
        async with station.running("127.0.0.1", 0), connect(f"serial:{other}", timeout=3600) as plc:
            assert await plc.read("GVL.nInt") == -16
            losses = plc.session.losses
            socat.kill()
            await until(lambda: plc.session.losses > losses)
            async with linked(tmp_path):
                assert await plc.read("GVL.nInt") == -16
