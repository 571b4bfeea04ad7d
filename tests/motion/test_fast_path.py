"""Fast path of a cycle: axes that do no more than a move take it; axes that rest."""

from collections.abc import Callable
from operator import attrgetter
from typing import Any

import pytest

from achse.codes.nc.choices import AxisType
from achse.motion import commands
from achse.motion.control.drive import read_drive
from achse.motion.features import TRANSIENT, Feature
from achse.motion.kernel import _asleep
from achse.motion.monitoring import settle, stays_closed


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("features", 1),
        ("control_dword", 6),
        ("control_dword", 5),
        ("control_dword", 3),
        ("drive_status", 0),
        ("loop_closed", 0),
    ],
)
def test_loop_stays_closed_only_as_in_a_move(
    rig: Any, set_features: Callable[[Any, int], None], name: str, value: int
) -> None:
    axis = rig.axis
    set_features(axis, 0)
    assert stays_closed(axis)
    setattr(axis, name, value)
    assert not stays_closed(axis)


@pytest.mark.parametrize(
    ("field", "feature"),
    [("state2", Feature.LIMIT_SWITCH), ("state4", Feature.IO_INVALID)],
)
def test_limit_switch_and_invalid_data_of_a_drive_end_the_fast_path(
    rig: Any, set_features: Callable[[Any, int], None], field: str, feature: Feature
) -> None:
    axis = rig.axis
    setattr(axis.drive.io, field, 1)
    set_features(axis, 0)
    read_drive(axis, rig.dt, fast=True)
    assert axis.features == feature
    assert not stays_closed(axis)


@pytest.mark.parametrize(
    "name",
    [
        *("drive.output", "drive.actual_torque_derivative", "drive.io_time"),
        *("encoder.actual_acceleration", "encoder.actual_velocity"),
        *("encoder.actual_position_unfiltered", "buffer_count", "phasing_active"),
        *(
            "monitoring.encoder_moves",
            "job.timing",
            "delayed_error_code",
            "monitoring.following_error_time",
        ),
        *("monitoring.following_error_velocity_time", "controller.special"),
    ],
)
def test_axis_that_changes_does_not_rest(rig: Any, name: str) -> None:
    axis = rig.axis
    axis.in_target_position, axis.monitoring.target_window_time = 1, 1.0
    path, _, name = name.rpartition(".")
    owner = attrgetter(path)(axis) if path else axis
    before = getattr(owner, name)
    axis.quiet_cycles = 5
    settle(axis)
    assert axis.quiet_cycles == 6
    setattr(owner, name, before + 1)
    settle(axis)
    assert axis.quiet_cycles == 0


def test_axis_rests_when_its_target_window_has_been_decided(rig: Any) -> None:
    axis = rig.axis
    for inside, time, quiet in ((1, 0.0, 1), (1, 1.0, 1), (0, 0.0, 1), (0, 1.0, 0)):
        axis.quiet_cycles, axis.in_target_position, axis.monitoring.target_window_time = (
            0,
            inside,
            time,
        )
        settle(axis)
        assert axis.quiet_cycles == quiet


def test_axis_rests_after_32_quiet_cycles_and_those_on_their_way(rig: Any) -> None:
    axis = rig.axis
    axis.drive.delay, axis.drive.filter_count = 3, 2
    axis.in_target_position, axis.resting = 1, 0
    axis.quiet_cycles = 35
    settle(axis)
    assert (axis.quiet_cycles, axis.resting) == (36, 0)
    settle(axis)
    assert (axis.quiet_cycles, axis.resting) == (37, 1)


def test_resting_axis_is_not_worked_on(rig: Any) -> None:
    axis = rig.axis
    rig.until(lambda axis: axis.resting == 1)
    quiet, counted = axis.quiet_cycles, axis.set_cycle_counter
    rig.run(5)
    assert (axis.quiet_cycles, axis.set_cycle_counter) == (quiet, counted + 5)


@pytest.mark.parametrize(
    ("change", "sleeps"),
    [("", True), ("encoder", False), ("drive", False), ("master", False), ("no slave", True)],
)
def test_input_or_a_master_wakes_an_axis(make_rig: Any, change: str, sleeps: bool) -> None:
    rig = make_rig(count=2)
    axis = rig.axis
    if change == "master":
        assert commands.couple(axis, 1, 2, 0, 0, 1.0) == 0
    axis.encoder.io.has_changed = int(change == "encoder")
    axis.drive.io.has_changed = int(change == "drive")
    if change == "no slave":
        axis.coupling.master_count, axis.coupling.masters[0] = 1, 1
    axis.quiet_cycles = 40
    axis.resting = 1
    rig.nc.axis(2).resting = int(change != "no slave" and change != "master")
    assert _asleep(axis, axis.rows) is sleeps
    assert (axis.resting, axis.quiet_cycles) == ((1, 40) if sleeps else (0, 0))


def test_slave_rests_with_its_master(make_rig: Any) -> None:
    rig = make_rig(count=2)
    master, slave = rig.nc.axis(1), rig.nc.axis(2)
    assert commands.couple(slave, 1, 1, 0, 0, 1.0) == 0
    rig.until(lambda master: master.resting == 1 and slave.resting == 1, 2.0)
    assert commands.start(master, 1, 1.0, 50.0) == 0
    rig.run(2)
    assert (slave.resting, slave.quiet_cycles) == (0, 0)
    rig.until(lambda master: master.resting == 1 and slave.resting == 1, 5.0)
    assert slave.set_position == 1.0


@pytest.mark.parametrize("features", [0, TRANSIENT])
def test_moving_axis_does_not_grow_quiet(
    make_rig: Any, set_features: Callable[[Any, int], None], features: int
) -> None:
    """At override 0 a move waits; nothing changes, but it may go on at any time."""
    rig = make_rig(velocity_override=0)
    assert commands.start(rig.axis, 1, 100.0, 50.0) == 0
    for _ in range(60):
        set_features(rig.axis, features)
        rig.run(1)
        assert (rig.axis.quiet_cycles, rig.axis.resting) == (0, 0)


@pytest.mark.parametrize("features", [0, TRANSIENT])
@pytest.mark.parametrize("follows", [False, True])
def test_only_a_slave_compares_its_following_error(
    make_rig: Any, set_features: Callable[[Any, int], None], features: int, follows: bool
) -> None:
    rig = make_rig(count=2, controller_following_error_position_monitoring_enable=0)
    master, slave = rig.nc.axis(1), rig.nc.axis(2)
    slave.controller.following_error_difference_scaling = 0.25
    if follows:
        assert commands.couple(slave, 1, 1, 0, 0, 1.0) == 0
    assert commands.start(master, 1, 100.0, 100.0) == 0
    for _ in range(30):
        set_features(slave, features)
        rig.run(1)
    assert master.following_error != 0.0
    assert (slave.following_error_difference != 0.0) is follows


@pytest.mark.parametrize("kind", [AxisType.ENCODER, AxisType.CONTINUOUS_SERVO])
def test_only_an_encoder_axis_watches_for_its_standstill(make_rig: Any, kind: AxisType) -> None:
    rig = make_rig(axis_type=kind, no_motion_time=0.01)
    rig.axis.monitoring.encoder_moves = 1
    rig.run(7)
    assert rig.axis.monitoring.encoder_moves == int(kind != AxisType.ENCODER)
