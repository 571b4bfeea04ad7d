"""A station in operation: its end, its failures and what is left of it."""

import asyncio
import math
from typing import Any

import pytest

from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace


@pytest.mark.parametrize("speed", [math.inf, 50.0])
def test_a_running_station_ends_at_its_time(speed: float) -> None:
    async def main() -> Station:
        station = Station.demo()
        async with station.running("127.0.0.1", 0, speed=speed, until=0.5) as running:
            assert running.host == "127.0.0.1"
            assert running.tcp_port > 0
            await running.finished()
        return station

    ended, stepped = asyncio.run(main()), Station.demo()
    stepped.advance(0.5)
    assert ended.time_ns == stepped.time_ns
    assert ended.digest() == stepped.digest()


@pytest.mark.parametrize("speed", [math.inf, 1.0])
def test_leaving_ends_the_cycle_and_leaves_no_task(speed: float) -> None:
    async def main() -> set[asyncio.Task[Any]]:
        station = Station.demo()
        async with station.running("127.0.0.1", 0, speed=speed):
            await asyncio.sleep(0)
        await asyncio.sleep(0)
        return asyncio.all_tasks() - {asyncio.current_task()}

    assert asyncio.run(main()) == set()


@pytest.mark.parametrize("speed", [math.inf, 50.0])
def test_a_broken_phase_is_reported(speed: float, caplog: pytest.LogCaptureFixture) -> None:
    def broken(now: int) -> None:
        raise ArithmeticError(f"at {now}")

    async def main() -> None:
        station = Station.demo()
        station.cycle.add(CyclicPhase(PhasePlace.SCOPE, "broken", 10_000_000, broken))
        async with station.running("127.0.0.1", 0, speed=speed) as running:
            with pytest.raises(ArithmeticError, match="at 10000000"):
                await running.finished()

    asyncio.run(main())
    assert "the station's cycle broke: ArithmeticError('at 10000000')" in caplog.text


def test_a_tcp_port_that_is_taken_is_an_error() -> None:
    async def main() -> None:
        first, second = Station.demo(), Station.demo()
        async with first.running("127.0.0.1", 0, speed=math.inf) as running:
            with pytest.raises(OSError, match=r"in use|failed"):
                async with second.running("127.0.0.1", running.tcp_port):
                    pass

    asyncio.run(main())


@pytest.mark.parametrize("speed", [0.0, 100.0, math.inf])
def test_a_running_station_is_finished_when_it_is_shut_down(speed: float) -> None:
    async def main() -> None:
        station = Station.demo()
        async with station.running("127.0.0.1", 0, speed=speed) as running:
            station.shut_down()
            if not speed:
                station.advance(0.01)
            await running.finished()

    asyncio.run(main())


async def test_stamps_are_of_the_wall_clock_before_the_first_cycle() -> None:
    """So they are for a client that connects while the network opens."""
    station = Station.demo()
    clock = station.clock
    clock.time_of_day = lambda: clock() if station.listeners else clock.epoch_ns + 17_000_000_000
    begin_ns = clock.epoch_ns
    async with station.running("127.0.0.1", 0, speed=1.0):
        assert clock.epoch_ns == begin_ns + 17_000_000_000
