"""Scopes from afar: made, followed, read, closed; at a station in this process."""

import inspect
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.client import connect
from achse.client.scope import RemoteScope, block_of, defined, scope_of, scopes_of
from achse.scope import ScopeError, ScopeTrigger
from achse.station import Station

Run = Callable[[Coroutine[Any, Any, Any]], Any]


def test_a_recording_around_a_trigger(run_for_real: Run) -> None:
    station = Station.demo()

    async def main() -> None:
        async with connect(station.router, advance=station.advance) as client:
            scope = client.scope(
                ["MAIN.nCounter", "500:Axes.X.ActPos@4ms"],
                length=0.2,
                triggers=ScopeTrigger("MAIN.nCounter", "rising", (50.0,)),
                pretrigger=0.5,
            )
            async with scope:
                assert [each["own"] for each in await scopes_of(client)] == [False, True]
                await scope.wait(60)
                data = await scope.data()
                assert data["MAIN.nCounter"].values == list(range(40, 60))
                assert len(data["Axes.X.ActPos"]) == 50
                assert data.trigger_time == 0.1
            assert len(await scopes_of(client)) == 1
            with pytest.raises(ScopeError, match="expected a scope that is open"):
                await scope.start()

    run_for_real(main())


def test_rows_are_followed_and_none_is_missed(run_for_real: Run) -> None:
    station = Station.demo()

    async def main() -> None:
        async with connect(station.router) as client:
            definition = defined("MAIN.nCounter", port=851, length=0.5)
            async with scope_of(client, definition) as scope:
                counts: list[int] = []
                station.advance(0.3)
                async for rows in scope.follow(0):
                    group = (await scope.facts())["channel_groups"][0]
                    counts += _values(group, rows)
                    assert rows.lost == 0
                    station.advance(0.3)
                    if len(counts) >= 300:
                        await scope.stop()
                        break
                assert counts == list(range(counts[0], counts[0] + len(counts)))
                await scope.start()
                station.advance(2.0)
                async for rows in scope.follow(0):
                    assert (rows.lost, rows.size) == (150, 50)
                    break

    run_for_real(main())


def _values(group: dict[str, Any], rows: Any) -> list[int]:
    block = block_of(group, rows.first, rows.rows)
    return [word & 0xFFFF_FFFF for word in block.words]


def test_what_the_station_refuses_is_raised(run_for_real: Run) -> None:
    station = Station.demo()

    async def main() -> None:
        async with connect(station.router) as client:
            with pytest.raises(ScopeError, match=r"did you mean 'MAIN\.nCounter'"):
                await client.scope("MAIN.nCounte").open()
            with pytest.raises(DeviceError, match="0x70C"):
                await RemoteScope.of(client, 9).facts()
            first = RemoteScope.of(client.at_port(14000), 1)
            with pytest.raises(ScopeError, match="it is offline"):
                await first.wait()
            with pytest.raises(DeviceError, match="0x712"):
                await first.trigger()
            await first.close()  # it is not ours, and stays
            assert (await first.facts())["number"] == 1
            huge = client.scope("500:Axes.X.ActPos@2ms", length=3600)
            async with huge:
                with pytest.raises(TimeoutError):
                    await huge.wait(0.01)

    run_for_real(main())


def test_channels_without_port_are_of_the_queried_device() -> None:
    assert [each.port for each in defined(["a", "9:b"], port=852).channels] == [852, 9]
    assert [each.port for each in defined("a", port=14000).channels] == [0]
    assert inspect.iscoroutinefunction(RemoteScope.open)
