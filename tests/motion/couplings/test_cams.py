"""Slaves of cams: worked numbers in both kernels, changes at every activation, several cams."""

from collections.abc import Sequence
from itertools import pairwise
from math import pi, sin
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import Axis, AxisParameters, Nc, StateBit, commands
from achse.motion.commands import CamDemand
from achse.motion.couplings.cams import base, master_position_of, part_at, planned, step
from achse.motion.record import CAM_LAW
from achse.motion.setpoints.setpoint import shift_setpoint
from achse.motion.states import CamActivation, CamOperation, CamScaling, SlaveType
from achse.motion.tables import TableError
from achse.motion.tables.table import TableScaling

MONOTONIC_LINEAR = TableSubType.MONOTONIC_LINEAR
MONOTONIC_CYCLIC = TableSubType.MONOTONIC_CYCLIC
SOLO, SEVERAL = 10, 11

LIFTING = [(0.0, 0.0), (90.0, 30.0), (360.0, 100.0)]

VALUES = {
    "control_dword": 7,
    "velocity_override": 1_000_000,
    "max_velocity": 5000.0,
    "controller_following_error_position_monitoring_enable": 0,
}


class Line:
    """Axis 1 leads, axis 2 follows, axis 3 leads too."""

    def __init__(
        self, compiled: bool | None = None, cycle_ns: int = 2_000_000, **values: float
    ) -> None:
        presets = VALUES | values
        axes = [AxisParameters(n, values=presets) for n in (1, 2, 3)]
        self.nc = Nc(cycle_ns, axes, compiled=compiled)
        self.nc.cycle(3)
        self.master, self.slave, self.other = (self.nc.axis(n) for n in (1, 2, 3))

    def table(
        self,
        points: Sequence[tuple[float, float]],
        sub_type: TableSubType = MONOTONIC_CYCLIC,
        table_id: int = 7,
    ) -> None:
        tables = self.nc.tables
        table = tables.create(table_id, TableType.CAMMING, sub_type, len(points), 2)
        tables.write(table, 0, [number for point in points for number in point])

    def couple(self, table_id: int = 7, slave_type: int = SOLO, **demand: Any) -> int:
        """In absolute positions, unless it says otherwise."""
        absolute = {"slave_absolute": 1, "master_absolute": 1} | demand
        return commands.couple_by_cam(self.slave, slave_type, 1, CamDemand(table_id, **absolute))

    def put(self, axis: Axis, position: float) -> None:
        """Let an axis stand there."""
        assert commands.set_actual_position(axis, 1, position) == 0
        self.nc.cycle(2)

    def to(self, position: float, velocity: float = 500.0, axis: Axis | None = None) -> float:
        """Move a master; the slave's position there."""
        axis = axis or self.master
        assert commands.start(axis, 1, position, velocity) == 0
        for _ in range(20_000):
            self.nc.cycle()
            if axis.set_motion_phase == 0:
                break
        assert axis.set_position == position
        return self.slave.set_position

    def has(self, bit: StateBit) -> bool:
        return bool(self.slave.state_dword & bit)


@pytest.fixture
def line() -> Line:
    """In the kernel that is there: `test_cams_drawn` shows that both do the same."""
    return Line()


def test_offsets_and_scalings(line: Line) -> None:
    line.table(LIFTING, MONOTONIC_LINEAR)
    scaled: Any = {"master_offset": 50.0, "master_scaling": 2.0, "slave_offset": 7.0}
    line.put(line.slave, 7.0)
    assert line.couple(slave_scaling=0.5, **scaled) == 0
    assert line.to(140.0) == pytest.approx(14.5, abs=1e-12)
    assert line.slave.cams[0].slope == pytest.approx(0.5 / 2.0 / 3.0)


