"""Tables of an NC: made, filled, read, asked, forgotten."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import DeviceError
from achse.client.nc import FunctionPoint, TableKind

Bench = Any
On = Callable[..., Any]


def test_a_motion_function(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        table = bench.client.nc.table(300)
        await table.create(2, kind=TableKind.MOTION_FUNCTION)
        points = [FunctionPoint(0.0, 0.0, 5), FunctionPoint(180.0, 100.0, 0)]
        await table.write_points(points)
        assert await table.read_points() == points
        await table.check()
        facts = await table.facts()
        assert (facts.id, facts.kind, facts.rows, facts.cyclic, facts.users) == (
            300,
            TableKind.MOTION_FUNCTION,
            2,
            False,
            0,
        )
        assert await table.slave_type() == 13
        values = await table.values(45.0)
        assert values == pytest.approx((10.3515625, 0.5859375, 0.017361111111))
        assert (await table.demands(720.0))[23] == pytest.approx(750.0)
        await table.change_when(3, keep_place=True)
        await table.delete()
        with pytest.raises(DeviceError) as caught:
            await table.facts()
        assert caught.value.code == 0x4016

    on_bench(test)


def test_a_cam_of_many_rows(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        table = bench.client.nc.table(7)
        rows = [(float(n), float(n % 7)) for n in range(9000)]
        await table.create(9000, cyclic=True)
        await table.write_rows(rows)
        assert await table.read_rows() == rows
        assert (await table.facts()).cyclic
        assert await table.slave_type() == 10
        assert [each.id for each in await bench.client.nc.tables()] == [7]
        await table.write_rows([(0.5, 3.0)])
        assert (await table.read_rows())[0] == (0.5, 3.0)

    on_bench(test)


def test_what_no_table_can_be(on_bench: On) -> None:
    async def test(bench: Bench) -> None:
        for wrong in (0, 4096, -1, "7"):
            with pytest.raises(ValueError, match="a table id"):
                bench.client.nc.table(wrong)
        table = bench.client.nc.table(7)
        with pytest.raises(DeviceError):
            await table.create(1)
        await table.create(2)
        with pytest.raises(ValueError, match="finite"):
            await table.write_rows([(0.0, float("nan"))])
        with pytest.raises(DeviceError) as caught:
            await table.create(2)
        assert caught.value.code == 0x4063

    on_bench(test)
