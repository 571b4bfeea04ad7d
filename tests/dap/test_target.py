"""What an editor debugs: a station of its own, or one that runs."""

import asyncio
from pathlib import Path

import pytest

from achse.dap.target import Target, TargetError
from achse.station import Station
from achse.station.configuration.station_file import parse


def test_a_station_of_its_own_begins_on_request(project: Path) -> None:
    async def main() -> None:
        target = Target(
            {"program": str(project), "tcpPort": 0, "speed": 100, "libraries": []}, launch=True
        )
        await target.open()
        assert (await target.link.state())["state"] == "run"
        await target.start()
        assert target.message.startswith("station 127.0.0.1.1.1 at 127.0.0.1:")
        assert not target.ended.is_set()
        await target.close()

    asyncio.run(main())


def test_a_station_that_runs(project: Path) -> None:
    async def main() -> None:
        station = Station(parse({"plc": [{"sources": str(project)}]}, "test"))
        async with station.running("127.0.0.1", 0, speed=0) as running:
            target = Target(
                {"host": running.host, "tcpPort": running.tcp_port, "plc": 851}, launch=False
            )
            await target.open()
            assert (await target.link.state())["port"] == 851
            await target.start()
            assert target.message == ""
            await target.close()

    asyncio.run(main())


@pytest.mark.parametrize(
    "settings",
    [{}, {"program": 5}, {"program": "nowhere"}, {"program": ".", "libraries": "x"}],
)
def test_settings_that_lead_nowhere(settings: dict[str, object]) -> None:
    with pytest.raises(TargetError):
        asyncio.run(Target(settings, launch=True).open())
