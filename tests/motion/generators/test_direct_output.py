"""Direct output of the drive: past the position controller, the set point follows."""

from typing import Any

import pytest

from achse.motion import MotionPhase, StateBit, commands


@pytest.mark.parametrize(("kind", "value"), [(1, 10.0), (2, 220.0)])
def test_an_output_goes_to_the_drive_as_it_is(rig: Any, kind: int, value: float) -> None:
    axis = rig.axis
    assert commands.start_drive_output(axis, kind, value) == 0
    rig.run(1)
    assert axis.drive.output == 220.0  # 10 % of 2200 mm/s
    assert axis.drive.output_percent == pytest.approx(10.0)
    assert axis.controller.output == 0.0
    rig.seconds(1.0)
    assert axis.machine.velocity == pytest.approx(220.0)
    assert axis.actual_velocity == pytest.approx(220.0, rel=1e-3)
    assert axis.set_position == axis.actual_position
    assert axis.following_error == 0.0
    assert rig.has(StateBit.HAS_JOB)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert rig.has(StateBit.CONTROL_LOOP_CLOSED)
    assert rig.has(StateBit.POSITIVE_DIRECTION)


def test_an_output_can_be_changed_and_stopped(rig: Any) -> None:
    axis = rig.axis
    commands.start_drive_output(axis, 2, 200.0)
    rig.seconds(0.5)
    assert commands.change_drive_output(axis, 1, -10.0) == 0
    rig.seconds(0.5)
    assert axis.machine.velocity == pytest.approx(-220.0)
    p, v = axis.set_position, axis.set_velocity
    assert commands.stop_drive_output(axis) == 0
    trace = rig.trace(1)
    assert trace[1][1] == pytest.approx(v, abs=axis.default_jerk * rig.dt**2)
    rig.until_rest()
    a, j = axis.default_deceleration, axis.default_jerk  # never reached: v < a²/j
    assert -v < a * a / j
    assert axis.set_position == pytest.approx(p + v * (-v / j) ** 0.5, abs=0.05)
    rig.seconds(0.5)
    assert axis.actual_position == pytest.approx(axis.set_position, abs=0.01)
    assert axis.error_code == 0


def test_an_output_keeps_to_the_limits_of_the_drive(make_rig: Any) -> None:
    rig = make_rig(drive_output_limit_max=0.05)
    commands.start_drive_output(rig.axis, 1, 10.0)
    rig.run(1)
    assert rig.axis.drive.output_percent == pytest.approx(5.0)
    assert rig.has(StateBit.DRIVE_LIMIT_ACTIVE)


def test_a_drive_that_takes_positions_takes_an_output_too(make_rig: Any) -> None:
    rig = make_rig(simulation_ideal=1)
    commands.start_drive_output(rig.axis, 2, 100.0)
    rig.seconds(0.5)
    assert rig.axis.machine.velocity == pytest.approx(100.0)
    commands.stop_drive_output(rig.axis)
    before = rig.axis.actual_position
    for _ in range(300):
        rig.run(1)
        assert abs(rig.axis.actual_position - before) <= 102.0 * rig.dt
        before = rig.axis.actual_position
    assert rig.axis.set_motion_phase == MotionPhase.NONE


@pytest.mark.parametrize(("control", "error"), [(6, 0x4260), (5, 0x4358)])
def test_a_withdrawn_enable_ends_an_output(rig: Any, control: int, error: int) -> None:
    commands.start_drive_output(rig.axis, 2, 100.0)
    rig.seconds(0.5)
    rig.axis.control_dword = control
    rig.run(2)
    assert rig.axis.error_code == error
    assert rig.axis.set_motion_phase == MotionPhase.STOPPING
    rig.until_rest()
    rig.run(20)
    assert rig.axis.drive.output == pytest.approx(0.0, abs=1.0)


def test_a_soft_limit_ends_an_output(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=10.0)
    commands.start_drive_output(rig.axis, 2, 100.0)
    rig.seconds(0.2)
    assert rig.axis.error_code == 0x4463
    rig.until_rest()
    assert rig.axis.set_position < 10.0 + 100.0**1.5 / rig.axis.default_jerk**0.5 + 1.0
