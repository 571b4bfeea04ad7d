"""Motion functions: the way through the points, what is refused, and what they demand."""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, inf, nan, pi, sin
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.codes.axis import StateBit
from achse.codes.nc.choices import TableType
from achse.motion import Nc, commands
from achse.motion.laws.element import ELEMENT, element_values, elements_of
from achse.motion.laws.table import LAWS, MotionLaw
from achse.motion.record import CAM
from achse.motion.states import CamActivation, SlaveType
from achse.motion.tables import MOTION_POINT, Tables
from achse.motion.tables.errors import TableError
from achse.motion.tables.function import (
    IGNORED,
    MotionPoint,
    function_elements,
    survey_function,
    values_at,
)
from achse.motion.tables.memory import cam_values
from achse.motion.tables.table import PointActivation
from tests.motion.enabled_axes import enabled_axes


def point(
    master: float,
    slave: float,
    law: int = 5,
    *,
    kind: int = 0,
    following: int = 1,
    velocity: float = 0.0,
    acceleration: float = 0.0,
    jerk: float = 0.0,
) -> MotionPoint:
    return MotionPoint(0, law, kind, following, 0, master, slave, velocity, acceleration, jerk)


def test_laws_join_points() -> None:
    """Bestehorn up, a rest, a straight line, and motion to motion."""
    numbers = function_elements(
        [
            point(0.0, 0.0, MotionLaw.BESTEHORN),
            point(90.0, 30.0, MotionLaw.POLYNOMIAL_1),
            point(180.0, 30.0, MotionLaw.POLYNOMIAL_1),
            point(270.0, 75.0, MotionLaw.POLYNOMIAL_5_MM, velocity=0.5),
            point(360.0, 0.0, 0, velocity=-0.25, acceleration=0.01),
        ]
    )
    z = 0.25
    assert values_at(numbers, 22.5)[0] == pytest.approx(30 * (z - sin(2 * pi * z) / (2 * pi)))
    assert values_at(numbers, 22.5)[1] == pytest.approx(30 / 90 * (1 - cos(2 * pi * z)))
    assert values_at(numbers, 120.0) == (30.0, 0.0, 0.0, 0.0)
    assert values_at(numbers, 225.0)[:2] == pytest.approx((52.5, 0.5))
    assert values_at(numbers, 270.0)[:3] == pytest.approx((75.0, 0.5, 0.0))
    assert values_at(numbers, 360.0)[:3] == pytest.approx((0.0, -0.25, 0.01), abs=1e-9)
    assert values_at(numbers, -1.0) == (0.0, 0.0, 0.0, 0.0)
    assert values_at(numbers, 361.0) == (0.0, 0.0, 0.0, 0.0)


def test_ignored_points_are_passed_over_whatever_is_in_them() -> None:
    plain = function_elements([point(0.0, 0.0), point(10.0, 5.0)])
    rows = [
        point(nan, inf, 77, kind=IGNORED),
        point(0.0, 0.0),
        point(5.0, 100.0, 77, kind=IGNORED, following=-9),
        point(10.0, 5.0, 77),
        point(-4.0, 0.0, kind=IGNORED),
    ]
    assert function_elements(rows) == plain


@pytest.mark.parametrize("kind", [0, 2, 4, 8, 0x0F00, 0x2000, 0x2008])
def test_other_point_types_have_no_effect(kind: int) -> None:
    plain = function_elements([point(0.0, 0.0), point(10.0, 5.0)])
    assert function_elements([point(0.0, 0.0, kind=kind), point(10.0, 5.0, kind=kind)]) == plain


def test_the_relative_index_leads_past_points() -> None:
    plain = function_elements([point(0.0, 0.0), point(10.0, 5.0), point(30.0, 0.0)])
    rows = [
        point(0.0, 0.0, following=3),
        point(900.0, 1.0),
        point(800.0, 1.0),
        point(10.0, 5.0, following=0),
        point(30.0, 0.0, following=17),
    ]
    assert function_elements(rows) == plain