def test_the_sample_table_of_the_library(line: Line) -> None:
    """004 §3.1.5."""
    line.table(
        [(0.0, 0.0), (1.0, 0.10783), (2.0, 0.43114), (79.0, 279.61217), (80.0, 279.72)],
        MONOTONIC_LINEAR,
    )
    assert line.couple() == 0
    assert line.to(1.25) == pytest.approx(0.1886575, abs=1e-12)
    assert line.slave.cams[0].slope == pytest.approx(0.32331)
    assert line.to(79.5) == pytest.approx(279.666085, abs=1e-9)


def test_next_cycle_of_a_linear_table_begins_behind_its_end(line: Line) -> None:
    line.table(LIFTING, MONOTONIC_LINEAR)
    line.table(LIFTING, MONOTONIC_LINEAR, 8)
    assert line.couple() == 0
    line.to(360.0)
    assert line.couple(8, activation=CamActivation.NEXT_CYCLE, slave_absolute=0) == 0
    line.nc.cycle(3)
    assert line.slave.cams[0].now.table == 7
    line.to(361.0)
    assert line.slave.cams[0].now.table == 8


def test_jerk_of_a_slave_is_the_derivative_of_its_acceleration(line: Line) -> None:
    line.table([(10.0 * n, float(n * n)) for n in range(40)], MONOTONIC_LINEAR)
    assert line.couple(interpolation=2) == 0
    line.to(55.0)
    assert commands.universal_start(line.master, 1, 300.0, 200.0, 1000.0, 1000.0, 10_000.0) == 0
    samples = []
    for _ in range(40):
        line.nc.cycle()
        slave = line.slave
        samples.append((slave.set_acceleration, slave.set_jerk, line.master.set_jerk))
    steady = 0
    for (before, _, left), (_, jerk, here), (after, _, right) in zip(
        samples, samples[1:], samples[2:], strict=False
    ):
        if left == here == right:
            steady += 1
            assert jerk == pytest.approx((after - before) / 0.004, rel=0.02)
    assert steady > 20


