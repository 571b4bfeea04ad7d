"""The axes of an NC, by name and id."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import RouterError
from achse.client.nc import AxisRefused, UnknownAxis
from achse.client.nc.controller import RemoteNc


def test_its_axes(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        nc = bench.client.nc
        assert nc is bench.client.nc
        assert await nc.ids() == [1, 2, 3]
        assert [str(axis) for axis in await nc.axes()] == ["X", "Y", "C"]
        assert [await axis.id() for axis in await nc.axes()] == [1, 2, 3]
        assert nc.target.address.port == 500
        direct = bench.client.at_port(500)
        assert direct.nc.target is direct

    on_bench(test)


@pytest.mark.parametrize("which", ["", 0, 256, -1, True, None, 1.0, b"X"])
def test_what_is_not_an_axis(on_bench: Callable[..., Any], which: Any) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(ValueError, match="an axis"):
            bench.client.nc.axis(which)

    on_bench(test)


@pytest.mark.parametrize(("name", "hint"), [("XX", "did you mean X?"), ("nothing", "there are")])
def test_unknown_names(on_bench: Callable[..., Any], name: str, hint: str) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(UnknownAxis) as caught:
            await bench.client.nc.axis(name).enable()
        assert hint in str(caught.value)
        assert "1 X, 2 Y, 3 C" in str(caught.value)

    on_bench(test)


def test_an_id_without_an_axis_is_the_refusal_of_the_nc(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(AxisRefused, match=r"axis 9, .*0x4012"):
            await bench.client.nc.axis(9).status()

    on_bench(test)


def test_where_there_is_no_nc(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(RouterError):
            await RemoteNc(bench.client.at_port(555)).axis("X").move_to(1, velocity=1)

    on_bench(test)