@pytest.mark.parametrize(
    ("points", "error"),
    [
        ([point(0.0, 0.0)], NcError.TABLE_TOO_FEW_POINTS),
        ([point(0.0, 0.0), point(1.0, 0.0, kind=IGNORED)], NcError.TABLE_TOO_FEW_POINTS),
        ([point(0.0, 0.0), point(0.0, 1.0)], NcError.TABLE_NOT_MONOTONIC),
        ([point(0.0, 0.0), point(-1.0, 1.0)], NcError.TABLE_NOT_MONOTONIC),
        ([point(0.0, 0.0, 2), point(1.0, 1.0)], NcError.TABLE_INTERPOLATION_TYPE),
        ([point(0.0, 0.0, 16), point(1.0, 1.0)], NcError.TABLE_INTERPOLATION_TYPE),
        ([point(0.0, 0.0, following=2), point(1.0, 1.0)], NcError.TABLE_POINT_INDEX),
        ([point(0.0, 0.0, following=-1), point(1.0, 1.0)], NcError.TABLE_POINT_INDEX),
        ([point(nan, 0.0), point(1.0, 1.0)], NcError.TABLE_PARAMETER),
        ([point(0.0, 0.0), point(1.0, 2e9)], NcError.TABLE_PARAMETER),
        ([point(0.0, 0.0, velocity=inf), point(1.0, 1.0)], NcError.TABLE_PARAMETER),
    ],
)
def test_what_is_no_function_is_refused(points: list[MotionPoint], error: NcError) -> None:
    with pytest.raises(TableError) as caught:
        function_elements(points)
    assert caught.value.error == error


def test_worked_characteristic_values() -> None:
    """POLY5, 0..180 → 100."""
    survey = survey_function(function_elements([point(0.0, 0.0), point(180.0, 100.0)]))
    assert len(survey) == 31
    assert survey[:11] == pytest.approx(
        [1.0, 0.0, 0.0, 0.0, 0.0, 60 * 100 / 180**3, 180.0, 100.0, 0.0, 0.0, 60 * 100 / 180**3],
        abs=1e-12,
    )
    assert survey[15:18] == pytest.approx([141.961524227, -0.017819452753, 0.462962963], abs=6e-10)
    assert survey[22:24] == pytest.approx([90.0, 1.041666667], abs=6e-10)
    assert survey[24:26] == pytest.approx([38.038475773, 0.017819452753], abs=6e-10)
    assert (survey[18], survey[27]) == pytest.approx((-0.000514403292, 0.001028806584), abs=6e-13)
    assert survey[29:] == pytest.approx([0.555555556, 0.012778991840], abs=6e-10)


NUMBER = st.floats(-100.0, 100.0)
POINTS = st.lists(
    st.tuples(st.sampled_from(sorted(LAWS)), st.floats(0.1, 100.0), NUMBER, NUMBER, NUMBER, NUMBER),
    min_size=2,
    max_size=8,
)


@settings(max_examples=100)
@given(POINTS)
def test_the_slave_goes_through_each_point(
    drawn: list[tuple[int, float, float, float, float, float]],
) -> None:
    points, master = [], 0.0
    for law, way, slave, velocity, acceleration, jerk in drawn:
        master += way
        points.append(
            point(master, slave, law, velocity=velocity, acceleration=acceleration, jerk=jerk)
        )
    numbers = function_elements(points)
    assert len(numbers) % ELEMENT == 0
    each = list(elements_of(numbers))
    for here in points[:-1]:
        begun = next(e for e in each if e[0] == here.master_position)
        assert element_values(begun, 0, here.master_position)[0] == pytest.approx(
            here.slave_position, abs=1e-9
        )
    for before, here in pairwise(points):
        if before.function_type != MotionLaw.STEP:
            near = values_at(numbers, here.master_position - 1e-12)[0]
            assert near == pytest.approx(here.slave_position, abs=1e-5)


def new_layer(cam: int) -> Any:
    """A cam at work whose other points wait, too."""
    layer: Any = CAM.plain()
    for law in (layer.now, layer.next):
        law.table, law.cam, law.master_absolute, law.slave_absolute = 7, cam, 1, 1
    return layer


