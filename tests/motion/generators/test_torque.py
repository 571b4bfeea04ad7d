"""Torque mode on the simulated drive's physics."""

from typing import Any

import pytest

from achse.motion import CommandState, MotionPhase, StateBit, commands

FULL = 2000.0
"""Acceleration at 100 % torque, mm/s²."""

MOTOR = {
    "simulation_full_torque_acceleration": FULL,
    "encoder_velocity_filter_time": 0.0,
    "max_velocity": 2000.0,
}

ABSOLUTE, RELATIVE = 0x3001, 0x3002
UPDATE_ONLY = 1 << 31


def torque(
    rig: Any,
    value: float,
    *,
    kind: int = ABSOLUTE,
    mask: int = 0,
    mode: int = 0,
    ramp: float = 0.0,
    high: float = 1000.0,
    low: float = -1000.0,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    manual: float = 0.0,
) -> int:
    return commands.start_torque_control(
        rig.axis, kind, mask, mode, 0, value, ramp, high, low, acceleration, deceleration, manual
    )


def test_a_torque_accelerates_the_motor(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    axis = rig.axis
    assert torque(rig, 100.0) == 0  # 10 %
    assert axis.set_torque == 0.0  # what the motor had
    count = 200
    rig.run(count)
    t = count * rig.dt
    assert axis.drive_operation_mode == 1
    assert axis.set_torque == 100.0
    assert axis.drive.actual_torque == pytest.approx(100.0)
    assert axis.machine.velocity == pytest.approx(0.1 * FULL * t)
    assert axis.actual_position == pytest.approx(0.05 * FULL * t * t, rel=0.02)
    assert axis.set_position == axis.actual_position
    assert axis.following_error == 0.0
    assert axis.set_motion_phase == MotionPhase.TORQUE
    assert axis.set_command_state == CommandState.ACTIVE
    assert rig.has(StateBit.HAS_JOB)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert rig.has(StateBit.POSITIVE_DIRECTION)
    assert axis.error_code == 0


def test_a_torque_against_a_load_holds_it(make_rig: Any) -> None:
    rig = make_rig(**MOTOR, simulation_load_torque=150.0)
    rig.seconds(0.5)
    assert rig.axis.drive.actual_torque == pytest.approx(150.0, abs=1.0)  # position control holds
    torque(rig, 150.0)
    rig.seconds(1.0)
    assert abs(rig.axis.machine.velocity) < 1.0
    torque(rig, 50.0)
    rig.seconds(0.1)
    assert rig.axis.machine.velocity == pytest.approx(-0.1 * FULL * 0.1, rel=0.05)


def test_the_set_torque_runs_along_its_ramp(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    axis = rig.axis
    torque(rig, -80.0, ramp=400.0, mask=1, manual=20.0)
    assert axis.set_torque == 20.0
    for cycle in range(1, 125):
        rig.run(1)
        assert axis.set_torque == pytest.approx(20.0 - 400.0 * cycle * rig.dt)
        assert axis.set_torque_derivative == pytest.approx(-400.0)
    rig.run(2)
    assert axis.set_torque == -80.0
    assert axis.set_torque_derivative == pytest.approx(0.0, abs=1e-9)


def test_a_relative_torque_adds_to_the_present_one(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    torque(rig, 30.0)
    rig.run(1)
    number = rig.axis.command_counter
    torque(rig, 20.0, kind=RELATIVE)
    rig.run(1)
    assert rig.axis.set_torque == 50.0
    assert rig.axis.set_command_number == number + 1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_velocity_stays_within_its_limits(make_rig: Any, sign: float) -> None:
    rig = make_rig(**MOTOR)
    torque(rig, sign * 200.0, high=100.0, low=-100.0)
    rig.seconds(1.0)
    assert rig.axis.machine.velocity == sign * 100.0
    assert rig.axis.drive.actual_torque == pytest.approx(0.0, abs=1e-9)  # nothing accelerates it
    assert rig.has(StateBit.DRIVE_LIMIT_ACTIVE)


def test_a_velocity_beyond_its_limit_is_braked(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    commands.start(rig.axis, 3, 0.0, 300.0)
    rig.seconds(2.0)
    torque(rig, 0.0, high=100.0, low=-100.0, deceleration=400.0)
    rig.run(100)
    assert rig.axis.machine.velocity == pytest.approx(300.0 - 400.0 * 100 * rig.dt, rel=0.01)
    rig.seconds(0.5)
    assert rig.axis.machine.velocity == 100.0


def test_velocity_changes_keep_the_limits_of_acceleration(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    torque(rig, 500.0, acceleration=250.0, deceleration=500.0)
    rig.run(100)
    assert rig.axis.machine.velocity == pytest.approx(250.0 * 100 * rig.dt)
    torque(rig, -500.0, acceleration=250.0, deceleration=500.0)
    rig.run(20)
    assert rig.axis.machine.velocity == pytest.approx(50.0 - 500.0 * 20 * rig.dt)


def test_ramp_and_limits_are_updated_while_the_command_runs(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    torque(rig, 100.0, mode=1, ramp=10.0)
    rig.run(5)
    number = rig.axis.command_counter
    assert torque(rig, 999.0, mask=UPDATE_ONLY, mode=1, ramp=0.0, high=30.0, low=0.0) == 0
    assert rig.axis.command_counter == number
    rig.seconds(1.0)
    assert rig.axis.set_torque == 100.0
    assert rig.axis.machine.velocity == 30.0


@pytest.mark.parametrize("how", ["halt", "stop", "start"])
def test_position_control_takes_over_smoothly(make_rig: Any, how: str) -> None:
    rig = make_rig(**MOTOR)
    axis = rig.axis
    torque(rig, 100.0, high=150.0)
    rig.seconds(1.5)
    assert axis.machine.velocity == 150.0
    match how:
        case "halt":
            commands.universal_start(axis, 8192, 0.0, 0.0)
        case "stop":
            commands.stop(axis)
        case _:
            commands.universal_start(axis, 1, 500.0, 150.0)
    rig.run(1)
    assert axis.drive_operation_mode == 0
    assert (axis.set_torque, axis.set_torque_derivative) == (0.0, 0.0)
    assert axis.set_velocity == pytest.approx(150.0, rel=0.01)
    rig.until_rest()
    rig.seconds(0.5)
    assert axis.error_code == 0
    assert abs(axis.following_error) < 0.01
    if how == "start":
        assert axis.set_position == 500.0


def test_after_an_error_the_drive_stays_in_torque_mode_without_torque(make_rig: Any) -> None:
    rig = make_rig(**MOTOR, simulation_load_torque=50.0)
    axis = rig.axis
    torque(rig, 50.0)
    rig.seconds(0.2)
    axis.simulation_not_ready = 1
    rig.run(2)
    assert axis.error_code == 0x4650
    axis.simulation_not_ready = 0
    commands.reset(axis)
    rig.run(1)
    before = axis.machine.velocity
    rig.seconds(0.1)
    assert (axis.drive_operation_mode, axis.set_torque) == (1, 0.0)
    assert axis.machine.velocity == pytest.approx(before - 0.05 * FULL * 0.1, rel=0.1)  # falls
    assert commands.set_drive_operation_mode(axis, 0) == 0
    rig.seconds(0.5)
    assert abs(axis.actual_velocity) < 1.0
    assert axis.error_code == 0


def test_an_error_that_only_brakes_leads_back(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    torque(rig, 100.0)
    rig.seconds(0.5)
    commands.set_external_error(rig.axis, 0x4466)
    rig.until_rest()
    assert rig.axis.drive_operation_mode == 0
    assert abs(rig.axis.set_velocity) == 0.0


def test_torque_takes_over_from_a_move(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    commands.universal_start(rig.axis, 3, 0.0, 200.0)
    commands.universal_start(rig.axis, 1, 900.0, 200.0, buffer_mode=1)
    rig.seconds(0.5)
    before = rig.axis.machine.velocity
    assert torque(rig, 0.0) == 0
    assert rig.axis.buffer_count == 0
    rig.seconds(1.0)
    assert rig.axis.machine.velocity == pytest.approx(rig.axis.actual_velocity, rel=1e-3)
    assert rig.axis.machine.velocity >= before - 1.0


def test_reset_in_torque_mode_takes_the_torque_away(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    torque(rig, 100.0)
    rig.seconds(0.2)
    commands.reset(rig.axis)
    rig.run(1)
    assert rig.axis.set_motion_phase == MotionPhase.NONE
    assert rig.axis.set_torque == 0.0


@pytest.mark.parametrize(("velocity", "position"), [(2, 4), (3, 5), (18, 20), (19, 21)])
def test_velocity_and_position_mode_choose_the_interface(
    make_rig: Any, velocity: int, position: int
) -> None:
    rig = make_rig(simulation_time_constant=0.02)
    assert commands.set_drive_operation_mode(rig.axis, position) == 0
    rig.run(1)
    commands.universal_start(rig.axis, 1, 100.0, 200.0)
    rig.run(2)
    for _ in range(200):
        before = rig.axis.set_position
        rig.run(1)
        assert rig.axis.actual_position == pytest.approx(before, abs=1e-4)
    rig.until_rest()
    assert commands.set_drive_operation_mode(rig.axis, velocity) == 0
    commands.universal_start(rig.axis, 1, 0.0, 200.0)
    rig.run(100)
    assert abs(rig.axis.following_error) > 0.01


@pytest.mark.parametrize("compiled", [False, True])
def test_a_dynamic_container_reports_how_the_velocity_goes_on(
    make_rig: Any, compiled: bool
) -> None:
    """The way of a velocity that is held for each cycle lacks half a cycle's gain: V * dt / 2."""
    velocity, errors = 200.0, []
    for mode in (2, 18):
        rig = make_rig(
            compiled=compiled,
            simulation_time_constant=0.0,
            controller_position_kv=0.0,
            controller_following_error_position_monitoring_enable=0,
            encoder_scaling_factor=1e-9,
        )
        commands.set_drive_operation_mode(rig.axis, mode)
        commands.start(rig.axis, 3, 0.0, velocity)
        rig.until(lambda axis: axis.set_velocity == velocity)
        rig.run(5)
        errors.append(rig.axis.following_error)
    assert errors[0] - errors[1] == pytest.approx(velocity * rig.dt / 2.0, rel=1e-3)


def test_a_torque_with_dynamic_container_is_a_torque(make_rig: Any) -> None:
    rig = make_rig(**MOTOR)
    assert commands.set_drive_operation_mode(rig.axis, 17) == 0
    torque(rig, 100.0)
    before = rig.axis.machine.velocity
    rig.run(100)
    gained = rig.axis.machine.velocity - before
    assert rig.axis.drive_operation_mode == 17
    assert gained == pytest.approx(0.1 * FULL * 100 * rig.dt, rel=1e-3)
    assert commands.home(rig.axis) != 0
    commands.universal_start(rig.axis, 1, 100.0, 50.0)
    rig.until_rest()
    assert rig.axis.drive_operation_mode == 0


def test_a_drive_that_takes_positions_takes_a_torque_too(make_rig: Any) -> None:
    rig = make_rig(**MOTOR, controller_type=9, drive_type=9)
    torque(rig, 100.0)
    rig.run(100)
    assert rig.axis.machine.velocity == pytest.approx(0.1 * FULL * 100 * rig.dt)
    commands.universal_start(rig.axis, 1, 100.0, 50.0)
    before = rig.axis.actual_position
    for _ in range(3000):
        rig.run(1)
        assert abs(rig.axis.actual_position - before) <= 60.0 * rig.dt
        before = rig.axis.actual_position
    assert rig.axis.actual_position == pytest.approx(100.0, abs=1e-3)
    assert rig.axis.drive_operation_mode == 0
