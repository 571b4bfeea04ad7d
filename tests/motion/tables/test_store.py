"""Tables of an NC by id: what they may be, how they come and go."""

from collections.abc import Callable
from math import isfinite
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.states import CamActivation, CamInterpolation, CamScaling
from achse.motion.tables import Table, TableError, TableParameters, Tables, store
from achse.motion.tables.limits import TableLimits
from achse.motion.tables.memory import HEADER, SPAN
from achse.motion.tables.table import MOTION_POINT, PointActivation

VALVE = [(-1.0, -1.0), (0.0, 0.0), (1.0, 1.0)]


def refuses(error: NcError, call: Callable[..., object], *arguments: Any) -> None:
    with pytest.raises(TableError) as caught:
        call(*arguments)
    assert caught.value.error is error


def fresh(sub_type: int = 3, rows: int = 3, columns: int = 2, table_id: int = 7) -> Table:
    return Table(table_id, TableType.CHARACTERISTIC, sub_type, rows, columns)


def test_what_a_table_cannot_be() -> None:
    refuses(NcError.TABLE_ID_RANGE, fresh, 3, 3, 2, 0)
    refuses(NcError.TABLE_ID_RANGE, fresh, 3, 3, 2, 4096)
    for sub_type in (0, 2, 4, 5):
        refuses(NcError.TABLE_SUB_TYPE, fresh, sub_type)
    refuses(NcError.TABLE_ROW_COUNT, fresh, 3, 1)
    refuses(NcError.TABLE_COLUMN_COUNT, fresh, 3, 2, 0)
    refuses(NcError.TABLE_NO_MEMORY, fresh, 3, 1 << 24, 1 << 24)


def test_tables_come_and_go_by_id() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)], tables=[TableParameters(3, VALVE, "valve")]).tables
    tables.add(fresh())
    assert (tables.ids(), len(tables)) == ([3, 7], 2)
    refuses(NcError.TABLE_EXISTS, tables.add, fresh())
    tables.delete(7)
    refuses(NcError.TABLE_NOT_FOUND, tables.find, 7)
    refuses(NcError.TABLE_NOT_FOUND, tables.delete, 7)


def test_table_that_is_there_is_not_created_again() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)], tables=[TableParameters(3, VALVE, "valve")]).tables
    refuses(NcError.TABLE_EXISTS, tables.create, 3, TableType.CAMMING, 3, 1 << 24, 2)


def test_only_motion_functions_have_points() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)]).tables
    table = tables.create(7, TableType.CAMMING, 3, 2, 2)
    with pytest.raises(TableError, match="has no points"):
        tables.write_points(table, 0, bytes(MOTION_POINT.size))


def test_scaling_of_a_table_is_positive_and_its_range_ordered() -> None:
    tables = Nc(2_000_000, [AxisParameters(1)]).tables
    table = tables.create(7, TableType.CAMMING, 3, 3, 2)
    tables.write(table, 0, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0])
    before = table.scaling
    for wrong in (
        {"master_scaling": 0.0},
        {"master_scaling": -1.0},
        {"range_low": 2.0, "range_high": 1.0},
    ):
        refuses(NcError.TABLE_SCALING, tables.scale, table, before._replace(**wrong))
        assert table.scaling == before
    for right in ({"master_scaling": 0.5}, {"range_low": 1.0, "range_high": 1.0}):
        tables.scale(table, before._replace(**right))


def test_table_at_work_stays_monotonic() -> None:
    axes = [AxisParameters(n, values={"control_dword": 7}) for n in (1, 2)]
    nc = Nc(2_000_000, axes, compiled=False)
    nc.cycle(3)
    table = nc.tables.create(7, TableType.CAMMING, 3, 3, 2)
    nc.tables.write(table, 0, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0])
    assert commands.couple_by_cam(nc.axis(2), 10, 1, CamDemand(7)) == 0
    nc.cycle()
    refuses(NcError.TABLE_NOT_MONOTONIC, nc.tables.write, table, 2, [400.0])
    assert list(table.values[:4]) == [0.0, 0.0, 90.0, 30.0]


