"""Guard of slaves: which set points are refused, and what a slave does that cannot follow."""

from collections.abc import Callable
from random import Random

import pytest

from achse.codes import NcError
from achse.codes.axis import StartType, StateBit
from achse.codes.nc.choices import TableSubType, TableType
from achse.motion import Axis, Nc, commands
from achse.motion.commands import CamDemand
from achse.motion.couplings.guard import check_step
from achse.motion.states import CamActivation
from achse.motion.tables import TableError

DT = 0.002


def follow(nc: Nc, points: list[float], table_id: int = 7, **demand: float) -> int:
    """Let axis 2 follow axis 1 by straight lines through these points, absolutely."""
    rows = len(points) // 2
    table = nc.tables.create(table_id, TableType.CAMMING, TableSubType.MONOTONIC_LINEAR, rows, 2)
    nc.tables.write(table, 0, points)
    options = {"slave_absolute": 1, "master_absolute": 1} | demand
    return commands.couple_by_cam(nc.axis(2), 10, 1, CamDemand(table_id, **options))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("way", "velocity", "error"),
    [
        (0.2, 100.0, 0),
        (-0.2, -100.0, 0),
        (0.21, 100.0, NcError.SET_VELOCITY_TOO_HIGH),
        (-0.21, 0.0, NcError.SET_VELOCITY_TOO_HIGH),
        (0.1, 101.0, NcError.SET_VELOCITY_TOO_HIGH),
        (float("nan"), 0.0, NcError.SET_VELOCITY_TOO_HIGH),
    ],
)
def test_set_point_is_refused_beyond_the_velocity_limit(
    make_axes: Callable[..., Nc], way: float, velocity: float, error: int
) -> None:
    axis = make_axes(1, max_velocity=100.0).axis(1)
    assert check_step(axis, way, way, velocity, 0.0, DT) == error


def test_set_point_is_refused_without_room_to_stop(make_axes: Callable[..., Nc]) -> None:
    nc = make_axes(1, encoder_soft_limit_max_enable=1, encoder_soft_limit_max=10.0)
    axis = nc.axis(1)
    passed = NcError.SOFT_LIMIT_MAX_PASSED
    assert check_step(axis, 0.1, 9.9, 0.0, 0.0, DT) == 0
    assert check_step(axis, 0.1, 10.1, 0.0, 0.0, DT) == passed
    assert check_step(axis, 0.1, 5.0, 100.0, 0.0, DT) == 0  # 100² / 2 · 5000 and a cycle: 1.2
    assert check_step(axis, 0.1, 9.0, 100.0, 0.0, DT) == passed
    assert check_step(axis, -0.1, 12.0, -100.0, 0.0, DT) == 0  # it comes back


@pytest.mark.parametrize("compiled", [False, True])
def test_slave_brakes_where_its_cam_is_too_steep(
    make_axes: Callable[..., Nc], compiled: bool
) -> None:
    nc = make_axes(2, compiled=compiled, max_velocity=300.0)
    master, slave = nc.axis(1), nc.axis(2)
    assert follow(nc, [0.0, 0.0, 100.0, 100.0, 101.0, 120.0, 500.0, 500.0]) == 0
    commands.start(master, 1, 400.0, 200.0)
    before, farthest = slave.set_position, 0.0
    for _ in range(1200):
        nc.cycle()
        farthest = max(farthest, abs(slave.set_position - before))
        before = slave.set_position
    assert slave.error_code == NcError.SET_VELOCITY_TOO_HIGH
    assert farthest <= 200.0 * DT + 1e-9
    assert (slave.coupling.law, slave.set_velocity) == (0, 0.0)
    assert 100.0 <= slave.set_position <= 100.0 + 200.0**2 / 5000.0 + 5.0
    assert (master.set_position, master.error_code) == (400.0, 0)


@pytest.mark.parametrize("compiled", [False, True])
def test_corner_of_a_cam_leads_across_no_soft_limit(
    make_axes: Callable[..., Nc], compiled: bool
) -> None:
    limits = {"encoder_soft_limit_max_enable": 1, "encoder_soft_limit_max": 10.0}
    nc = make_axes(2, compiled=compiled, **limits)
    master, slave = nc.axis(1), nc.axis(2)
    nc.axis(1).encoder.soft_limit_max_enable = 0
    assert follow(nc, [0.0, 0.0, 100.0, 9.5, 101.0, 20.0, 300.0, 20.0]) == 0
    commands.start(master, 1, 250.0, 200.0)
    for _ in range(1500):
        nc.cycle()
        assert slave.set_position <= 10.0 + 1e-6
    assert slave.error_code == NcError.SOFT_LIMIT_MAX_PASSED
    assert slave.set_position > 9.0


