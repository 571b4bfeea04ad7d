"""Commands of cams: what is refused and with which code; refused, nothing has changed."""

from dataclasses import replace
from math import inf, nan, nextafter
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableType
from achse.motion import AxisParameters, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.commands.slaves.cams import (
    LARGEST_OFFSET,
    LARGEST_SCALING,
    _check,
    _check_begin,
    _check_in_range,
    _fresh,
    _rows_as_seen,
)
from achse.motion.couplings.cams import master_position_of, names_of
from achse.motion.record import CAM
from achse.motion.rows import NcRows
from achse.motion.setpoints.setpoint import shift_setpoint
from achse.motion.states import CamActivation, CamOperation, CamScaling
from achse.motion.tables.memory import BEGIN, CYCLIC, PERIOD

VALUES = {"control_dword": 7, "velocity_override": 1_000_000}


def build() -> Nc:
    """Axis 2 is to follow axis 1; table 7 is a cam, 8 a characteristic, 9 empty, 10 one column."""
    nc = Nc(2_000_000, [AxisParameters(n, values=VALUES) for n in (1, 2, 3)])
    tables = nc.tables
    cam = tables.create(7, TableType.CAMMING, 3, 3, 2)
    tables.write(cam, 0, [0.0, 0.0, 90.0, 30.0, 360.0, 100.0])
    valve = tables.create(8, TableType.CHARACTERISTIC, 3, 2, 2)
    tables.write(valve, 0, [0.0, 0.0, 1.0, 1.0])
    tables.create(9, TableType.CAMMING, 3, 2, 2)
    short = tables.create(10, TableType.CAMMING, 3, 2, 2)
    tables.write(short, 0, [0.0, 0.0, 1.0, 1.0])
    falling = tables.create(11, TableType.CAMMING, 4, 2, 2)
    tables.write(falling, 0, [1.0, 0.0, 0.0, 1.0])
    nc.cycle(3)
    return nc


def couple(nc: Nc, law: int = 10, master: int = 1, *more: int, **demand: Any) -> int:
    options = {"table_id": 7, "master_absolute": 1, "slave_absolute": 1} | demand
    return commands.couple_by_cam(nc.axis(2), law, master, CamDemand(**options), *more)


@pytest.mark.parametrize(
    ("demand", "error"),
    [
        ({"table_id": 1}, NcError.TABLE_NOT_FOUND),
        ({"table_id": 8}, NcError.TABLE_WRONG_KIND),
        ({"table_id": 9}, NcError.TABLE_SLAVE_WITHOUT_TABLE),
        ({"table_id": 10, "interpolation": 2}, NcError.TABLE_TOO_FEW_SPLINE_POINTS),
        ({"table_id": 11}, NcError.TABLE_NOT_MONOTONIC),
        ({"interpolation": 1}, NcError.TABLE_TOO_FEW_SPLINE_POINTS),
        ({"interpolation": 4}, NcError.TABLE_INTERPOLATION_TYPE),
        ({"slave_offset": nan}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"master_offset": 1e10}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"master_scaling": 0.0}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"slave_scaling": inf}, NcError.SLAVE_COUPLING_PARAMETER),
        ({"slave_offset": 100.0}, NcError.TABLE_SLAVE_RANGE),
        ({"activation": CamActivation.NEXT_CYCLE_ONCE}, NcError.ONLINE_CHANGE_MODE),
        ({"activation": CamActivation.OFF}, NcError.ONLINE_CHANGE_MODE),
        ({"activation": 10}, NcError.ONLINE_CHANGE_MODE),
        ({"activation": 3, "master_absolute": 0}, NcError.ONLINE_CHANGE_MODE),
        ({"activation": 1, "master_absolute": 0}, NcError.ONLINE_CHANGE_MODE),
        ({"master_type": CamScaling.AUTO_OFFSET}, NcError.SCALING_WITHOUT_REFERENCE_TABLE),
        ({"master_type": 3}, NcError.SCALING_MODE),
        ({"slave_type": 3}, NcError.SCALING_MODE),
        ({"activation": 5, "master_offset": 10.0}, NcError.TABLE_MASTER_BELOW),
        ({"activation": 5, "master_offset": -370.0}, NcError.TABLE_MASTER_ABOVE),
    ],
)
def test_demands_that_are_refused(demand: dict[str, Any], error: NcError) -> None:
    nc = build()
    before = nc.digest()
    assert couple(nc, **demand) == error
    assert nc.digest() == before
    assert nc.tables.user_count(7) == 0


