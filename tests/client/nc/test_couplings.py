"""Axes follow axes: by a gear and by a cam, until they are let go."""

import contextlib
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.ams import AdsError, DeviceError
from achse.client.nc import AxisRefused, CouplingState, UnknownAxis

Bench = Any
On = Callable[..., Any]


async def pair(bench: Bench) -> tuple[Any, Any]:
    nc = bench.axis.nc
    assert nc is not None
    y = bench.client.nc.axis("Y")
    await y.enable()
    return bench.axis, y


def test_a_gear(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x, y = await pair(bench)
        await y.gear_in(x, -0.5)
        assert (await y.coupling(), await x.coupling()) == (
            CouplingState.SLAVE,
            CouplingState.MASTER,
        )
        await x.move_to(100, velocity=200)
        assert (await y.status()).set_position == -50.0
        await y.change_gear(2.0)
        await x.move_to(110, velocity=200)
        assert (await y.status()).set_position == pytest.approx(-30.0)
        await y.gear_out()
        assert await y.coupling() == CouplingState.SINGLE
        await x.move_to(0, velocity=200)
        assert (await y.status()).set_position == pytest.approx(-30.0)

    on_bench(test)


def test_a_master_by_name_and_by_id(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x, y = await pair(bench)
        for master in ("x", 1, x):
            await y.gear_in(master)
            await y.gear_out()
        with pytest.raises(UnknownAxis, match="did you mean"):
            await y.gear_in("XX")

    on_bench(test)


@pytest.mark.parametrize(
    ("then", "fields"),
    [
        ("stop", {}),
        ("new velocity", {"velocity": 40.0}),
        ("new position", {"position": 150.0}),
        ("new position", {"position": 150.0, "velocity": 30.0}),
        ("at once", {}),
    ],
)
def test_let_go_in_motion(on_bench: On, then: Any, fields: dict[str, float]) -> None:
    async def test(bench: Bench) -> None:
        x, y = await pair(bench)
        await y.gear_in(x)
        await x.move_velocity(80)
        await y.gear_out(then, **fields)
        if then == "new velocity":
            await y.wait_for(lambda status: abs(status.set_velocity - 40.0) < 1e-6, within=10)
        elif fields:
            status = await y.wait_for("idle", within=30)
            assert status.set_position == pytest.approx(150.0)
        else:
            await y.wait_for("idle", within=10)
        await y.halt()

    on_bench(test)


def test_a_slave_that_goes_on_keeps_its_velocity(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x, y = await pair(bench)
        await y.gear_in(x)
        await x.move_velocity(80)
        await y.gear_out()
        await x.halt()
        assert (await y.status()).set_velocity == pytest.approx(80.0)

    on_bench(test)


def test_refusals_have_codes(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        x, y = await pair(bench)
        for call, code in (
            (y.gear_in(x, 0.0), 0x421B),
            (y.gear_out(), 0x424D),
            (y.cam_in(x, 99), 0x4016),
        ):
            with pytest.raises(DeviceError) as caught:
                await call
            assert caught.value.code == code
        with pytest.raises(AxisRefused):
            await y.change_gear(2.0)
        await y.gear_in(x)
        with pytest.raises(AxisRefused):
            await x.gear_in(y)
        with pytest.raises(ValueError, match="'go on'"):
            await y.gear_out("fly away")

    on_bench(test)


NUMBERS: st.SearchStrategy[Any] = st.one_of(
    st.floats(-10, 10), st.floats(), st.sampled_from([10**400, "1", None, b""])
)


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("gear_in"), st.sampled_from(["X", 1, 2, 300, "Z", None]), NUMBERS),
            st.tuples(st.just("change_gear"), NUMBERS),
            st.tuples(st.just("cam_in"), st.just("X"), st.integers(-1, 5000)),
            st.tuples(
                st.just("gear_out"), st.sampled_from(["go on", "stop", "new position", "no"])
            ),
            st.tuples(st.just("cam_out")),
            st.tuples(st.just("coupling")),
        ),
        max_size=6,
    )
)
def test_any_request_ends_in_a_result_or_a_typed_error(
    on_bench: On, calls: list[tuple[Any, ...]]
) -> None:
    async def test(bench: Bench) -> None:
        _, y = await pair(bench)
        for name, *arguments in calls:
            with contextlib.suppress(AdsError, ValueError):
                await getattr(y, name)(*arguments)

    on_bench(test)
