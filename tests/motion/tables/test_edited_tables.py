"""Tables that are changed while slaves use them: others keep theirs, what waits still waits."""

from dataclasses import replace

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import AxisParameters, Nc, StateBit, commands
from achse.motion.commands import CamDemand
from achse.motion.states import CamActivation
from achse.motion.tables import TableError
from achse.motion.tables.table import MOTION_POINT, PointActivation

RISING = [0.0, 0.0, 90.0, 30.0, 180.0, 60.0, 360.0, 100.0]


def build() -> Nc:
    """Axes 2 and 3 are to follow axis 1; tables 7 and 8 are cams, 5 and 6 motion functions."""
    values = {"control_dword": 7, "velocity_override": 1_000_000, "position_range_window": 5.0}
    nc = Nc(2_000_000, [AxisParameters(n, values=values) for n in (1, 2, 3)], compiled=False)
    for table_id in (7, 8):
        nc.tables.write(nc.tables.create(table_id, TableType.CAMMING, 3, 4, 2), 0, RISING)
    nc.tables.write(nc.tables.find(8), 5, [66.0])
    for table_id in (5, 6):
        cyclic = TableSubType.MONOTONIC_CYCLIC
        table = nc.tables.create(table_id, TableType.MOTION_FUNCTION, cyclic, 2, 1)
        nc.tables.write_points(table, 0, point(0.0, 0.0) + point(9.0, 9.0))
    nc.cycle(3)
    return nc


def point(master: float, slave: float) -> bytes:
    return MOTION_POINT.pack(0, 5, 0, 1, 0, master, slave, 0.0, 0.0, 0.0)


def follow(nc: Nc, axis: int, law: int, table_id: int, place: float | None = None) -> None:
    """From now on, or from a master position on."""
    demand = CamDemand(table_id, slave_absolute=1, master_absolute=1)
    if place is not None:
        demand = replace(demand, activation=CamActivation.MASTER_AXIS_POSITION, position=place)
    assert commands.couple_by_cam(nc.axis(axis), law, 1, demand) == 0
    nc.cycle()


def move(nc: Nc, place: float) -> None:
    assert commands.start(nc.axis(1), 1, place, 300.0) == 0
    nc.cycle(600)
    assert nc.axis(1).set_position == place


def change(nc: Nc, table_id: int, slave: float) -> None:
    """Let the last point of a motion function be elsewhere at once."""
    table = nc.tables.find(table_id)
    nc.tables.change_online(table, PointActivation(CamActivation.INSTANTANEOUS))
    nc.tables.write_points(table, 1, point(9.0, slave))


def test_slave_of_another_table_sleeps_on() -> None:
    nc = build()
    follow(nc, 2, 10, 7)
    follow(nc, 3, 10, 8)
    nc.cycle(300)
    assert nc.axis(3).resting
    nc.tables.write(nc.tables.find(7), 3, [31.0])
    assert nc.axis(3).resting
    assert not nc.axis(2).resting


def test_edit_is_checked_against_all_cams_of_a_slave() -> None:
    nc = build()
    for table_id in (7, 8):
        follow(nc, 2, 11, table_id)
    move(nc, 90.0)
    assert nc.axis(2).set_position == pytest.approx(60.0)
    table = nc.tables.find(7)
    with pytest.raises(TableError) as refused:
        nc.tables.write(table, 3, [36.0])
    assert refused.value.error == NcError.TABLE_SLAVE_RANGE
    nc.tables.write(table, 3, [34.0])
    nc.cycle()
    assert nc.axis(2).set_position == pytest.approx(64.0)


def test_points_that_are_no_function_leave_a_slave_its_own() -> None:
    nc = build()
    follow(nc, 2, 13, 5)
    tables, layer = nc.tables, nc.axis(2).cams[0]
    before = layer.now.cam, list(tables.cams.numbers)
    with pytest.raises(TableError):
        tables.write_points(tables.find(5), 1, point(-9.0, 9.0))
    assert (layer.now.cam, list(tables.cams.numbers)) == before
    assert tables.cam(5, 0) == layer.now.cam


def test_refused_points_leave_other_functions() -> None:
    nc = build()
    follow(nc, 2, 13, 5)
    follow(nc, 3, 13, 6)
    change(nc, 5, 11.0)
    change(nc, 6, 12.0)
    move(nc, 9.0)
    with pytest.raises(TableError):
        change(nc, 5, 99.0)
    move(nc, 18.0)
    assert (nc.axis(2).set_position, nc.axis(3).set_position) == (22.0, 24.0)


def test_function_that_waits_to_begin_has_the_newest_points() -> None:
    """And a cam that waits is the one that was asked for."""
    nc = build()
    follow(nc, 2, 13, 5)
    follow(nc, 3, 13, 5, 9.0)
    change(nc, 5, 11.0)
    move(nc, 18.0)
    assert (nc.axis(2).set_position, nc.axis(3).set_position) == (22.0, 11.0)
    nc = build()
    follow(nc, 2, 13, 5)
    follow(nc, 3, 10, 7)
    follow(nc, 3, 10, 8, 90.0)
    change(nc, 5, 11.0)
    move(nc, 120.0)
    assert nc.axis(3).set_position == pytest.approx(42.0)


def test_change_of_scaling_waits_while_points_change() -> None:
    nc = build()
    follow(nc, 2, 13, 5)
    off = CamDemand(5, activation=CamActivation.OFF, slave_scaling=2.0)
    assert commands.change_cam_scaling(nc.axis(2), off) == 0
    change(nc, 5, 11.0)
    nc.cycle()
    assert nc.axis(2).state_dword & StateBit.CAM_SCALING_PENDING


def test_kernels_are_not_notified_of_points_that_fit_into_memory() -> None:
    nc = build()
    follow(nc, 2, 13, 5)
    reports: list[int] = []
    nc.tables.laid_out = lambda: reports.append(1)
    change(nc, 5, 11.0)
    assert reports == []


def test_values_of_a_motion_function_are_those_of_its_laws() -> None:
    """Law 5, a polynomial, is at most 15/8 as fast as its mean."""
    tables = build().tables
    assert pytest.approx(15.0) in tables.characteristic_values(tables.find(5), 8.0)