def test_couplings_that_are_refused() -> None:
    nc = build()
    before = nc.digest()
    assert couple(nc, 12) == NcError.SLAVE_TYPE
    assert couple(nc, 10, 9) == NcError.ADDRESS_MASTER_AXIS
    assert couple(nc, 10, 2) == NcError.MASTER_NOT_INSERTED
    assert couple(nc, 11, 1, 4) == NcError.TABLE_EXECUTION_MODE
    exchange, remove = CamOperation.EXCHANGE, CamOperation.REMOVE
    assert couple(nc, 11, 1, exchange, 7) == NcError.TABLE_SLAVE_WITHOUT_TABLE
    assert couple(nc, 11, 1, remove) == NcError.TABLE_SLAVE_WITHOUT_TABLE
    assert nc.digest() == before
    commands.start(nc.axis(1), 1, 500.0, 100.0)
    nc.cycle(20)
    before = nc.digest()
    assert couple(nc) == NcError.COUPLING_DURING_JOB
    assert nc.digest() == before


def test_an_axis_that_follows_no_cam_has_none_to_change() -> None:
    nc = build()
    axis, before = nc.axis(2), nc.digest()
    for code in (
        commands.change_cam_scaling(axis, CamDemand()),
        commands.change_cam_offsets(axis, 1.0, 2.0),
        commands.scale_slave(axis, 2.0),
        commands.follow_correction(axis, 7),
        commands.end_profile(axis, 7),
    ):
        assert code == NcError.SLAVE_TYPE
    assert commands.last_correction(axis, 7) is None
    assert nc.digest() == before


def test_changes_that_are_refused() -> None:
    nc = build()
    assert couple(nc, master_absolute=0) == 0
    axis = nc.axis(2)
    nc.cycle()
    before = nc.digest()
    change = commands.change_cam_scaling
    assert change(axis, CamDemand(table_id=8)) == NcError.TABLE_NOT_FOUND
    assert change(axis, CamDemand(activation=10)) == NcError.ONLINE_CHANGE_MODE
    assert change(axis, CamDemand(master_type=1)) == NcError.SCALING_MODE
    assert commands.change_cam_offsets(axis, 0.0, 0.0, 0.0, 1.0) == NcError.SLAVE_COUPLING_PARAMETER
    assert commands.change_cam_offsets(axis, 0.0, 0.0, 1.0, 0.0) == NcError.SLAVE_COUPLING_PARAMETER
    assert commands.scale_slave(axis, nan) == NcError.SLAVE_COUPLING_PARAMETER
    assert couple(nc, 10, 3) == NcError.SLAVE_COUPLING_PARAMETER
    assert couple(nc, 11) == NcError.SLAVE_ADDRESS
    assert nc.digest() == before


def test_cam_may_begin_within_a_linear_table() -> None:
    assert couple(build(), activation=CamActivation.AS_SOON_AS_POSSIBLE) == 0


def test_cam_that_has_not_begun_takes_no_other() -> None:
    nc = build()
    assert couple(nc, activation=CamActivation.NEXT_CYCLE) == 0
    assert couple(nc) == NcError.ACTIVATION_PENDING
    auto = {"master_type": CamScaling.AUTO_OFFSET}
    assert couple(nc, **auto) == NcError.SCALING_WITHOUT_REFERENCE_TABLE