class Slave:
    """Axis as tables see it."""

    axis_id = 1
    camming = SimpleNamespace(count=1, tables=())
    coupling = SimpleNamespace(law=13)
    resting = loop_closed = 0
    position_range_window = 5.0
    drives: Sequence[Any] = ()
    rows = None

    def __init__(self, cams: Sequence[Any]) -> None:
        self.cams = cams

    def wake(self, *, adapts: bool = False) -> None:
        """Nothing of it is read."""

    def show_cams(self) -> None:
        """Nothing of it is read."""


def packed(points: Sequence[MotionPoint]) -> bytes:
    return b"".join(MOTION_POINT.pack(*each) for each in points)


def test_slaves_read_the_elements_and_each_version_they_use() -> None:
    slaves: list[Slave] = []
    tables = Tables(lambda: slaves)
    table = tables.create(7, TableType.MOTION_FUNCTION, 3, 3, 1)
    path = [point(0.0, 0.0), point(90.0, 30.0, MotionLaw.MODIFIED_SINE), point(360.0, 100.0)]
    tables.write_points(table, 0, packed(path))
    first = tables.cam(7, 0)
    assert cam_values(tables.cams.numbers, first, -1, 45.0)[:4] == values_at(table.function(), 45.0)
    layer = new_layer(first)
    slaves.append(Slave([layer]))
    tables.write_points(table, 1, packed([point(90.0, 60.0, MotionLaw.ACCELERATION_TRAPEZOID)]))
    assert cam_values(tables.cams.numbers, layer.now.cam, 3, 45.0)[:2] == pytest.approx(
        (30.0, 1.25)
    )

    tables.change_online(table, PointActivation(CamActivation.NEXT_CYCLE))
    tables.write_points(table, 1, packed([point(90.0, 90.0, MotionLaw.POLYNOMIAL_1)]))
    numbers = tables.cams.numbers
    assert cam_values(numbers, layer.now.cam, 3, 45.0)[0] == pytest.approx(30.0)
    assert cam_values(numbers, layer.next.cam, 3, 45.0)[0] == pytest.approx(45.0)
    assert tables.cam(7, 0) == layer.next.cam

    with pytest.raises(TableError) as caught:
        tables.write_points(table, 1, packed([point(400.0, 90.0)]))
    assert caught.value.error == NcError.TABLE_NOT_MONOTONIC
    assert cam_values(tables.cams.numbers, layer.next.cam, 3, 45.0)[0] == pytest.approx(45.0)
    assert table.function() == function_elements(
        [path[0], point(90.0, 90.0, MotionLaw.POLYNOMIAL_1), path[2]]
    )


def follower(points: Sequence[MotionPoint], *, compiled: bool = False, sub_type: int = 3) -> Nc:
    """Axis 2 follows axis 1 by a motion function, both from 0 on."""
    nc = enabled_axes(compiled=compiled)
    table = nc.tables.create(7, TableType.MOTION_FUNCTION, sub_type, len(points), 1)
    nc.tables.write_points(table, 0, packed(points))
    demand = commands.CamDemand(7, slave_absolute=1, master_absolute=1)
    assert commands.couple_by_cam(nc.axis(2), SlaveType.MOTION_FUNCTION, 1, demand) == 0
    return nc


LAWS_FROM_REST = st.sampled_from([3, 5, 7, 8, 9, 10, 11, 12, 13, 15, 24, 23, 38, 39, 40, 1])


@settings(max_examples=20, deadline=None)
@given(
    st.lists(
        st.tuples(LAWS_FROM_REST, st.floats(5.0, 60.0), st.floats(-50.0, 50.0)),
        min_size=2,
        max_size=5,
    ),
    st.floats(20.0, 300.0),
    st.integers(0, 150),
)
def test_a_slave_keeps_its_law_in_both_kernels(
    drawn: list[tuple[int, float, float]], velocity: float, turn: int
) -> None:
    points, master = [point(0.0, 0.0, drawn[0][0])], 0.0
    for law, way, slave in drawn:
        master += way
        points.append(point(master, slave, law))
    stations = [follower(points, compiled=compiled) for compiled in (False, True)]
    elements = stations[0].tables.find(7).function()
    for nc in stations:
        assert commands.universal_start(nc.axis(1), 1, master * 0.8, velocity) == 0
    for cycle in range(300):
        for nc in stations:
            if cycle == turn:
                commands.universal_start(nc.axis(1), 1, 0.0, velocity)
            nc.cycle()
        plain, fast = (nc.axis(2) for nc in stations)
        leader = stations[0].axis(1)
        s, v, a, _ = values_at(elements, leader.set.position)
        assert plain.set_position == pytest.approx(s, abs=1e-9)
        assert plain.set_velocity == pytest.approx(v * leader.set.velocity, abs=1e-6)
        assert plain.set_acceleration == pytest.approx(
            a * leader.set.velocity**2 + v * leader.set.acceleration, abs=1e-4, rel=1e-9
        )
        assert (plain.set_position, plain.set_velocity, plain.set_acceleration) == (
            fast.set_position,
            fast.set_velocity,
            fast.set_acceleration,
        )