RISING = [0.0, 0.0, 90.0, 30.0, 180.0, 60.0, 360.0, 100.0]
"""A cam in four rows."""

CURVED = [(0, 5, 0, 1, 0, 0.0, 0.0, 0.0, 0.0, 0.0), (1, 5, 0, 1, 0, 9.0, 9.0, 0.0, 0.0, 0.0)]
"""A motion function of two points."""


def packed(*points: tuple[Any, ...]) -> bytes:
    return b"".join(MOTION_POINT.pack(*point) for point in points)


@pytest.fixture
def nc() -> Nc:
    """Three enabled axes; table 7 is a cam."""
    axes = [AxisParameters(n, values={"control_dword": 7}) for n in (1, 2, 3)]
    result = Nc(2_000_000, axes, compiled=False)
    result.cycle(3)
    result.tables.write(result.tables.create(7, TableType.CAMMING, 3, 4, 2), 0, RISING)
    return result


@pytest.mark.parametrize(
    ("index", "step", "last"), [(0, 1, 2), (1, 2, 5), (3, 1, 5), (0, 3, 6), (5, 1, 7)]
)
def test_numbers_are_written_from_an_index_on(nc: Nc, index: int, step: int, last: int) -> None:
    table = nc.tables.create(8, TableType.CAMMING, 3, 4, 2)
    assert not table.filled
    nc.tables.write(table, index, [1.0, 2.0, 3.0], step)
    expected = [0.0] * 8
    expected[index : index + 3 * step : step] = [1.0, 2.0, 3.0]
    assert (list(table.values), table.last_written, table.filled) == (expected, last, True)


@pytest.mark.parametrize("number", [float("inf"), float("nan")])
def test_only_finite_numbers_are_written(nc: Nc, number: float) -> None:
    table = nc.tables.find(7)
    refuses(NcError.TABLE_PARAMETER, nc.tables.write, table, 0, [number, -number])
    nc.tables.write(nc.tables.create(8, TableType.CAMMING, 3, 2, 2), 0, [1.7e308, 1.7e308])
    assert list(table.values) == RISING


@pytest.mark.parametrize(("index", "step"), [(0, 1), (3, 2), (2, 2)])
def test_points_are_written_from_an_index_on(nc: Nc, index: int, step: int) -> None:
    table = nc.tables.create(8, TableType.MOTION_FUNCTION, 3, 3, 2)
    points = packed(*CURVED)
    nc.tables.write_points(table, index, points, step)
    size = MOTION_POINT.size
    for n in range(6):
        at = bytes(table.motion[n * size : (n + 1) * size])
        place = (n - index) // step if (n - index) % step == 0 else -1
        assert at == (points[place * size : (place + 1) * size] if place in (0, 1) else bytes(size))
    assert table.filled
    endless = (*CURVED[0][:5], *(float("inf"),) * 5)
    refuses(NcError.TABLE_PARAMETER, nc.tables.write_points, table, 0, packed(endless))


def test_tables_of_clients_are_bounded_together(nc: Nc) -> None:
    """Table 7 has 8 numbers; one of the configuration does not count."""
    tables = nc.tables
    tables.add_configured(TableParameters(3, VALVE, "valve"))
    tables.limits = TableLimits(12, 20)
    refuses(NcError.TABLE_NO_MEMORY, tables.create, 8, TableType.CAMMING, 3, 7, 2)
    tables.create(8, TableType.CAMMING, 3, 6, 2)
    refuses(NcError.TABLE_NO_MEMORY, tables.create, 9, TableType.CAMMING, 3, 2, 1)
    tables.delete(8)
    tables.create(8, TableType.CAMMING, 3, 6, 2)
    assert tables.ids() == [3, 7, 8]


