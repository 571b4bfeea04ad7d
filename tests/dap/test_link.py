"""Asking the service: answers, refusals."""

import asyncio
from pathlib import Path

import pytest

import achse
from achse.codes.station import SERVICE_PORT
from achse.dap.link import DebugLink, DebugRefused
from achse.station import Station
from achse.station.configuration.station_file import parse


def test_answers_and_refusals(project: Path) -> None:
    station = Station(parse({"plc": [{"sources": str(project)}]}, "test"))

    async def main() -> None:
        async with achse.connect(station.router, port=SERVICE_PORT) as client:
            link = DebugLink(client, 851)
            assert (await link.state())["tasks"] == ["PlcTask"]
            assert await link.request("breaks") == []
            with pytest.raises(DebugRefused, match="no cycle is halted"):
                await link.request("go")

    asyncio.run(main())