def test_refused_coupling_holds_no_further_tables() -> None:
    nc = build()
    axis = nc.axis(2)
    before = nc.digest()
    code = commands.couple_by_cam(axis, 11, 9, CamDemand(7), further_tables=[7, 8])
    assert code == NcError.ADDRESS_MASTER_AXIS
    assert nc.digest() == before


def test_one_thing_waits_at_a_time() -> None:
    nc = build()
    assert couple(nc) == 0
    axis = nc.axis(2)
    off = CamDemand(activation=CamActivation.OFF)
    assert commands.change_cam_scaling(axis, off) == 0
    assert couple(nc) == NcError.ACTIVATION_PENDING
    assert commands.change_cam_scaling(axis, CamDemand(activation=7)) == 0
    assert couple(nc, activation=CamActivation.NEXT_CYCLE) == 0
    assert commands.change_cam_scaling(axis, off) == NcError.ACTIVATION_PENDING


def test_a_place_that_the_master_has_passed() -> None:
    nc = build()
    assert couple(nc) == 0
    commands.start(nc.axis(1), 1, 500.0, 100.0)
    nc.cycle(1000)
    passed = CamDemand(activation=CamActivation.MASTER_AXIS_POSITION, position=10.0)
    assert commands.change_cam_scaling(nc.axis(2), passed) == NcError.ACTIVATION_POSITION_PASSED
    assert commands.change_cam_offsets(nc.axis(2), 0.0, 0.0, 1.0, 1.0, 400.0) == 0


def test_four_cams_are_the_most() -> None:
    nc = build()
    for _ in range(4):
        assert couple(nc, 11, slave_absolute=0) == 0
        nc.cycle()
    assert nc.tables.user_count(7) == 4
    before = nc.digest()
    assert couple(nc, 11, slave_absolute=0) == NcError.TOO_MANY_TABLES
    assert nc.digest() == before
    with pytest.raises(Exception, match="has 4 users"):
        nc.tables.delete(7)


def test_offsets_and_scalings_act_at_once() -> None:
    nc = build()
    assert couple(nc) == 0
    axis = nc.axis(2)
    assert commands.change_cam_offsets(axis, -14.5, -45.0) == 0
    nc.cycle()
    assert axis.set_position == 0.5
    assert commands.scale_slave(axis, 1.2) == 0
    nc.cycle()
    assert axis.set_position == 3.5
    assert commands.change_cam_offsets(axis, 0.0, 0.0, 3.0, 2.0) == 0
    nc.cycle()
    layer = axis.cams[0]
    assert (axis.set_position, layer.now.slave_scaling, layer.now.master_scaling) == (0.0, 3.0, 2.0)


@pytest.mark.parametrize("law", [10, 11])
def test_a_master_that_led_before_is_where_it_is_now(law: int) -> None:
    """Let go, it moves on: the next cam looks at its place, not at the one it last showed."""
    nc = build()
    master, slave = nc.axis(1), nc.axis(2)
    assert couple(nc, law) == 0
    nc.cycle()
    assert commands.decouple(slave) == 0
    assert commands.universal_start(master, 1, 90.0, 100.0) == 0
    nc.cycle(2000)
    assert master.set_position == 90.0
    assert couple(nc, law) == NcError.TABLE_SLAVE_RANGE
    assert couple(nc, law, slave_offset=-30.0) == 0
    nc.cycle()
    assert slave.set_position == pytest.approx(0.0, abs=1e-12)


def test_a_master_that_was_renamed_while_it_led_has_its_own_positions_later() -> None:
    nc = build()
    master, slave = nc.axis(1), nc.axis(2)
    assert couple(nc) == 0
    nc.cycle()
    shift_setpoint(master, 90.0)
    nc.cycle()
    assert slave.set_position == 0.0
    assert commands.decouple(slave) == 0
    assert couple(nc) == NcError.TABLE_SLAVE_RANGE
    assert couple(nc, slave_offset=-30.0) == 0


