"""An axis found by name, asked by service, watched by condition."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from achse.client.nc import (
    AxisFailed,
    AxisRefused,
    AxisTimeout,
    PlcOpenState,
    UnknownAxis,
    UnknownService,
)
from achse.codes.axis import StateBit


def test_what_it_is(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        axis = bench.client.nc.axis("x")
        assert str(axis) == "x"
        assert (await axis.id(), await axis.name(), await axis.unit()) == (1, "X", "mm")
        assert str(axis) == "X"
        assert await axis.state() is PlcOpenState.STANDSTILL
        assert await axis.override() == 100.0
        assert (await axis.position(), await axis.velocity()) == (0.0, 0.0)
        assert await axis.following_error() == 0.0
        assert await axis.error() is None

    on_bench(test)


def test_functions_by_name(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        call = bench.axis.call
        assert await call("start", start_type=1, end_position=50.0, velocity=100.0) is None
        await bench.axis.wait_for("in target", within=5)
        number, _ = await call("universal axis start", 1, 0, 60.0, 100.0, *[0.0] * 3, 0, *[0.0] * 3)
        assert number == 2
        with pytest.raises(ValueError, match="start has no speed; expected start_type"):
            await call("start", speed=1)
        with pytest.raises(ValueError, match="stop: expected 0 values, got 1"):
            await call("stop", 1.0)
        with pytest.raises(UnknownService, match="did you mean start"):
            await call("starr")
        with pytest.raises(AxisRefused, match="X, oriented stop: 0x"):
            await call("oriented_stop", -1.0, 100.0, 100.0)

    on_bench(test)


@pytest.mark.parametrize("percent", [-1, 101, float("nan"), "full"])
def test_an_override_that_is_none(on_bench: Callable[..., Any], percent: Any) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(ValueError, match="override"):
            await bench.axis.set_override(percent)
        await bench.axis.set_override(33.3)
        assert await bench.axis.override() == 33.3

    on_bench(test)


@pytest.mark.parametrize(
    "condition",
    ["moving", PlcOpenState.DISCRETE_MOTION, StateBit.HAS_JOB, lambda each: each.velocity > 50],
)
def test_waiting(on_bench: Callable[..., Any], condition: Any) -> None:
    async def test(bench: Any) -> None:
        await bench.axis.move_to(100, velocity=100, wait=False)
        status = await bench.axis.wait_for(condition, within=2.0)
        assert status.has_job

    on_bench(test)


def test_time_limits_of_the_station_and_of_the_wall(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        before = bench.station.time_ns
        with pytest.raises(AxisTimeout, match="waited 3 s for moving; is at 0, Standstill"):
            await bench.axis.wait_for("moving", within=3.0)
        assert bench.station.time_ns - before == 3 * 10**9
        with pytest.raises(AxisTimeout, match=r"waited 0\.05 s for moving"):
            await bench.axis.wait_for("moving", patience=0.05)
        with pytest.raises(ValueError, match="within"):
            await bench.axis.wait_for("moving", within=-1)

    on_bench(test)


def test_an_error_ends_a_wait(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        bench.hooks.append(
            lambda time: bench.station.nc.axis(1) and None if time < 1 else _fail(bench)
        )
        with pytest.raises(AxisFailed, match="0x4655"):
            await bench.axis.wait_for("moving")
        failure = await bench.axis.error()
        assert failure is not None
        assert (failure.code, failure.axis) == (0x4655, "X")

    on_bench(test)


def _fail(bench: Any) -> None:
    bench.station.nc.axis(1).error_code = 0x4655


def test_an_error_of_its_own_is_not_a_time_limit(on_bench: Callable[..., Any]) -> None:
    """A test that raises TimeoutError is not taken for `patience`."""

    def broken(status: Any) -> bool:
        raise TimeoutError("mine")

    async def test(bench: Any) -> None:
        with pytest.raises(TimeoutError, match="mine"):
            await bench.axis.wait_for(broken, patience=5.0)

    on_bench(test)


def test_a_name_is_looked_up_again_after_a_loss(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        axis = bench.client.nc.axis("Y")
        assert await axis.id() == 2
        bench.client.session.link.abort()
        await asyncio.sleep(0)
        bench.station.nc.axis(2).name = "Z"
        with pytest.raises(UnknownAxis, match="1 X, 2 Z, 3 C"):
            await axis.position()

    on_bench(test)


def test_subscriptions(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        names = ["set position", "actual_velocity"]
        async with bench.axis.subscribe(names, cycle_time=0.01) as samples:
            seen = {(await anext(samples)).name for _ in range(2)}
            assert seen == {"set_position", "actual_velocity"}
        with pytest.raises(UnknownService):
            bench.axis.subscribe("set positon")
        with pytest.raises(ValueError, match="at least one"):
            bench.axis.subscribe([])
        with pytest.raises(ValueError, match="structure"):
            bench.axis.subscribe("axis online structure")

    on_bench(test)
