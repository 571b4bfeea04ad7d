"""Samples of an axis: in virtual time, sent by the NC, and what ends them."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

import achse
from achse.ams import ConnectionLost, DeviceError, RequestTimeout
from achse.client.session.raw import RawTarget
from achse.station import Station
from achse.testing import LiveStation, VirtualTimeLoop


def test_a_trace_in_virtual_time(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        await bench.axis.move_to(100, velocity=200, wait=False)
        way = [(each.time, each.set_position) async for each in bench.axis.trace(0.01, 0.5)]
        assert [time for time, _ in way] == pytest.approx([n / 100 for n in range(51)])
        assert 0 < way[30][1] < way[50][1]

    on_bench(test)


@pytest.mark.parametrize(
    ("sample_time", "duration"),
    [(0, 1), (-1, 1), (float("nan"), 1), (1000, 1), (0.1, -1), (0.1, float("nan"))],
)
def test_times_that_are_none(
    on_bench: Callable[..., Any], sample_time: float, duration: float
) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(ValueError, match="got"):
            bench.axis.trace(sample_time, duration)

    on_bench(test)


def test_a_loop_that_is_left_early_ends_the_subscription() -> None:
    with LiveStation() as live, live.connect() as client:
        axis = client.nc.axis(1)
        for status in axis.trace(0.01):
            if status.time > 0.02:
                break
        with axis.trace(0.01, duration=0.05) as samples:
            assert len(list(samples)) == 6
            assert list(samples) == []
        assert not client._client.session._renewables


def test_an_nc_whose_time_stands_still_is_not_waited_for() -> None:
    async def main() -> None:
        station = Station.demo()
        async with achse.connect(station.router, timeout=0.1) as client:
            axis = client.nc.axis(1)
            with pytest.raises(RequestTimeout, match="stand still"):
                await axis.wait_for("moving")

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(main())


def test_a_restart_of_the_station_ends_a_trace() -> None:
    with LiveStation() as live, live.connect() as client:
        client.nc.axis(1).enable()
        with client.nc.axis(1).trace(0.01) as samples:
            seen = 0

            def follow() -> None:
                nonlocal seen
                for _ in samples:
                    seen += 1
                    if seen == 3:
                        live.restart()

            with pytest.raises(ConnectionLost):
                follow()
        assert client.nc.axis("X").status().position == 0.0


def test_the_layout_of_twincat_2_is_requested_when_the_longer_one_is_refused(
    monkeypatch: pytest.MonkeyPatch, on_bench: Callable[..., Any]
) -> None:
    lengths = []
    read = RawTarget.read_raw

    async def older(self: RawTarget, group: int, offset: int, length: int) -> bytes:
        lengths.append(length)
        if length == 256:
            raise DeviceError(0x705, "older")
        return await read(self, group, offset, length)

    async def test(bench: Any) -> None:
        monkeypatch.setattr(RawTarget, "read_raw", older)
        axis = bench.client.nc.axis(1)
        await axis.move_to(10, velocity=100)
        assert (await axis.status()).set_position == 10.0
        assert lengths.count(256) == 1

    on_bench(test)


def test_samples_that_no_client_fetched_are_counted() -> None:
    async def main() -> None:
        station = Station.demo()
        async with (
            achse.connect(station.router) as client,
            client.nc.axis(1).trace(0.002) as samples,
        ):
            assert await samples.next() is not None
            for _ in range(24):  # 12,000 samples: more than wait for a reader
                station.advance(1.0)
                await asyncio.sleep(0)
            late = await samples.next()
            assert late is not None
            assert late.lost >= 1000

    asyncio.run(main())