@pytest.mark.parametrize("compiled", [False, True])
def test_points_change_at_the_end_of_a_cycle(compiled: bool) -> None:
    """A cyclic function of 10 → 4 and back: written while it runs, active from the next cycle."""
    points = [point(0.0, 0.0, 5), point(5.0, 4.0, 5), point(10.0, 0.0)]
    nc = follower(points, compiled=compiled, sub_type=4)
    master, slave = nc
    table = nc.tables.find(7)
    nc.tables.change_online(table, PointActivation(CamActivation.NEXT_CYCLE))
    commands.universal_start(master, 1, 40.0, 20.0)
    while master.set_position < 12.0:
        nc.cycle()
    old = table.function()
    nc.tables.write_points(table, 1, packed([point(5.0, 8.0, 12)]))
    new = table.function()
    while master.set_position < 39.0:
        nc.cycle()
        law = old if master.set_position < 20.0 else new
        assert slave.set_position == pytest.approx(
            values_at(law, master.set_position % 10.0)[0], abs=1e-9
        )
        queued = slave.state_dword & StateBit.CAM_DATA_QUEUED
        assert bool(queued) == (master.set_position < 20.0)


@pytest.mark.parametrize(
    ("activation", "returns"),
    [
        (CamActivation.INSTANTANEOUS, True),
        (CamActivation.OFF, True),
        (CamActivation.DELETE_QUEUED, False),
        (CamActivation.NEXT_CYCLE, None),
        (CamActivation.NEXT_CYCLE_ONCE, None),
    ],
)
def test_points_for_one_cycle_go_back_whatever_is_written_meanwhile(
    activation: CamActivation, returns: bool | None
) -> None:
    """Points written within that cycle leave the return as it is; None: they are refused."""
    nc = follower([point(0.0, 0.0, 5), point(5.0, 4.0, 5), point(10.0, 0.0)], sub_type=4)
    master, slave = nc
    table = nc.tables.find(7)
    old = table.function()
    nc.tables.change_online(table, PointActivation(CamActivation.NEXT_CYCLE_ONCE))
    nc.tables.write_points(table, 1, packed([point(5.0, 8.0, 5)]))
    commands.universal_start(master, 1, 40.0, 20.0)
    while master.set_position < 16.0:
        nc.cycle()
    nc.tables.change_online(table, PointActivation(activation))
    if returns is None:
        with pytest.raises(TableError) as caught:
            nc.tables.write_points(table, 1, packed([point(5.0, 9.0, 5)]))
        assert caught.value.error == NcError.ACTIVATION_PENDING
    else:
        nc.tables.write_points(table, 1, packed([point(5.0, 9.0, 5)]))
    while master.set_position < 25.0:
        nc.cycle()
    goes_back = slave.set_position == pytest.approx(
        values_at(old, master.set_position % 10.0)[0], abs=1e-9
    )
    assert goes_back == (returns is not False)


def test_a_point_written_at_once_acts_at_once() -> None:
    nc = follower([point(0.0, 0.0, 1), point(10.0, 10.0)])
    master, slave = nc
    commands.universal_start(master, 1, 5.0, 20.0)
    nc.cycle(1000)
    nc.tables.write_points(nc.tables.find(7), 1, packed([point(10.0, 10.5)]))
    nc.cycle(2)
    assert slave.set_position == pytest.approx(5.25)
    assert nc.tables.user_count(7) == 1