def _running(make_axes: Callable[..., Nc]) -> tuple[Nc, Axis]:
    nc = make_axes(2)
    assert follow(nc, [0.0, 0.0, 100.0, 50.0, 400.0, 60.0]) == 0
    commands.start(nc.axis(1), 1, 200.0, 100.0)
    nc.cycle(500)
    return nc, nc.axis(2)


def test_scaling_in_absolute_positions_is_refused_where_the_slave_would_jump(
    make_axes: Callable[..., Nc],
) -> None:
    nc, slave = _running(make_axes)
    before = nc.digest()
    for activation in (CamActivation.INSTANTANEOUS, CamActivation.MASTER_AXIS_POSITION):
        demand = CamDemand(activation=activation, position=120.0, slave_scaling=1.6)
        assert commands.change_cam_scaling(slave, demand) == NcError.TABLE_SLAVE_RANGE
    assert follow(nc, [0.0, 20.0, 400.0, 30.0], 8) == NcError.TABLE_SLAVE_RANGE
    assert commands.change_cam_offsets(slave, 20.0, 0.0) == NcError.TABLE_SLAVE_RANGE
    assert commands.scale_slave(slave, 2.0) == NcError.TABLE_SLAVE_RANGE
    nc.tables.delete(8)
    assert nc.digest() == before


def test_change_that_has_become_a_jump_waits_and_can_be_taken_back(
    make_axes: Callable[..., Nc],
) -> None:
    nc, slave = _running(make_axes)
    later = CamActivation.MASTER_AXIS_POSITION
    fits = CamDemand(activation=later, position=150.0, slave_scaling=1.05)
    assert commands.change_cam_scaling(slave, fits) == 0
    slave.position_range_window = 0.1
    while nc.axis(1).set_motion_phase:
        before = slave.set_position
        nc.cycle()
        assert abs(slave.set_position - before) < 0.2
    assert (slave.cams[0].now.slave_scaling, slave.error_code) == (1.0, 0)
    assert slave.state_dword & StateBit.CAM_SCALING_PENDING
    back = CamDemand(activation=CamActivation.DELETE_QUEUED)
    assert commands.change_cam_scaling(slave, back) == 0
    nc.cycle(2)
    assert not slave.state_dword & StateBit.CAM_SCALING_PENDING


def test_edits_between_two_cycles_count_together(make_axes: Callable[..., Nc]) -> None:
    nc, slave = _running(make_axes)
    table = nc.tables.find(7)
    nc.tables.write(table, 3, [54.0])
    with pytest.raises(TableError):
        nc.tables.write(table, 3, [58.0])
    assert table.values[3] == 54.0
    before = slave.set_position
    nc.cycle()
    assert 3.0 < slave.set_position - before < 4.5
    nc.tables.write(table, 3, [58.0])


def test_cam_beyond_a_soft_limit_is_refused(make_axes: Callable[..., Nc]) -> None:
    nc = make_axes(2, encoder_soft_limit_max_enable=1, encoder_soft_limit_max=2.0)
    code = follow(nc, [0.0, 3.0, 100.0, 9.0])
    assert code == NcError.SLAVE_TARGET_BEYOND_SOFT_LIMITS


@pytest.mark.parametrize("law", [1, 2, 5, 16])
@pytest.mark.parametrize("compiled", [False, True])
def test_new_ratio_is_refused_where_its_velocity_is_beyond_the_limit(
    make_axes: Callable[..., Nc], law: int, compiled: bool
) -> None:
    """Gear, saws that run with their master, and bi-linear slaves jump to a new ratio."""
    dice = Random(law)
    most = dice.uniform(100.0, 500.0)
    nc = make_axes(3, compiled=compiled, max_velocity=most)
    master, slave, _ = nc
    speed, ratio = most * dice.uniform(0.3, 0.9), dice.uniform(0.2, 0.9)

    def parameters(gear: float) -> tuple[float, ...]:
        return {2: (0.0, 0.0, 90.0, gear), 16: (gear, 0.5, 3.0, 0.0)}.get(
            law, (gear, 0.0, 0.0, 0.0)
        )

    if law != 5:
        assert commands.couple(slave, law, 1, 0, 0, *parameters(ratio)) == 0
    assert commands.universal_start(master, StartType.ENDLESS_POSITIVE, 0.0, speed) == 0
    nc.cycle(1000)
    if law == 5:
        assert commands.synchronise(slave, 5, 1, 0, 0, ratio) == 0
        nc.cycle(1000)
    assert slave.set_velocity == pytest.approx(ratio * speed)
    for sign in (1.0, -1.0):
        for share, code in ((1.01, NcError.SLAVE_COUPLING_PARAMETER), (0.99, 0)):
            before = slave.set_velocity
            gear = sign * share * most / speed
            assert commands.change_coupling(slave, *parameters(gear)) == code
            nc.cycle()
            expected = before if code else gear * speed
            assert slave.set_velocity == pytest.approx(expected)
            assert slave.error_code == 0