def test_a_cam_of_another_master_leaves_the_names_of_the_first() -> None:
    nc = build()
    slave = nc.axis(2)
    assert couple(nc, 11) == 0
    nc.cycle()
    shift_setpoint(nc.axis(1), 90.0)
    nc.cycle()
    assert couple(nc, 11, 3, CamOperation.ADDITIVE) == 0
    nc.cycle(3)
    assert slave.set_position == 0.0


@pytest.mark.parametrize(
    ("field", "largest"),
    [
        ("slave_offset", LARGEST_OFFSET),
        ("master_offset", LARGEST_OFFSET),
        ("position", LARGEST_OFFSET),
        ("slave_scaling", LARGEST_SCALING),
        ("master_scaling", LARGEST_SCALING),
    ],
)
def test_numbers_of_a_demand_have_bounds(field: str, largest: float) -> None:
    axis, at_once = build().axis(2), (CamActivation.INSTANTANEOUS,)
    refused = NcError.SLAVE_COUPLING_PARAMETER
    for sign in (1.0, -1.0):
        for number, code in (
            (largest, 0),
            (nextafter(largest, inf), refused),
            (inf, refused),
            (nan, refused),
        ):
            options: dict[str, Any] = {field: sign * number}
            demand = CamDemand(**options)
            assert _check(axis, demand, at_once) == code
        if field == "master_scaling":
            for number, code in ((1e-6, 0), (nextafter(1e-6, 0.0), refused)):
                demand = CamDemand(master_scaling=sign * number)
                assert _check(axis, demand, at_once) == code
                off = replace(demand, master_type=CamScaling.OFF)
                assert _check(axis, off, at_once) == 0
    assert _check(axis, CamDemand(slave_scaling=0.0), at_once) == 0
    assert _check(axis, CamDemand(), ()) == NcError.ONLINE_CHANGE_MODE


def test_only_a_cam_in_place_of_another_may_be_for_one_cycle() -> None:
    """One alone always is in its place, whatever the operation."""
    once = CamActivation.NEXT_CYCLE_ONCE
    for law, operation, code in (
        (10, CamOperation.DEFAULT, 0),
        (10, CamOperation.REMOVE, 0),
        (11, CamOperation.EXCHANGE, 0),
        (11, CamOperation.ADDITIVE, NcError.ONLINE_CHANGE_MODE),
        (11, CamOperation.DEFAULT, NcError.ONLINE_CHANGE_MODE),
    ):
        nc = build()
        assert couple(nc, law, 1, CamOperation.REMOVE if law == 10 else CamOperation.DEFAULT) == 0
        nc.cycle()
        assert couple(nc, law, 1, operation, activation=once) == code


@pytest.mark.parametrize(
    ("at", "demand", "cyclic", "error"),
    [
        (28.0, {}, 0, None),
        (27.5, {}, 0, NcError.TABLE_MASTER_BELOW),
        (228.0, {}, 0, None),
        (228.5, {}, 0, NcError.TABLE_MASTER_ABOVE),
        (27.5, {}, 1, None),
        (27.5, {"master_absolute": 0}, 0, None),
        (10.0, {"master_type": CamScaling.OFF}, 0, None),
        (9.5, {"master_type": CamScaling.OFF}, 0, NcError.TABLE_MASTER_BELOW),
        (110.0, {"master_type": CamScaling.OFF}, 0, None),
        (110.5, {"master_type": CamScaling.OFF}, 0, NcError.TABLE_MASTER_ABOVE),
    ],
)
def test_master_is_within_a_linear_cam_or_refused(
    at: float, demand: dict[str, Any], cyclic: int, error: NcError | None
) -> None:
    """The cam is from 10 to 110; scaled by 2 and moved by 8 it is from 28 to 228."""
    first = 8
    numbers = [0.0] * 20
    numbers[first + BEGIN], numbers[first + PERIOD], numbers[first + CYCLIC] = 10.0, 100.0, cyclic
    layer: Any = CAM.plain()
    layer.next.cam = first
    rows = NcRows((), (), (), (), numbers)
    options = {"master_absolute": 1, "master_scaling": 2.0, "master_offset": 8.0} | demand
    code = _check_in_range(rows, layer, CamDemand(**options), at)
    assert code == (0 if error is None else error.number)


