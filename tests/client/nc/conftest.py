"""Axes of a station in this process, whose time passes while something waits for them."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

import achse
from achse.client import Client
from achse.client.nc import RemoteAxis
from achse.station import Station


class Bench:
    """A demo station in virtual time with one client; more of them by `connect`."""

    def __init__(self) -> None:
        self.station = Station.demo()
        self.hooks: list[Callable[[float], None]] = []
        """Called before each piece of time passes, with the station time in seconds."""
        self.client: Client
        self.axis: RemoteAxis

    def advance(self, seconds: float) -> None:
        for hook in self.hooks:
            hook(self.station.time_ns / 1e9)
        self.station.advance(seconds)

    def connect(self, **settings: Any) -> Any:
        return achse.connect(self.station.router, advance=self.advance, **settings)


def _run(test: Callable[[Bench], Awaitable[Any]], enabled: bool = True) -> Any:
    async def main() -> Any:
        bench = Bench()
        async with bench.connect() as bench.client:
            bench.axis = bench.client.nc.axis("X")
            if enabled:
                await bench.axis.enable()
            result = await test(bench)
        left = asyncio.all_tasks() - {asyncio.current_task()}
        assert not left, f"left running: {left}"
        return result

    return asyncio.run(main())


@pytest.fixture
def on_bench() -> Callable[..., Any]:
    """`on_bench(test)` runs `await test(bench)`, with the axis X enabled unless `enabled=False`."""
    return _run
