"""Stations in slices: the same state as in one piece, and what ends a run."""

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.mcp.folder import ProjectFolder
from achse.mcp.stations import HandleError, OpenStations
from achse.station import Station


async def _nothing(passed: float) -> None:
    pass


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=12)
@given(parts=st.lists(st.floats(0, 0.2), min_size=1, max_size=4))
def test_slices_give_the_state_that_one_piece_gives(folder: Path, parts: list[float]) -> None:
    async def run() -> str:
        async with OpenStations(ProjectFolder(folder)) as stations:
            opened = await stations.start(folder / "machine.toml")
            for part in parts:
                report, _ = await opened.run(part, (), _nothing)
                assert report.reason == "done"
            station = opened.station
            whole = Station(station.config, base=folder)
            whole.advance(station.time_ns / 1e9)
            assert whole.time_ns == station.time_ns
            return station.digest() if whole.digest() == station.digest() else ""

    assert asyncio.run(run())


def test_a_call_ends_at_its_time_limit(folder: Path) -> None:
    async def run() -> None:
        async with OpenStations(ProjectFolder(folder)) as stations:
            opened = await stations.start(folder / "machine.toml")
            report, _ = await opened.run(3600.0, (), _nothing, wall=0.0)
            assert report.reason == "time limit"
            assert 0 < report.passed_s < 3600

    asyncio.run(run())


def test_a_ninth_station_takes_the_place_of_an_idle_one(folder: Path) -> None:
    async def run() -> None:
        async with AsyncExitStack() as stack:
            stations = await stack.enter_async_context(OpenStations(ProjectFolder(folder)))
            opened = [await stations.start(folder / "machine.st") for _ in range(8)]
            for one in opened[1:]:
                await stack.enter_async_context(one.in_use())
            await stations.start(folder / "machine.st")
            assert (await stations.station("s9")).handle == "s9"
            with pytest.raises(HandleError, match="no station 's1'"):
                await stations.station("s1")
            ninth = await stations.station("s9")
            async with ninth.in_use():
                with pytest.raises(HandleError, match="8 stations are in use"):
                    await stations.start(folder / "machine.st")

    asyncio.run(run())


def test_only_the_newest_recordings_are_kept(folder: Path) -> None:
    async def run() -> None:
        async with OpenStations(ProjectFolder(folder)) as stations:
            opened = await stations.start(folder / "machine.st")
            from achse.scope.channel import channel_of

            channel = channel_of("MAIN.nCount")
            for _ in range(17):
                _, recording = await opened.run(0.02, (channel,), _nothing)
                assert recording is not None
                stations.keep(recording)
            assert stations.runs == [f"r{number}" for number in range(2, 18)]
            with pytest.raises(HandleError):
                stations.recording("r1")

    asyncio.run(run())
