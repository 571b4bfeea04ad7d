"""Characteristic tables: what they may be, who uses them, and what drives make of them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.elements import choose_control_loop
from achse.motion.tables import Table, TableError, TableParameters

VALVE = [(-1.0, -1.0), (-0.1, -0.4), (0.0, 0.0), (0.1, 0.5), (1.0, 1.0)]
"""Velocity, output: most of the output is needed for the first tenth of the velocity."""

ENABLED = {"control_dword": 7, "velocity_override": 1_000_000, "drive_reference_velocity": 1000.0}


def build(
    compiled: bool = False,
    points: Sequence[Any] = VALVE,
    second: Mapping[str, float] | None = None,
    **values: float,
) -> Nc:
    """Axis 1 with two drives, the other one with the values `second`; table 3 of `points`."""
    axis = AxisParameters(1, values=ENABLED | values, drive_ids=(1, 2), elements=[second or {}])
    nc = Nc(
        2_000_000,
        [axis, AxisParameters(5)],
        tables=[TableParameters(3, points, "valve")],
        compiled=compiled,
    )
    nc.cycle(2)
    return nc


def refuses(error: NcError, call: Callable[..., object], *arguments: Any) -> None:
    with pytest.raises(TableError) as caught:
        call(*arguments)
    assert caught.value.error is error


def fresh(sub_type: int = 3, rows: int = 3, columns: int = 2, table_id: int = 7) -> Table:
    return Table(table_id, TableType.CHARACTERISTIC, sub_type, rows, columns)


def test_a_fresh_table_is_empty_and_no_function_yet() -> None:
    table = fresh()
    assert list(table.values) == [0.0] * 6
    assert (table.element_count, table.step_width, table.table_name) == (6, 0.0, "Table 7")
    refuses(NcError.TABLE_NOT_MONOTONIC, table.curve)


def test_places_rise_in_equal_steps_where_the_type_says_so() -> None:
    nc = build()
    table = fresh(TableSubType.EQUIDISTANT_LINEAR)
    nc.tables.write(table, 0, [0.0, 0.1, 0.3, 0.2, 0.6, 0.5])
    assert table.step_width == pytest.approx(0.3)
    assert table.points() == [(0.0, 0.1), (0.3, 0.2), (0.6, 0.5)]
    nc.tables.write(table, 4, [0.7])
    refuses(NcError.TABLE_STEP_WIDTH, table.curve)
    refuses(NcError.TABLE_COLUMN_COUNT, fresh(columns=1).points)


def test_a_table_is_read_between_its_points_and_not_beyond() -> None:
    table = build().tables.find(3)
    assert table.read(0.05) == pytest.approx((0.25, 5.0, 0.0))
    assert table.read(1.0) == pytest.approx((1.0, 5.0 / 9.0, 0.0))
    assert table.read(-1.0)[0] == -1.0
    refuses(NcError.TABLE_MASTER_BELOW, table.read, -1.01)
    refuses(NcError.TABLE_MASTER_ABOVE, table.read, 1.01)


def test_a_table_in_use_stays_and_stays_a_function() -> None:
    nc = build()
    axis, tables = nc.axis(1), nc.tables
    tables.characteristics.choose(axis.drive, 3)
    tables.characteristics.choose(nc.element("drive", 2), 3)
    assert tables.user_count(3) == 2
    refuses(NcError.SLAVE_TABLE_IN_USE, tables.delete, 3)
    refuses(NcError.SLAVE_TABLE_IN_USE, tables.characteristics.remove, axis.drive, 3)
    digest = nc.digest()
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.write, tables.find(3), 0, [1.0])
    refuses(NcError.TABLE_PARAMETER, tables.write, tables.find(3), 0, [float("inf")])
    assert nc.digest() == digest
    tables.characteristics.choose(nc.element("drive", 2), 0)
    refuses(NcError.TABLE_NOT_FOUND, tables.characteristics.remove, nc.axis(5).drive, 3)
    tables.characteristics.remove(axis.drive, 3)
    assert (axis.drive.table_id, axis.drive.curve_count, len(tables)) == (0, 0, 0)


def test_a_drive_takes_no_table_that_is_no_characteristic() -> None:
    nc = build(points=[(0.0, 0.0), (1.0, 1.0)])
    axis, tables = nc.axis(1), nc.tables
    tables.add(fresh())
    refuses(NcError.TABLE_NOT_FOUND, tables.characteristics.choose, axis.drive, 8)
    refuses(NcError.TABLE_NOT_MONOTONIC, tables.characteristics.choose, axis.drive, 7)
    assert axis.drive.table_id == 0
    tables.characteristics.choose(axis.drive, 3)
    refuses(NcError.TABLE_TOO_FEW_SPLINE_POINTS, tables.characteristics.interpolate, axis.drive, 2)
    assert axis.drive.table_interpolation_type == 0


@pytest.mark.parametrize(
    ("points", "values", "message"),
    [
        ([(0.0, 0.0)], {}, "1 rows, expected 2 or more"),
        ([(0.0, 0.0), (0.0, 1.0)], {}, "table 3: its places do not rise"),
        ([(0.0, 0.0), (1e-10, 1.0)], {}, "table 3: its places do not rise"),
        ([(0.0, 0.0), (1.0, 1e4)], {}, "table 3: its numbers are shares up to 1000"),
        (VALVE, {"drive_table_id": 4}, "no table 4, for axis 1"),
        (VALVE, {"simulation_table_id": 4}, "no table 4"),
    ],
)
def test_a_configured_table_that_cannot_be(
    points: list[Any], values: dict[str, Any], message: str
) -> None:
    with pytest.raises(TableError, match=message):
        build(points=points, **values)


def travel(nc: Nc, velocity: float) -> Axis:
    axis = nc.axis(1)
    commands.start(axis, 3 if velocity > 0.0 else 4, 0.0, abs(velocity))
    nc.cycle(1500)
    return axis


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(
    ("velocity", "output"), [(50.0, 25.0), (550.0, 75.0), (-50.0, -20.0), (-550.0, -70.0)]
)
def test_the_output_goes_through_the_table_and_the_valve_is_its_inverse(
    compiled: bool, velocity: float, output: float
) -> None:
    axis = travel(build(compiled, drive_table_id=3), velocity)
    assert axis.drive.output_percent == pytest.approx(velocity / 10.0, abs=0.02)
    assert axis.drive.output_percent_nonlinear == pytest.approx(output, abs=0.05)
    assert axis.machine.velocity == pytest.approx(velocity, rel=1e-2)


def test_a_spline_bends_between_the_points() -> None:
    straight = travel(build(drive_table_id=3), 500.0).drive.output_percent_nonlinear
    bent = travel(build(drive_table_id=3, drive_table_interpolation_type=2), 500.0)
    assert abs(bent.drive.output_percent_nonlinear - straight) > 1.0


def test_the_output_is_shown_before_it_is_on_its_way() -> None:
    nc = build(drive_table_id=3, simulation_dead_time=0.01)
    axis = nc.axis(1)
    commands.start(axis, 3, 0.0, 50.0)
    for _ in range(30):
        nc.cycle()
        assert axis.drive.output_percent_nonlinear == pytest.approx(
            5.0 * axis.drive.output_percent, abs=1e-9
        )


FREE = {"controller_following_error_position_monitoring_enable": 0, "controller_position_kv": 0.0}


def test_a_valve_with_a_curve_of_its_own_needs_the_right_table() -> None:
    """The valve's curve is output to velocity: turn the NC's table round, and all is linear."""
    inverse = [(output, velocity) for velocity, output in VALVE]
    for linearised, reached in ((0, 20.0), (1, 100.0)):
        nc = Nc(
            2_000_000,
            [
                AxisParameters(
                    1,
                    values=ENABLED
                    | FREE
                    | {"simulation_table_id": 4, "drive_table_id": 3 * linearised},
                )
            ],
            tables=[TableParameters(3, VALVE), TableParameters(4, inverse)],
            compiled=False,
        )
        nc.cycle(2)
        assert travel(nc, 100.0).machine.velocity == pytest.approx(reached, rel=1e-6)
        assert nc.tables.user_count(4) == 1


@pytest.mark.parametrize("compiled", [False, True])
def test_points_that_change_are_in_use_with_the_next_cycle(compiled: bool) -> None:
    nc = build(compiled, drive_table_id=3)
    axis = travel(nc, 50.0)
    nc.tables.write(nc.tables.find(3), 7, [0.9])
    nc.cycle()
    share = axis.drive.output_percent
    assert axis.drive.output_percent_nonlinear == pytest.approx(9.0 * share, abs=1e-9)
    nc.tables.characteristics.choose(axis.drive, 0)
    nc.cycle()
    assert axis.drive.curve_count == 0


def test_the_hash_sees_the_numbers_of_tables() -> None:
    nc = build()
    before = nc.digest()
    nc.tables.write(nc.tables.find(3), 9, [0.95])
    assert nc.digest() != before


@pytest.mark.parametrize("interpolation", [0, 2])
def test_both_kernels_read_the_same_curve(interpolation: int) -> None:
    digests = set()
    for compiled in (False, True):
        nc = build(
            compiled, drive_table_id=3, drive_table_interpolation_type=interpolation,
            simulation_table_id=3, simulation_dead_time=0.004,
        )  # fmt: skip
        commands.start(nc.axis(1), 1, 80.0, 300.0)
        nc.cycle(400)
        digests.add(nc.digest())
    assert len(digests) == 1


def test_another_control_loop_brings_its_own_table() -> None:
    nc = build(second={"drive_table_id": 3})
    axis = nc.axis(1)
    assert axis.drive.curve_count == 0
    choose_control_loop(axis, 1)
    assert (axis.drive.table_id, axis.drive.curve_count) == (3, len(VALVE))
    nc.tables.characteristics.interpolate(axis.drive, 2)
    assert travel(nc, 100.0).drive.output_percent_nonlinear == pytest.approx(50.0, abs=0.05)


def test_a_drive_whose_loop_is_open_has_no_output() -> None:
    """Whatever a characteristic with a jump at 0, and an offset, would make of it."""
    jump = [(-1.0, -1.0), (-1e-6, -0.2), (1e-6, 0.4), (1.0, 1.0)]
    nc = build(points=jump, drive_table_id=3, drive_output_offset=0.01)
    axis = nc.axis(1)
    assert axis.drive.output_percent_nonlinear != 0.0
    axis.control_dword = 0
    nc.cycle(500)
    assert (axis.loop_closed, axis.drive.output_percent_nonlinear) == (0, 0.0)
    assert axis.machine.velocity == 0.0