def test_a_cyclic_table_lifts(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    assert line.to(450.0) == pytest.approx(130.0)
    assert commands.decouple(line.slave) == 0
    line.put(line.slave, 30.0)
    assert line.couple() == 0  # in the basic cycle again
    line.nc.cycle()
    assert line.slave.set_position == 30.0
    assert line.to(720.0) == pytest.approx(100.0)
    assert line.to(800.0) == pytest.approx(126.666666667)
    assert line.to(-90.0) == pytest.approx(-200.0 + 30.0 + 180.0 * 70.0 / 270.0)


def test_relative_positions_begin_where_the_axes_are(line: Line) -> None:
    line.table(LIFTING)
    line.put(line.master, 1000.0)
    line.put(line.slave, -3.0)
    relative: Any = {"slave_absolute": 0, "master_absolute": 0}
    assert line.couple(master_offset=-45.0, slave_offset=400.0, **relative) == 0
    line.nc.cycle()
    assert line.slave.set_position == -3.0
    assert line.to(1045.0) == pytest.approx(-3.0 + 15.0)


def test_outside_a_linear_table_the_slave_stands(line: Line) -> None:
    line.table(LIFTING, MONOTONIC_LINEAR)
    assert line.couple() == 0
    assert line.to(500.0) == 100.0
    assert line.slave.set_velocity == 0.0
    assert line.to(-50.0) == 0.0
    assert line.to(90.0) == 30.0


def test_a_spline_is_followed_with_its_derivatives(line: Line) -> None:
    line.table([(0.0, 0.0), (90.0, 30.0), (180.0, 20.0), (270.0, -10.0), (360.0, 0.0)])
    assert line.couple(interpolation=2) == 0
    assert commands.start(line.master, 1, 360.0, 400.0) == 0
    results = []
    while line.master.set_motion_phase:
        line.nc.cycle()
        results.append((line.slave.set_position, line.slave.set_velocity))
    for (s0, v0), (s1, v1) in pairwise(results):
        assert s1 - s0 == pytest.approx(0.001 * (v0 + v1), abs=2e-4)
    assert line.to(100.0) == pytest.approx(31.303155006859)
    assert line.slave.cams[0].slope == pytest.approx(0.094650205761)


def test_the_master_keeps_its_place_in_the_cam(line: Line) -> None:
    """The documented example: scaling 1 → 2 with the master at 90 of 360."""
    line.table(LIFTING)
    assert line.couple() == 0
    assert line.to(90.0) == 30.0
    demand = CamDemand(master_type=CamScaling.AUTO_OFFSET, master_scaling=2.0)
    assert commands.change_cam_scaling(line.slave, demand) == 0
    line.nc.cycle()
    layer = line.slave.cams[0]
    assert (layer.now.master_offset, layer.now.master_scaling) == (-90.0, 2.0)
    assert line.slave.set_position == 30.0
    assert line.to(180.0) == pytest.approx(30.0 + 45.0 * 70.0 / 270.0)


def test_the_slave_stays_when_its_offset_is_automatic(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    assert line.to(90.0) == 30.0
    demand = CamDemand(slave_type=CamScaling.AUTO_OFFSET, slave_scaling=3.0)
    assert commands.change_cam_scaling(line.slave, demand) == 0
    line.nc.cycle()
    assert line.slave.set_position == 30.0
    assert line.slave.cams[0].now.slave_offset == -60.0
    assert line.to(0.0) == -60.0


@pytest.mark.parametrize(
    ("activation", "position", "end", "exact"),
    [
        (CamActivation.INSTANTANEOUS, 0.0, 500.0, 60.0),
        (CamActivation.MASTER_CAM_POSITION, 80.0, 500.0, 80.0),
        (CamActivation.MASTER_CAM_POSITION, 30.0, 500.0, 390.0),
        (CamActivation.MASTER_AXIS_POSITION, 123.4, 500.0, 123.4),
        (CamActivation.MASTER_AXIS_POSITION, 12.0, -50.0, 12.0),
        (CamActivation.NEXT_CYCLE, 0.0, 500.0, 360.0),
        (CamActivation.NEXT_CYCLE, 0.0, -50.0, 0.0),
        (CamActivation.AS_SOON_AS_POSSIBLE, 0.0, 500.0, 60.0),
        (CamActivation.MASTER_AXIS_POSITION_POSITIVE, 70.0, 500.0, 70.0),
        (CamActivation.MASTER_AXIS_POSITION_NEGATIVE, 50.0, -50.0, 50.0),
        (CamActivation.MASTER_AXIS_POSITION_POSITIVE, 50.0, -50.0, None),
        (CamActivation.MASTER_AXIS_POSITION_NEGATIVE, 70.0, 500.0, None),
        (CamActivation.OFF, 0.0, 500.0, None),
    ],
)
def test_a_change_counts_from_the_exact_position(
    line: Line, activation: CamActivation, position: float, end: float, exact: float | None
) -> None:
    """Whatever the cycle time: the slave's offset tells where the change took place."""
    line.table(LIFTING)
    assert line.couple() == 0
    line.to(60.0)
    demand = CamDemand(
        activation=activation,
        position=position,
        master_type=CamScaling.OFF,
        slave_type=CamScaling.AUTO_OFFSET,
        slave_scaling=2.0,
    )
    assert commands.change_cam_scaling(line.slave, demand) == 0
    line.nc.cycle()
    at_once = activation in (CamActivation.INSTANTANEOUS, CamActivation.AS_SOON_AS_POSSIBLE)
    assert line.has(StateBit.CAM_SCALING_PENDING) == (not at_once)
    line.to(end, 777.0)
    layer = line.slave.cams[0]
    if exact is None:
        assert layer.now.slave_scaling == 1.0
        assert line.has(StateBit.CAM_SCALING_PENDING)
        forget = CamDemand(activation=CamActivation.DELETE_QUEUED)
        assert commands.change_cam_scaling(line.slave, forget) == 0
        line.nc.cycle()
        assert not line.has(StateBit.CAM_SCALING_PENDING)
        return
    cycles, place = divmod(exact, 360.0)
    value = place / 3.0 if place <= 90.0 else 30.0 + (place - 90.0) * 70.0 / 270.0
    assert layer.now.slave_offset == pytest.approx(-(value + 100.0 * cycles), abs=1e-9)
    assert not line.has(StateBit.CAM_SCALING_PENDING)


def test_tables_are_exchanged_in_motion(line: Line) -> None:
    line.table(LIFTING)
    line.table([(0.0, 0.0), (100.0, 50.0)], table_id=8)
    assert line.couple() == 0
    line.to(40.0)
    assert line.couple(8, activation=CamActivation.NEXT_CYCLE, slave_offset=70.0) == 0
    line.nc.cycle()
    assert line.has(StateBit.CAM_TABLE_QUEUED)
    assert [line.nc.tables.user_count(n) for n in (7, 8)] == [1, 1]
    assert line.to(90.0) == 30.0
    assert line.slave.coupling_table_index == 7
    assert line.to(400.0) == pytest.approx(0.5 * 400.0 - 150.0 + 70.0)
    assert line.slave.coupling_table_index == 8
    assert [line.nc.tables.user_count(n) for n in (7, 8)] == [0, 1]
    line.nc.tables.delete(7)


def hill(count: int = 3600) -> list[tuple[float, float]]:
    """Bestehorn up to 10 and down again, over 360."""
    points = []
    for n in range(count + 1):
        z = 2.0 * n / count
        up = z if z <= 1.0 else 2.0 - z
        points.append((360.0 * n / count, 10.0 * (up - sin(2.0 * pi * up) / (2.0 * pi))))
    return points


def at_hill(master: float) -> float:
    """Where the slave is, at a row of the hill."""
    return dict(hill())[master % 360.0]


def test_several_cams_are_added_up(line: Line) -> None:
    line.table([(0.0, 0.0), (360.0, 360.0)])
    line.table(hill(), table_id=8)
    line.table([(0.0, 0.0), (360.0, 0.0)], table_id=9)
    assert line.couple(7, SEVERAL) == 0
    assert line.couple(8, SEVERAL, interpolation=2) == 0
    assert line.to(90.0) == pytest.approx(95.0, abs=1e-6)
    assert line.slave.set_gear_ratio == pytest.approx(1.111111111, abs=1e-6)
    demand = CamDemand(
        9,
        slave_absolute=1,
        master_absolute=1,
        activation=CamActivation.MASTER_CAM_POSITION,
        position=360.0,
    )
    exchange = CamOperation.EXCHANGE
    assert commands.couple_by_cam(line.slave, SEVERAL, 1, demand, exchange, 8) == 0
    assert line.to(450.0) == pytest.approx(450.0, abs=1e-6)


def test_cams_of_other_masters_come_and_go(line: Line) -> None:
    line.table([(0.0, 0.0), (360.0, 360.0)])
    line.table([(0.0, 0.0), (100.0, 50.0)], table_id=8)
    assert line.couple(7, SEVERAL) == 0
    add = CamDemand(8, master_absolute=1)
    assert commands.couple_by_cam(line.slave, SEVERAL, 3, add, CamOperation.ADDITIVE) == 0
    line.nc.cycle()
    assert (line.other.coupling_state, line.slave.coupling.master_count) == (1, 2)
    line.to(100.0)
    assert line.to(60.0, axis=line.other) == pytest.approx(130.0)
    remove = CamDemand(8, activation=CamActivation.INSTANTANEOUS)
    assert commands.couple_by_cam(line.slave, SEVERAL, 1, remove, CamOperation.REMOVE) == 0
    line.nc.cycle()
    assert line.slave.set_position == pytest.approx(130.0)
    assert line.to(0.0, axis=line.other) == pytest.approx(130.0)
    assert line.to(110.0) == pytest.approx(140.0)
    last = CamDemand(7)
    code = commands.couple_by_cam(line.slave, SEVERAL, 1, last, CamOperation.REMOVE)
    assert code == NcError.DECOUPLING_NOT_POSSIBLE


def test_a_correction_runs_once_and_its_stroke_remains(line: Line) -> None:
    line.table([(0.0, 0.0), (360.0, 360.0)])
    line.table([(0.0, 0.0), (50.0, 3.0), (100.0, 2.0)], table_id=8)
    assert line.couple(7, SEVERAL) == 0
    assert commands.last_correction(line.slave, 8) is None
    assert commands.follow_correction(line.slave, 8, 200.0) == 0
    assert line.to(250.0) == pytest.approx(253.0)
    assert commands.last_correction(line.slave, 8) == pytest.approx(3.0)
    assert line.to(1000.0) == pytest.approx(1002.0)
    assert commands.follow_correction(line.slave, 8) == 0
    assert line.to(1050.0) == pytest.approx(1055.0)
    assert line.to(2000.0) == pytest.approx(2004.0)


def test_a_profile_ends_with_its_cycle(line: Line) -> None:
    line.table([(0.0, 0.0), (360.0, 360.0)])
    line.table([(0.0, 0.0), (50.0, 3.0), (100.0, 1.0)], table_id=8)
    assert line.couple(7, SEVERAL) == 0
    assert line.couple(8, SEVERAL) == 0
    assert line.to(150.0) == pytest.approx(154.0)
    assert commands.end_profile(line.slave, 8) == 0
    assert line.to(500.0) == pytest.approx(502.0)
    assert line.nc.tables.user_count(8) == 0


def test_a_slave_waits_for_the_place_where_its_cam_begins(line: Line) -> None:
    line.table(LIFTING)
    later: Any = {"activation": CamActivation.MASTER_AXIS_POSITION, "position": 100.0}
    assert line.couple(slave_absolute=0, master_absolute=0, **later) == 0
    assert line.to(50.0) == 0.0
    assert line.has(StateBit.CAM_TABLE_QUEUED)
    assert line.slave.coupling_state == 3
    assert line.to(145.0) == pytest.approx(15.0)
    assert not line.has(StateBit.CAM_TABLE_QUEUED)


def test_an_edit_is_followed_in_the_next_cycle(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    assert line.to(90.0) == 30.0
    tables = line.nc.tables
    tables.write(tables.find(7), 3, [31.0])
    line.nc.cycle()
    assert line.slave.set_position == 31.0


def test_an_open_loop_does_not_make_the_slave_jump(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    line.to(90.0)
    line.master.velocity_override = 0
    assert commands.start(line.master, 1, 180.0, 500.0) == 0
    line.nc.cycle(5)
    line.slave.control_dword = 0
    line.nc.cycle(5)
    line.master.velocity_override = 1_000_000
    line.nc.cycle(5000)
    assert line.master.set_position == 180.0
    stood = line.slave.set_position
    line.slave.control_dword = 7
    line.nc.cycle(20)
    assert line.slave.set_position == pytest.approx(stood, abs=0.1)
    before = line.slave.set_position
    assert line.to(207.0) == pytest.approx(before + 7.0)


def test_functions_of_the_kernel_outside_it(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    line.to(45.0)
    slave, rows = line.slave, line.slave.rows
    layer = slave.cams[0]
    assert master_position_of(slave, rows, layer) == 45.0
    assert part_at(rows, layer, 45.0)[0] == pytest.approx(15.0)
    base(slave, rows)
    step(slave, rows, 0.002)
    assert slave.set_position == pytest.approx(15.0)
    after: Any = CAM_LAW.plain()
    assert planned(slave, rows, layer, 45.0, after) == pytest.approx(15.0)
    assert after.master_offset == 0.0


def test_an_edit_that_would_make_the_slave_jump_is_refused(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    assert line.to(450.0) == 130.0
    tables = line.nc.tables
    table = tables.find(7)
    before = list(table.values), list(tables.cams.numbers)
    for index, value in ((3, 36.0), (5, 106.0), (3, 24.0)):  # a point, and the lift of a cycle
        with pytest.raises(TableError) as refused:
            tables.write(table, index, [value])
        assert refused.value.error == NcError.TABLE_SLAVE_RANGE
    with pytest.raises(TableError):
        tables.scale(table, TableScaling(slave_scaling=2.0))
    assert (list(table.values), list(tables.cams.numbers)) == before
    line.nc.cycle()
    assert line.slave.set_position == 130.0
    tables.write(table, 3, [34.0])
    line.nc.cycle()
    assert line.slave.set_position == 134.0
    line.slave.control_dword = 0  # whose loop is open does not jump
    line.nc.cycle()
    tables.write(table, 3, [64.0])


def test_a_change_for_one_cycle_is_taken_back_at_the_next(line: Line) -> None:
    line.table(hill())
    assert line.couple(slave_scaling=2.0) == 0
    line.to(10.0)
    change = CamDemand(slave_scaling=4.0, activation=CamActivation.NEXT_CYCLE_ONCE)
    assert commands.change_cam_scaling(line.slave, change) == 0
    expected = {100.0: 2.0, 450.0: 4.0, 800.0: 2.0, 1200.0: 2.0}
    line.table(LIFTING, table_id=1)
    for master, factor in expected.items():
        assert line.to(master) == pytest.approx(factor * at_hill(master), abs=1e-9)
        assert [line.nc.tables.user_count(n) for n in (1, 7)] == [0, 1]
        assert line.slave.cams[0].change.returns in (0, 1)
    assert not line.has(StateBit.CAM_SCALING_PENDING)


def test_a_table_for_one_cycle(line: Line) -> None:
    line.table(hill())
    line.table([(0.0, 0.0), (90.0, 7.0), (360.0, 0.0)], table_id=8)
    assert line.couple() == 0
    line.to(10.0)
    assert line.couple(8, activation=CamActivation.NEXT_CYCLE_ONCE) == 0
    assert line.to(450.0) == pytest.approx(7.0)
    with pytest.raises(TableError):
        line.nc.tables.delete(7)
    assert line.to(810.0) == pytest.approx(at_hill(90.0), abs=1e-9)
    line.nc.tables.delete(8)


@pytest.mark.parametrize("shift", [90.0, -33.0])
@pytest.mark.parametrize("when", [0, 1, 2, 3, 8])
def test_a_cam_lies_at_the_present_names_of_a_master_that_others_follow(
    line: Line, when: int, shift: float
) -> None:
    """Renamed while axis 3 follows it; axis 2 couples then, absolutely."""
    line.table(hill())
    assert commands.couple(line.other, 1, 1, 0, 0, 1.0) == 0
    line.nc.cycle()
    shift_setpoint(line.master, shift)
    line.nc.cycle()
    follower = line.other.set_position
    assert line.slave.set_position == 0.0
    place = {0: shift, 3: 360.0}.get(when, shift + 20.0)
    line.put(line.slave, at_hill(place))
    assert line.couple(activation=when, position=shift + 20.0) == 0
    line.to(shift + 10.0)
    line.to(1000.0)
    assert line.slave.set_position == pytest.approx(at_hill(1000.0), abs=1e-9)
    assert line.other.set_position == pytest.approx(follower + 1000.0 - shift)


def test_what_a_cam_shows_is_there_at_once(line: Line) -> None:
    line.table(LIFTING)
    line.put(line.master, 45.0)
    line.put(line.slave, 15.0)
    assert line.couple() == 0
    layer = line.slave.cams[0]
    assert (layer.cam_position, layer.value, layer.part) == (45.0, 15.0, 15.0)


def test_a_motion_function_is_not_a_cam_table(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple(7, SlaveType.MOTION_FUNCTION) == NcError.TABLE_WRONG_KIND


def test_tables_that_are_named_at_coupling_are_held(line: Line) -> None:
    for table_id in (7, 8, 9):
        line.table(hill(), table_id=table_id)
    demand = CamDemand(7, slave_absolute=1, master_absolute=1)
    couple = commands.couple_by_cam
    assert couple(line.slave, 11, 1, demand, further_tables=(8, 5)) == NcError.TABLE_NOT_FOUND
    assert line.slave.coupling.law == 0
    assert couple(line.slave, 11, 1, demand, further_tables=(8,)) == 0
    assert line.nc.tables.user_count(8) == 1
    with pytest.raises(TableError):
        line.nc.tables.delete(8)
    assert commands.follow_correction(line.slave, 9) == NcError.TABLE_NOT_FOUND
    assert commands.follow_correction(line.slave, 8) == 0
    line.nc.cycle()
    assert commands.decouple(line.slave) == 0
    line.nc.tables.delete(8)


def test_a_linear_cam_in_place_of_a_cyclic_one_begins_in_no_cycle(line: Line) -> None:
    line.table(hill())
    line.table([(0.0, 0.0), (5000.0, 50.0)], MONOTONIC_LINEAR, table_id=8)
    assert line.couple() == 0
    line.to(800.0)
    assert line.couple(8, slave_absolute=0) == 0
    here = line.slave.set_position
    assert line.to(1800.0) == pytest.approx(here + 10.0, abs=1e-9)
    assert line.slave.cams[0].cam_position == 1800.0


def test_a_linear_cam_keeps_its_end_from_the_first_cycle_on(line: Line) -> None:
    """Also where a further cycle of it would be, if it was cyclic."""
    line.table(LIFTING, MONOTONIC_LINEAR)
    line.put(line.master, 450.0)
    line.put(line.slave, 100.0)
    assert line.couple() == 0
    line.nc.cycle(2)
    assert (line.slave.set_position, line.slave.cams[0].cam_position) == (100.0, 450.0)
    assert (line.slave.set_velocity, line.slave.set_acceleration, line.slave.set_jerk) == (0, 0, 0)


def test_an_absolute_cam_beside_a_relative_one_leaves_the_slave_where_it_is(line: Line) -> None:
    line.table(LIFTING)
    line.put(line.slave, 30.0)
    assert line.couple(slave_type=SEVERAL, slave_absolute=0) == 0
    line.nc.cycle()
    assert line.couple(slave_type=SEVERAL) == 0
    line.nc.cycle()
    assert line.slave.set_position == 30.0
    assert line.to(90.0) == 90.0


def test_an_exchange_that_keeps_the_place_in_the_cam_stays_absolute(line: Line) -> None:
    line.table(LIFTING)
    assert line.couple() == 0
    line.to(90.0)
    keeps: Any = {"master_type": CamScaling.AUTO_OFFSET, "master_scaling": 2.0}
    assert line.couple(**keeps, master_absolute=0) == 0
    line.nc.cycle()
    assert commands.change_cam_scaling(line.slave, CamDemand(**keeps)) == 0
    assert line.couple(master_absolute=0, slave_absolute=0) == 0
    refused = commands.change_cam_scaling(line.slave, CamDemand(**keeps))
    assert refused == NcError.SCALING_MODE


def test_a_cam_waits_for_a_master_that_turns_behind_its_place(line: Line) -> None:
    """The way of each cycle counts, not that from where the cam was asked for."""
    line.table(LIFTING)
    back: Any = {"activation": CamActivation.MASTER_AXIS_POSITION_NEGATIVE, "position": 50.0}
    assert line.couple(slave_absolute=0, master_absolute=0, **back) == 0
    assert line.to(100.0) == 0.0
    assert line.to(5.0) == pytest.approx(-45.0 * 70.0 / 270.0)