def test_all_tables_have_a_bound(nc: Nc, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of the configuration, too: 8 numbers of table 7, and 6."""
    tables = nc.tables
    for most, fits in ((14, True), (13, False)):
        monkeypatch.setattr(store, "MOST_NUMBERS", most)
        if fits:
            tables.add_configured(TableParameters(3, VALVE, "valve"))
            tables.delete(3)
        else:
            refuses(
                NcError.TABLE_NO_MEMORY, tables.add_configured, TableParameters(3, VALVE, "valve")
            )


def test_configured_tables_have_their_points_and_are_checked(nc: Nc) -> None:
    tables, cam, function = nc.tables, TableType.CAMMING, TableType.MOTION_FUNCTION
    steep = [(0.0, 0.0), (1.0, 2e3)]
    tables.add_configured(TableParameters(3, steep, "cam", main_type=cam))
    tables.add_configured(TableParameters(4, VALVE, "valve"))
    points: Any = CURVED
    tables.add_configured(TableParameters(5, points, "function", main_type=function))
    assert [tables.find(n).column_count for n in (3, 4, 5)] == [2, 2, 1]
    assert [tables.find(n).row_count for n in (3, 4, 5)] == [2, 3, 2]
    assert bytes(tables.find(5).motion) == packed(*CURVED)
    assert tables.find(3).points() == steep
    assert all(tables.find(n).filled for n in (3, 4, 5))
    refuses(NcError.TABLE_PARAMETER, tables.add_configured, TableParameters(6, steep, "valve"))
    falling = TableParameters(6, steep[::-1], "cam", main_type=cam)
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.add_configured, falling)
    assert tables.ids() == [3, 4, 5, 7]


def test_deleted_table_leaves_no_cam_behind(nc: Nc) -> None:
    tables = nc.tables
    tables.cam(7, 0)
    tables.delete(7)
    steep = [(0.0, 0.0), (10.0, 20.0)]
    tables.add_configured(TableParameters(7, steep, "cam", main_type=TableType.CAMMING))
    below, _ = tables.nearest(tables.find(7), 10.0, 9.0)
    assert below is not None
    assert below.position == pytest.approx(5.0)


def test_only_monotonic_tables_of_numbers_are_scaled(nc: Nc) -> None:
    tables = nc.tables
    equal = tables.create(8, TableType.CAMMING, 1, 2, 2)
    function = tables.create(9, TableType.MOTION_FUNCTION, 3, 2, 1)
    for table in (equal, function):
        refuses(NcError.TABLE_FUNCTION_NOT_AVAILABLE, tables.scale, table, table.scaling)


def test_slaves_drives_and_names_use_a_table(nc: Nc) -> None:
    tables, slave = nc.tables, nc.axis(2)
    tables.write(tables.create(8, TableType.CAMMING, 3, 4, 2), 0, RISING)
    assert (tables.user_count(7), tables.user_count(8)) == (0, 0)
    code = commands.couple_by_cam(slave, 11, 1, CamDemand(7), further_tables=[8])
    assert code == 0
    assert (tables.user_count(7), tables.user_count(8)) == (1, 1)
    refuses(NcError.SLAVE_TABLE_IN_USE, tables.delete, 8)
    assert commands.decouple(slave) == 0
    assert (tables.user_count(7), tables.user_count(8)) == (0, 0)
    tables.delete(7)
    tables.write(tables.create(7, TableType.CAMMING, 3, 4, 2), 0, RISING)


@pytest.mark.parametrize(
    ("sub_type", "count", "interpolation", "error"),
    [
        (3, 2, CamInterpolation.LINEAR, None),
        (3, 3, CamInterpolation.SPLINE, None),
        (3, 2, CamInterpolation.SPLINE, NcError.TABLE_TOO_FEW_SPLINE_POINTS),
        (3, 3, CamInterpolation.LOCAL, None),
        (3, 2, CamInterpolation.LOCAL, NcError.TABLE_TOO_FEW_SPLINE_POINTS),
        (1, 4, CamInterpolation.FOUR_POINTS, None),
        (1, 3, CamInterpolation.FOUR_POINTS, NcError.TABLE_TOO_FEW_SPLINE_POINTS),
        (3, 4, CamInterpolation.FOUR_POINTS, NcError.TABLE_INTERPOLATION_TYPE),
        (3, 4, 4, NcError.TABLE_INTERPOLATION_TYPE),
    ],
)
def test_interpolations_demand_rows(
    nc: Nc, sub_type: int, count: int, interpolation: int, error: NcError | None
) -> None:
    tables = nc.tables
    table = tables.create(8, TableType.CAMMING, sub_type, count, 2)
    refuses(NcError.TABLE_SLAVE_WITHOUT_TABLE, tables.cam, 8, 0)
    tables.write(table, 0, [value for n in range(count) for value in (n * 10.0, n * n * 1.0)])
    if error is None:
        assert tables.cam(8, interpolation) > 0
        assert tables.cam(8, interpolation) == tables.cam(8, interpolation)
    else:
        refuses(error, tables.cam, 8, interpolation)


def test_motion_function_needs_no_rows_for_its_laws(nc: Nc) -> None:
    table = nc.tables.create(8, TableType.MOTION_FUNCTION, 3, 2, 1)
    nc.tables.write_points(table, 0, packed(*CURVED))
    assert nc.tables.cam(8, CamInterpolation.SPLINE) > 0


def test_cams_without_a_user_give_their_memory_back(nc: Nc) -> None:
    tables = nc.tables
    tables.write(tables.create(8, TableType.CAMMING, 3, 4, 2), 0, RISING)
    first = tables.cam(7, 0)
    assert tables.cam(8, 0) == first  # nobody uses the one before
    assert commands.couple_by_cam(nc.axis(2), 10, 1, CamDemand(7)) == 0
    stored = tables.cam(7, 0)
    other = tables.cam(8, 0)
    assert other != stored
    assert tables.cam(8, 2) == other
    assert tables.cam(7, 0) == stored


def test_refused_cam_takes_no_memory(nc: Nc) -> None:
    tables = nc.tables
    table = tables.create(8, TableType.CAMMING, 3, 4, 2)
    tables.write(table, 0, [0.0, 0.0, 0.0, 1.0])
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.cam, 8, 0)
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.nearest, table, 0.5, 0.0)
    first = tables.cam(7, 0)
    assert first == tables.cam(7, 2)


@pytest.mark.parametrize("slave", [0.0, 15.0, 45.0, 100.0])
def test_nearest_place_of_a_value_is_found_before_and_behind(nc: Nc, slave: float) -> None:
    """Of straight lines, or as slaves join the rows; of a motion function by its laws."""
    tables = nc.tables
    place = {0.0: 0.0, 15.0: 45.0, 45.0: 135.0, 100.0: 360.0}[slave]
    below, above = tables.nearest(tables.find(7), slave, 200.0)
    result = below if place <= 200.0 else above
    assert result is not None
    assert result.position == pytest.approx(place)
    assert (above if place <= 200.0 else below) is None
    table = tables.create(8, TableType.MOTION_FUNCTION, 3, 2, 1)
    tables.write_points(table, 0, packed(*CURVED))
    below, above = tables.nearest(table, 4.5, 6.0)
    assert below is not None
    assert (below.position, above) == (pytest.approx(4.5), None)


@pytest.mark.parametrize("used", [False, True])
def test_values_are_those_of_the_rows_as_slaves_join_them(nc: Nc, used: bool) -> None:
    """Without a slave a spline, where there are rows for one."""
    tables = nc.tables
    table = tables.find(7)
    if used:
        assert commands.couple_by_cam(nc.axis(2), 10, 1, CamDemand(7)) == 0
    values = tables.characteristic_values(table, 1.0)
    steps = tables.create(8, TableType.CAMMING, 3, 2, 2)
    tables.write(steps, 0, [0.0, 0.0, 10.0, 20.0])
    lines = tables.characteristic_values(steps, 1.0)
    assert all(map(isfinite, values + lines))
    spline = Nc(2_000_000, [AxisParameters(1)], compiled=False).tables
    alone = spline.create(7, TableType.CAMMING, 3, 4, 2)
    spline.write(alone, 0, RISING)
    assert (spline.characteristic_values(alone, 1.0) == values) is not used


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (PointActivation(0), None),
        (PointActivation(9), None),
        (PointActivation(10), NcError.TABLE_EXECUTION_MODE),
        (PointActivation(-1), NcError.TABLE_EXECUTION_MODE),
        (PointActivation(0, 0.0, 2, 2), None),
        (PointActivation(0, 0.0, 3, 2), NcError.TABLE_SCALING),
        (PointActivation(0, 0.0, 2, 3), NcError.TABLE_SCALING),
        (PointActivation(0, float("inf")), NcError.TABLE_PARAMETER),
    ],
)
def test_activation_of_points_is_checked(
    nc: Nc, change: PointActivation, error: NcError | None
) -> None:
    table = nc.tables.create(8, TableType.MOTION_FUNCTION, 3, 2, 1)
    if error is None:
        nc.tables.change_online(table, change)
        assert table.online == change
    else:
        refuses(error, nc.tables.change_online, table, change)
        assert table.online == PointActivation()


def test_refused_numbers_and_scalings_leave_slaves_what_they_had(nc: Nc) -> None:
    tables, table, slave = nc.tables, nc.tables.find(7), nc.axis(2)
    assert commands.couple_by_cam(slave, 10, 1, CamDemand(7)) == 0
    nc.cycle()
    before = list(table.values), list(tables.cams.numbers), table.scaling
    turned = table.scaling._replace(slave_scaling=3.0, weight=2.0)
    nc.axis(2).set_position = 25.0
    for error, call, *arguments in (
        (NcError.TABLE_SLAVE_RANGE, tables.write, 0, [-30.0, 95.0]),
        (NcError.TABLE_NOT_MONOTONIC, tables.write, 4, [20.0, 400.0]),
        (NcError.TABLE_SLAVE_RANGE, tables.scale, turned),
    ):
        refuses(error, call, table, *arguments)
        assert (list(table.values), list(tables.cams.numbers), table.scaling) == before
        assert table.points()[1:3] == [(90.0, 30.0), (180.0, 60.0)]
    nc.axis(2).set_position = 0.0
    tables.write(table, 4, [200.0, 70.0])
    assert commands.start(nc.axis(1), 1, 200.0, 300.0) == 0
    nc.axis(1).velocity_override = 1_000_000
    nc.cycle(4000)
    assert slave.set_position == pytest.approx(70.0)


def functions(nc: Nc) -> tuple[Tables, Table]:
    """A cyclic motion function that axis 2 follows."""
    table = nc.tables.create(8, TableType.MOTION_FUNCTION, TableSubType.MONOTONIC_CYCLIC, 2, 1)
    nc.tables.write_points(table, 0, packed(*CURVED))
    demand = CamDemand(8, slave_absolute=1, master_absolute=1, slave_offset=0.5, master_offset=-2.0)
    nc.axis(2).position_range_window = 50.0
    assert commands.couple_by_cam(nc.axis(2), 13, 1, demand) == 0
    nc.cycle()
    return nc.tables, table


def test_changed_points_wait_with_the_offsets_of_now(nc: Nc) -> None:
    tables, table = functions(nc)
    layer = nc.axis(2).cams[0]
    later = PointActivation(CamActivation.NEXT_CYCLE, 4.0, CamScaling.OFF, CamScaling.AUTO_OFFSET)
    tables.change_online(table, later)
    tables.write_points(table, 1, packed((*CURVED[1][:6], 11.0, 0.0, 0.0, 0.0)))
    assert (layer.change.kind, layer.change.when) == (5, CamActivation.NEXT_CYCLE)
    assert (layer.change.position, layer.next.table, layer.change.returns) == (4.0, 8, 0)
    assert (layer.change.master_type, layer.change.slave_type) == (2, 1)
    assert (layer.next.master_offset, layer.next.slave_offset) == (-2.0, 0.5)
    assert (layer.next.master_scaling, layer.next.slave_scaling) == (1.0, 1.0)
    assert (layer.next.master_absolute, layer.next.slave_absolute) == (1, 1)
    assert layer.next.cam != layer.now.cam
    assert tables.cams.numbers[layer.now.cam + 4] == 9.0
    assert tables.cams.numbers[layer.next.cam + 4] == 11.0
    assert tables.cam(8, 0) == layer.next.cam
    tables.write_points(table, 1, packed((*CURVED[1][:6], 12.0, 0.0, 0.0, 0.0)))
    assert tables.cams.numbers[layer.now.cam + 4] == 9.0
    assert tables.cams.numbers[layer.next.cam + 4] == 12.0
    tables.change_online(table, PointActivation(CamActivation.OFF))
    tables.write_points(table, 1, packed((*CURVED[1][:6], 13.0, 0.0, 0.0, 0.0)))
    assert (layer.change.kind, layer.next.table) == (0, 0)
    assert tables.cams.numbers[layer.now.cam + 4] == 9.0
    tables.change_online(table, PointActivation(CamActivation.INSTANTANEOUS))
    tables.write_points(table, 1, packed((*CURVED[1][:6], 14.0, 0.0, 0.0, 0.0)))
    assert (layer.change.kind, tables.cams.numbers[layer.now.cam + 4]) == (0, 14.0)


def test_refused_points_leave_slaves_what_they_had(nc: Nc) -> None:
    tables, table = functions(nc)
    layer = nc.axis(2).cams[0]
    nc.axis(2).position_range_window = 0.0
    before = bytes(table.motion)
    wild = packed((*CURVED[1][:6], 9e4, 0.0, 0.0, 0.0))
    refuses(NcError.TABLE_SLAVE_RANGE, tables.write_points, table, 1, wild)
    assert bytes(table.motion) == before
    assert tables.cams.numbers[layer.now.cam + 4] == 9.0
    assert tables.cams.numbers[tables.cam(8, 0) + 4] == 9.0
    assert table.slave_stroke == 9.0
    tables.change_online(table, PointActivation(CamActivation.NEXT_CYCLE))
    off = CamDemand(activation=CamActivation.OFF, slave_scaling=2.0)
    assert commands.change_cam_scaling(nc.axis(2), off) == 0
    refuses(NcError.ACTIVATION_PENDING, tables.write_points, table, 1, packed(CURVED[1]))
    tables.change_online(table, PointActivation(CamActivation.OFF))
    tables.write_points(table, 1, packed(CURVED[1]))


def block(tables: Tables, table_id: int, interpolation: int, count: int) -> list[float]:
    """The numbers of a cam."""
    first = tables.cam(table_id, interpolation)
    return list(tables.cams.numbers[first : first + HEADER + SPAN * count])


@pytest.mark.parametrize("interpolation", [CamInterpolation.LINEAR, CamInterpolation.LOCAL])
@pytest.mark.parametrize(("index", "step"), [(21, 1), (20, 1), (10, 4), (3, 2), (39, 1)])
def test_cam_that_was_edited_is_as_a_new_one(
    nc: Nc, interpolation: CamInterpolation, index: int, step: int
) -> None:
    """Another cam in use, and the same rows joined otherwise, stay what they are."""
    tables, rows = nc.tables, 20
    numbers = [value for n in range(rows) for value in (10.0 * n, float(n * n % 7))]
    tables.write(tables.create(8, TableType.CAMMING, 3, rows, 2), 0, numbers)
    for axis, table_id, joined in ((2, 8, interpolation), (3, 7, 0)):
        assert commands.couple_by_cam(nc.axis(axis), 11, 1, CamDemand(table_id, joined)) == 0
        nc.axis(axis).control_dword = 0
    nc.cycle()
    other = block(tables, 7, 0, 4)
    table = tables.find(8)
    fresh = [table.values[at] + 1.0 for at in (index,) if at < 40]
    fresh += [table.values[at] + 1.0 for at in (index + step,) if at < 40]
    tables.write(table, index, fresh, step)
    alone = Nc(2_000_000, [AxisParameters(1)], compiled=False).tables
    alone.write(alone.create(8, TableType.CAMMING, 3, rows, 2), 0, table.values)
    assert block(tables, 8, interpolation, rows) == block(alone, 8, interpolation, rows)
    assert block(tables, 7, 0, 4) == other
    nc.axis(2).control_dword = 7
    nc.cycle(2)
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.write, table, 20, [-1.0])
    assert block(tables, 8, interpolation, rows) == block(alone, 8, interpolation, rows)
    assert block(tables, 7, 0, 4) == other


def test_table_without_slave_takes_any_numbers(nc: Nc) -> None:
    """Also where its cam was asked for."""
    tables, table = nc.tables, nc.tables.find(7)
    tables.cam(7, 0)
    tables.write(table, 2, [400.0])
    assert table.values[2] == 400.0
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.cam, 7, 0)


def test_scaled_table_is_read_otherwise(nc: Nc) -> None:
    tables, table = nc.tables, nc.tables.find(7)
    assert table.points()[1] == (90.0, 30.0)
    tables.scale(table, table.scaling._replace(master_scaling=0.5, slave_offset=5.0))
    assert table.points()[1] == (45.0, 35.0)


def test_changed_points_leave_other_functions(nc: Nc) -> None:
    tables, table = functions(nc)
    other = tables.create(9, TableType.MOTION_FUNCTION, TableSubType.MONOTONIC_CYCLIC, 2, 1)
    tables.write_points(other, 0, packed(*CURVED))
    assert commands.couple_by_cam(nc.axis(3), 13, 1, CamDemand(9)) == 0
    layer, beside = nc.axis(2).cams[0], nc.axis(3).cams[0]
    for activation in (CamActivation.NEXT_CYCLE, CamActivation.INSTANTANEOUS):
        tables.change_online(table, PointActivation(activation))
        tables.write_points(table, 1, packed((*CURVED[1][:6], 11.0, 0.0, 0.0, 0.0)))
        assert (beside.change.kind, tables.cams.numbers[beside.now.cam + 4]) == (0, 9.0)
        assert tables.cam(9, 0) == beside.now.cam
    assert tables.cams.numbers[layer.now.cam + 4] == 11.0
    tables.change_online(other, PointActivation(CamActivation.NEXT_CYCLE))
    tables.write_points(other, 1, packed((*CURVED[1][:6], 12.0, 0.0, 0.0, 0.0)))
    assert tables.cams.numbers[beside.next.cam + 4] == 12.0
    assert (layer.change.kind, tables.cams.numbers[layer.now.cam + 4]) == (0, 11.0)


def test_kernels_are_notified_when_the_memory_has_grown(nc: Nc) -> None:
    tables = nc.tables
    reports: list[int] = []
    tables.laid_out = lambda: reports.append(len(tables.cams.numbers))
    tables.cam(7, 0)
    assert reports == []
    rows = 400
    numbers = [value for n in range(rows) for value in (float(n), 0.0)]
    tables.write(tables.create(8, TableType.CAMMING, 3, rows, 2), 0, numbers)
    tables.cam(8, 0)
    assert reports == [len(tables.cams.numbers)]
    assert reports[0] >= rows * SPAN


def test_points_written_again_and_again_need_no_more_memory(nc: Nc) -> None:
    tables, table = functions(nc)
    size = len(tables.cams.numbers)
    for n in range(40):
        slave = 9.0 + n % 2
        tables.write_points(table, 1, packed((*CURVED[1][:6], slave, 0.0, 0.0, 0.0)))
    assert len(tables.cams.numbers) == size


def test_function_that_is_followed_again_has_its_present_points(nc: Nc) -> None:
    tables, table = functions(nc)
    tables.write_points(table, 1, packed((*CURVED[1][:6], 11.0, 0.0, 0.0, 0.0)))
    assert commands.decouple(nc.axis(2)) == 0
    tables.cam(7, 0)
    tables.write_points(table, 1, packed((*CURVED[1][:6], 12.0, 0.0, 0.0, 0.0)))
    first = tables.cam(8, 0)
    assert tables.cams.numbers[first + 4] == 12.0
    assert tables.cam(8, 0) == first


def test_three_rows_are_enough_for_values_of_a_spline(nc: Nc) -> None:
    tables = nc.tables
    values = []
    for rows, numbers in ((3, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0]), (2, [0.0, 0.0, 360.0, 100.0])):
        table = tables.create(8, TableType.CAMMING, 3, rows, 2)
        tables.write(table, 0, numbers)
        values.append(tables.characteristic_values(table, 1.0))
        tables.delete(8)
    lines = tables.create(8, TableType.CAMMING, 3, 3, 2)
    tables.write(lines, 0, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0])
    assert commands.couple_by_cam(nc.axis(2), 10, 1, CamDemand(8)) == 0
    assert tables.characteristic_values(lines, 1.0) != values[0]
    falling = tables.create(9, TableType.CAMMING, 3, 2, 2)
    tables.write(falling, 0, [1.0, 0.0, 0.0, 0.0])
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.characteristic_values, falling, 1.0)
    valve = tables.create(10, TableType.CHARACTERISTIC, 3, 2, 2)
    tables.write(valve, 0, [0.0, 0.0, 1.0, 1.0])
    refuses(NcError.TABLE_WRONG_KIND, tables.cam, 10, 0)


def test_kernels_are_notified_when_changed_points_need_more_memory(nc: Nc) -> None:
    tables, count = nc.tables, 60
    table = tables.create(8, TableType.MOTION_FUNCTION, 3, count, 1)
    points = [(n, 5, 0, 1, 0, float(n), 0.0, 0.0, 0.0, 0.0) for n in range(count)]
    tables.write_points(table, 0, packed(*points))
    assert commands.couple_by_cam(nc.axis(2), 13, 1, CamDemand(8)) == 0
    reports: list[int] = []
    tables.laid_out = lambda: reports.append(len(tables.cams.numbers))
    size = len(tables.cams.numbers)
    while len(tables.cams.numbers) == size:
        assert reports == []
        tables.change_online(table, PointActivation(CamActivation.NEXT_CYCLE))
        tables.write_points(table, 1, packed(points[1]))
    assert reports == [len(tables.cams.numbers)]


def test_points_for_one_cycle_return_unless_that_is_deleted(nc: Nc) -> None:
    tables, master, slave = nc.tables, nc.axis(1), nc.axis(2)
    table = tables.create(8, TableType.MOTION_FUNCTION, TableSubType.MONOTONIC_CYCLIC, 3, 1)

    def points(*places: tuple[float, float]) -> bytes:
        return packed(*((n, 5, 0, 1, 0, *each, 0.0, 0.0, 0.0) for n, each in enumerate(places)))

    def write(activation: CamActivation, value: float) -> None:
        tables.change_online(table, PointActivation(activation))
        tables.write_points(table, 0, points((0.0, 0.0), (4.0, value), (9.0, 9.0)))

    def at(place: float) -> float:
        assert commands.start(master, 1, place, 300.0) == 0
        nc.cycle(600)
        assert master.set_position == place
        return slave.set_position

    master.velocity_override = 1_000_000
    slave.position_range_window = 50.0
    write(CamActivation.INSTANTANEOUS, 3.0)
    absolute = CamDemand(8, slave_absolute=1, master_absolute=1)
    assert commands.couple_by_cam(slave, 13, 1, absolute) == 0
    write(CamActivation.NEXT_CYCLE_ONCE, 4.0)
    assert (at(4.0), at(13.0)) == (3.0, 13.0)
    refuses(NcError.ACTIVATION_PENDING, write, CamActivation.NEXT_CYCLE, 5.0)
    write(CamActivation.INSTANTANEOUS, 5.0)
    nc.cycle()
    tables.cam(7, 0)  # in memory that is free again
    assert (slave.set_position, at(22.0)) == (14.0, 21.0)
    write(CamActivation.NEXT_CYCLE_ONCE, 6.0)
    assert at(31.0) == 33.0
    write(CamActivation.DELETE_QUEUED, 6.0)
    assert (at(40.0), tables.user_count(8)) == (42.0, 1)