@pytest.mark.parametrize("activation", [2, 8, 9])
@pytest.mark.parametrize("ahead", [1.0, 0.0, -1.0])
@pytest.mark.parametrize("moves", [5.0, 0.0, -5.0])
def test_cam_cannot_begin_at_a_place_behind_a_moving_master(
    activation: int, ahead: float, moves: float
) -> None:
    """In its own positions: it was renamed while it led."""
    nc = build()
    master, slave = nc.axis(1), nc.axis(2)
    assert couple(nc) == 0
    master.leading_value.position, master.leading_value.offset, master.leading_value.velocity = (
        20.0,
        7.0,
        moves,
    )
    later: dict[str, Any] = {"activation": activation, "position": 27.0 + ahead}
    passed = moves * ahead < 0.0
    demand = CamDemand(**later, slave_type=CamScaling.AUTO_OFFSET)
    layer = _fresh(slave, master, demand, slave.cams[0].now.cam)
    layer.next.slave_absolute = 0
    refused = _check_begin(slave, layer, demand, master) == NcError.ACTIVATION_POSITION_PASSED
    if moves:
        master.leading_value.position = 20.0
        assert refused is (moves * (demand.position - _seen(slave, layer, master)) < 0.0)
    else:
        assert refused is False
    master.leading_value.position, master.leading_value.offset, master.leading_value.velocity = (
        20.0,
        7.0,
        moves,
    )
    code = commands.change_cam_scaling(slave, demand)
    by_axis = activation == CamActivation.MASTER_AXIS_POSITION
    assert (code == NcError.ACTIVATION_POSITION_PASSED) is (by_axis and passed)


def _seen(slave: Any, layer: Any, master: Any) -> float:
    """Own position of a master as a slave sees it."""
    rows = _rows_as_seen(slave, master)
    return master_position_of(slave, rows, layer) + names_of(rows, layer)


def test_cam_that_waits_to_begin_is_not_changed() -> None:
    nc = build()
    assert couple(nc, 11, activation=CamActivation.NEXT_CYCLE) == 0
    axis = nc.axis(2)
    for code in (
        commands.change_cam_offsets(axis, 0.0, 0.0),
        commands.scale_slave(axis, 2.0),
        commands.change_cam_scaling(axis, CamDemand(7)),
        commands.end_profile(axis, 7),
    ):
        assert code == NcError.ACTIVATION_PENDING
    assert commands.end_profile(axis, 8) == NcError.TABLE_NOT_FOUND
    forget = CamDemand(activation=CamActivation.DELETE_QUEUED)
    assert commands.change_cam_scaling(axis, forget) == NcError.DECOUPLING_NOT_POSSIBLE
    assert couple(nc, 11, activation=CamActivation.NEXT_CYCLE) == 0
    assert [each.change.kind for each in axis.cams[:3]] == [1, 1, 0]
    assert commands.change_cam_scaling(axis, replace(forget, table_id=8)) == NcError.TABLE_NOT_FOUND
    assert commands.change_cam_scaling(axis, forget) == 0
    assert [each.change.kind for each in axis.cams[:3]] == [0, 1, 0]
    assert commands.change_cam_scaling(axis, forget) == NcError.DECOUPLING_NOT_POSSIBLE


