"""Tables without asyncio have the same names and do the same."""

import inspect

import pytest

from achse.client import nc
from achse.client.nc import FunctionPoint, TableKind
from achse.client.nc.blocking_tables import RemoteTable
from achse.testing import LiveStation


def test_it_has_the_same_methods_with_the_same_arguments() -> None:
    for name, method in inspect.getmembers(nc.RemoteTable, inspect.isfunction):
        if not name.startswith("_"):
            own = inspect.signature(method).parameters
            other = inspect.signature(getattr(RemoteTable, name)).parameters
            assert {key: one.default for key, one in own.items()} == {
                key: one.default for key, one in other.items()
            }, name


def test_tables_and_couplings_at_a_station() -> None:
    with LiveStation(time="virtual") as live, live.connect() as client:
        table = client.nc.table(5)
        table.create(2, kind=TableKind.MOTION_FUNCTION, cyclic=True)
        points = [FunctionPoint(0.0, 0.0, 12), FunctionPoint(100.0, 50.0)]
        table.write_points(points)
        table.change_when(0)
        table.check()
        assert table.read_points() == points
        assert table.values(50.0).position == pytest.approx(25.0)
        assert table.demands()[23] == pytest.approx(1.0)
        assert table.slave_type() == 13
        assert [each.id for each in client.nc.tables()] == [5]
        assert repr(table).startswith("RemoteTable(5")
        cam = client.nc.table(6)
        cam.create(2)
        cam.write_rows([(0.0, 0.0), (10.0, 5.0)])
        assert cam.read_rows() == [(0.0, 0.0), (10.0, 5.0)]
        assert cam.facts().columns == 2
        cam.delete()
        x, y = client.nc.axis("X"), client.nc.axis("Y")
        for each in (x, y):
            each.enable()
        y.gear_in(x, 2.0)
        y.change_gear(1.0)
        assert y.coupling() == nc.CouplingState.SLAVE
        y.gear_out()
