"""Clocks that a test moves."""

import asyncio

import pytest

from achse.testing import ManualClock, VirtualTimeLoop


def test_a_manual_clock_stands_until_it_is_moved() -> None:
    clock = ManualClock(5)
    assert (clock(), clock()) == (5, 5)
    assert clock.advance(0.001) == clock() == 1_000_005
    with pytest.raises(ValueError, match="forward"):
        clock.advance(-1)


def test_an_hour_takes_no_time() -> None:
    async def hours() -> list[str]:
        order = []

        async def after(seconds: float) -> None:
            await asyncio.sleep(seconds)
            order.append(f"{asyncio.get_running_loop().time():g}")

        await asyncio.gather(after(7200), after(3600), after(0.5))
        return order

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        assert runner.run(hours()) == ["0.5", "3600", "7200"]


def test_endless_waiting_is_an_error() -> None:
    loop = VirtualTimeLoop()
    never = loop.create_future()
    with pytest.raises(RuntimeError, match="deadlock"):
        loop.run_until_complete(never)
    loop.close()