def test_cam_beside_one_at_work_may_be_forgotten_or_goes_when_nothing_waits() -> None:
    nc = build()
    axis = nc.axis(2)
    assert couple(nc, 11) == 0
    nc.cycle()
    assert couple(nc, 11, table_id=10, activation=CamActivation.NEXT_CYCLE, slave_absolute=0) == 0
    assert axis.cams[1].change.kind == 1
    forget = CamDemand(10, activation=CamActivation.DELETE_QUEUED)
    assert commands.change_cam_scaling(axis, forget) == 0
    assert (axis.cams[1].change.kind, axis.cams[1].next.table) == (0, 0)
    assert couple(nc, 11, table_id=10, slave_absolute=0) == 0
    nc.cycle()
    off = CamDemand(10, activation=CamActivation.OFF)
    assert commands.change_cam_scaling(axis, off) == 0
    assert (axis.cams[1].change.kind, axis.cams[1].next.table) == (2, 0)
    assert commands.end_profile(axis, 10) == NcError.ACTIVATION_PENDING
    assert commands.follow_correction(axis, 10) == NcError.SLAVE_TABLE_IN_USE
    assert commands.last_correction(axis, 10) is None


def test_offsets_may_wait_for_a_master_position() -> None:
    nc = build()
    assert couple(nc) == 0
    nc.cycle()
    layer = nc.axis(2).cams[0]
    assert commands.change_cam_offsets(nc.axis(2), 1.0, 2.0, 3.0, 4.0, 400.0) == 0
    assert (layer.change.when, layer.change.position) == (CamActivation.MASTER_AXIS_POSITION, 400.0)
    assert (layer.next.slave_offset, layer.next.master_offset) == (1.0, 2.0)
    assert (layer.next.slave_scaling, layer.next.master_scaling) == (3.0, 4.0)


def test_correction_waits_for_its_place_and_reports_what_it_added() -> None:
    nc = build()
    axis = nc.axis(2)
    assert couple(nc, 11) == 0
    nc.cycle()
    assert commands.follow_correction(axis, 10, 50.0) == 0
    layer = axis.cams[1]
    assert (layer.once, layer.change.kind, layer.change.position) == (1, 1, 50.0)
    assert layer.change.when == CamActivation.MASTER_AXIS_POSITION
    layer.now.table, layer.part = 10, 0.5
    assert commands.last_correction(axis, 10) == 0.5
    assert commands.last_correction(axis, 7) is None


ADD, EXCHANGE, REMOVE = CamOperation.ADDITIVE, CamOperation.EXCHANGE, CamOperation.REMOVE


def test_slave_of_one_cam_couples_whatever_the_operation() -> None:
    nc = build()
    assert couple(nc, 10, 1, EXCHANGE) == 0
    assert nc.axis(2).camming.count == 1


def test_cam_may_begin_beside_its_master_if_the_slave_is_not_fixed() -> None:
    beside: dict[str, Any] = {"activation": CamActivation.AS_SOON_AS_POSSIBLE, "master_offset": 9.0}
    for free in ({"slave_absolute": 0}, {"slave_type": CamScaling.AUTO_OFFSET}):
        assert couple(build(), **beside, **free) == 0
    assert couple(build(), **beside) == NcError.TABLE_MASTER_BELOW


def test_range_of_a_cam_is_in_the_positions_of_a_renamed_master() -> None:
    nc = build()
    assert commands.couple(nc.axis(3), 1, 1, 0, 0, 1.0) == 0
    nc.cycle()
    shift_setpoint(nc.axis(1), 90.0)
    nc.cycle()
    begins: dict[str, Any] = {"activation": CamActivation.AS_SOON_AS_POSSIBLE}
    assert couple(nc, master_offset=91.0, **begins) == NcError.TABLE_MASTER_BELOW
    assert couple(nc, master_offset=80.0, **begins) == 0


def test_further_cams_count_all_that_are_at_work() -> None:
    nc = build()
    for _ in range(2):
        assert couple(nc, 11, slave_absolute=0) == 0
        nc.cycle()
    assert commands.universal_start(nc.axis(1), 1, 90.0, 100.0) == 0
    nc.cycle(2000)
    slave = nc.axis(2)
    assert slave.set_position == pytest.approx(60.0)
    assert couple(nc, 11, slave_absolute=0) == 0
    nc.cycle()
    assert slave.set_position == pytest.approx(60.0)
    assert (slave.camming.count, slave.coupling.master_count) == (3, 1)


@pytest.mark.parametrize(
    ("master", "operation", "demand", "error"),
    [
        (9, ADD, {}, NcError.ADDRESS_MASTER_AXIS),
        (9, EXCHANGE, {}, NcError.ADDRESS_MASTER_AXIS),
        (1, ADD, {"activation": 3, "master_absolute": 0}, NcError.ONLINE_CHANGE_MODE),
        (1, ADD, {"slave_offset": 100.0}, NcError.TABLE_SLAVE_RANGE),
        (3, ADD, {"slave_offset": 100.0}, NcError.TABLE_SLAVE_RANGE),
        (3, ADD, {"slave_absolute": 0}, 0x4FFF),
        (1, REMOVE, {"activation": CamActivation.OFF}, NcError.ONLINE_CHANGE_MODE),
    ],
)
def test_change_of_several_cams_is_refused_and_changes_nothing(
    master: int, operation: int, demand: dict[str, Any], error: int
) -> None:
    nc = build()
    assert couple(nc, 11) == couple(nc, 11) == 0
    if error == 0x4FFF:
        commands.set_external_error(nc.axis(3), error)
    nc.cycle()
    before = nc.digest()
    assert couple(nc, 11, master, operation, 7, **demand) == error
    assert nc.digest() == before


def test_slave_follows_four_masters_at_most() -> None:
    """A cam that is taken out leaves its master followed."""
    nc = Nc(2_000_000, [AxisParameters(n, values=VALUES) for n in range(1, 7)])
    table = nc.tables.create(7, TableType.CAMMING, 3, 2, 2)
    nc.tables.write(table, 0, [0.0, 0.0, 360.0, 100.0])
    nc.cycle(3)
    for master in (1, 3, 4, 5):
        assert couple(nc, 11, master) == 0
    nc.cycle()
    assert couple(nc, 11, 1, REMOVE) == 0
    nc.cycle()
    assert nc.axis(2).coupling.master_count == 4
    assert couple(nc, 11, 6) == NcError.TOO_MANY_TABLES
    assert couple(nc, 11, 5) == 0


def test_last_cam_stays_while_another_waits_to_go() -> None:
    nc = build()
    assert couple(nc, 11) == couple(nc, 11, table_id=10) == 0
    nc.cycle()
    assert commands.end_profile(nc.axis(2), 10) == 0
    assert couple(nc, 11, 1, REMOVE) == NcError.DECOUPLING_NOT_POSSIBLE


def test_scaling_of_a_relative_cam_is_changed_by_its_user() -> None:
    nc = build()
    assert couple(nc, master_absolute=0) == 0
    assert commands.change_cam_scaling(nc.axis(2), CamDemand(7, slave_scaling=2.0)) == 0
    assert commands.change_cam_offsets(nc.axis(2), 0.0, 0.0, 1.0, 1.0, 0.0) == 0
    nc.cycle()
    assert nc.axis(2).cams[0].now.slave_scaling == 1.0


def test_correction_is_checked_and_begins_at_any_place() -> None:
    nc = build()
    axis = nc.axis(2)
    assert couple(nc, 11) == 0
    assert commands.follow_correction(axis, 10, nan) == NcError.SLAVE_COUPLING_PARAMETER
    assert commands.follow_correction(axis, 0) == NcError.TABLE_NOT_FOUND
    assert commands.follow_correction(axis, 10, 0.0) == 0
    assert commands.last_correction(axis, 10) == 0.0


def test_correction_that_runs_again_takes_its_own_place() -> None:
    """By the master of the first cam, whichever row that is in."""
    nc = build()
    axis = nc.axis(2)
    assert couple(nc, 11, 3) == 0
    for _ in range(5):
        assert commands.follow_correction(axis, 10) == 0
        nc.cycle()
    assert (axis.camming.count, axis.coupling.master_count, nc.axis(1).coupling_state) == (2, 1, 0)
