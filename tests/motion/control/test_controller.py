"""Position controller against its equations."""

import random
from typing import Any

import pytest

from achse.codes.nc.choices import ControllerType
from achse.motion import StartType, StateBit, commands

V = 200.0


def at_speed(rig: Any) -> None:
    commands.start(rig.axis, StartType.ENDLESS_POSITIVE, 0.0, V)
    rig.seconds(3.0)


def test_the_actual_position_settles_on_the_target(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.actual_position == pytest.approx(100.0, abs=0.51e-4)
    assert rig.axis.drive.output == 0.0


def test_within_a_hundredth_long_before_a_second(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    rig.seconds(0.25)
    for _ in range(500):
        rig.run(1)
        assert abs(rig.axis.actual_position - 100.0) <= 0.01


def test_the_following_error_without_full_feedforward(make_rig: Any) -> None:
    rig = make_rig(
        controller_velocity_feedforward_weight=0.8,
        controller_position_kv=25.0,
        encoder_scaling_factor=1e-6,
    )
    at_speed(rig)
    assert rig.axis.following_error == pytest.approx(0.2 * V / 25.0, rel=1e-5)
    assert rig.axis.controller.output == pytest.approx(0.2 * V, rel=1e-5)
    assert rig.axis.drive.output == pytest.approx(V, rel=1e-5)
    assert rig.axis.controller.output_percent == pytest.approx(100.0 * 0.2 * V / 2200.0, rel=1e-5)
    assert rig.axis.drive.output_percent == pytest.approx(100.0 * V / 2200.0, rel=1e-5)
    assert rig.axis.actual_velocity == pytest.approx(V, rel=1e-5)
    assert rig.axis.actual_acceleration == pytest.approx(0.0, abs=1.0)


def test_peaks_are_held(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.following_error_peak_positive > 0.05
    assert rig.axis.following_error_peak_negative < -0.05
    assert rig.axis.drive.output_peak_positive == pytest.approx(177.8, rel=1e-2)


def test_the_outputs_are_limited(make_rig: Any) -> None:
    rig = make_rig(
        controller_output_limit=0.01,
        drive_output_limit_max=0.05,
        controller_following_error_position_monitoring_enable=0,
    )
    assert not rig.has(StateBit.DRIVE_LIMIT_ACTIVE)
    at_speed(rig)
    assert rig.has(StateBit.DRIVE_LIMIT_ACTIVE)
    assert rig.axis.controller.output == pytest.approx(0.01 * 2200.0)
    assert rig.axis.drive.output == pytest.approx(0.05 * 2200.0)
    assert rig.axis.actual_velocity == pytest.approx(0.05 * 2200.0)


def test_the_dead_band_is_not_corrected(make_rig: Any) -> None:
    rig = make_rig(controller_position_dead_band=1.0, controller_velocity_feedforward_weight=0.99)
    commands.start(rig.axis, 1, 50.0, V)
    rig.until_rest()
    rig.seconds(2.0)
    assert 0.1 < abs(rig.axis.following_error) <= 1.0


FREE = {
    "controller_following_error_position_monitoring_enable": 0,
    "encoder_scaling_factor": 1e-8,
    "encoder_velocity_filter_time": 0.0,
    "simulation_time_constant": 0.0,
}
"""No supervision in the way, no rounding, a drive without lag."""


def blocked(make_rig: Any, error: float, **values: float) -> Any:
    """A rig whose motor is stuck `error` behind its set position, at rest."""
    rig = make_rig(simulation_blocked=1, **(FREE | values))
    rig.axis.machine.position = -error
    return rig


def test_pp_raises_its_gain_with_the_velocity(make_rig: Any) -> None:
    rig = make_rig(
        controller_type=ControllerType.PP_POSITION,
        controller_position_kv=10.0,
        controller_position_kv_fast=50.0,
        controller_position_kv_velocity_threshold=0.1,
        controller_velocity_feedforward_weight=0.9,
        **FREE,
    )
    commands.start(rig.axis, 3, 0.0, V)
    threshold = 0.1 * 2200.0
    while rig.axis.set_velocity < V:
        rig.run(1)
        kv = 10.0 + 40.0 * min(rig.axis.set_velocity / threshold, 1.0)
        assert rig.axis.controller.position_kv_interpolated == pytest.approx(kv)
        part = rig.axis.controller.position_p_part
        assert part == pytest.approx(kv * rig.axis.following_error, abs=1e-6)
    rig.seconds(2.0)
    kv = 10.0 + 40.0 * V / threshold
    assert rig.axis.following_error == pytest.approx(0.1 * V / kv, rel=1e-4)


def test_the_i_part_integrates_with_tn_up_to_its_limit(make_rig: Any) -> None:
    kv, tn, error = 5.0, 0.4, 1.0
    rig = blocked(
        make_rig,
        error,
        controller_type=ControllerType.PID_POSITION,
        controller_position_kv=kv,
        controller_position_tn=tn,
        controller_position_i_limit=0.01,
    )
    rig.axis.set_position = 0.0
    rig.run(1)
    axis = rig.axis
    for n in range(2, 200):
        rig.run(1)
        expected = min(kv * axis.following_error * n * rig.dt / tn, 0.01 * 2200.0)
        assert axis.controller.position_i_part == pytest.approx(expected, rel=1e-6)
    rig.seconds(2.0)
    assert axis.controller.position_i_part == pytest.approx(22.0)
    assert axis.controller.position_i_limit_active == 1
    assert axis.controller.output == pytest.approx(kv * axis.following_error + 22.0)


def test_the_i_part_removes_the_error_of_a_drifting_drive(make_rig: Any) -> None:
    for kind, left in (
        (ControllerType.P_POSITION, 10.0 / 20.0),
        (ControllerType.PID_POSITION, 0.0),
    ):
        rig = make_rig(
            controller_type=kind,
            controller_position_tn=0.2,
            simulation_drift=-10.0,
            controller_position_kv=20.0,
        )
        rig.seconds(6.0)
        assert rig.axis.following_error == pytest.approx(left, abs=1e-3)


def test_no_i_part_while_positioning(make_rig: Any) -> None:
    rig = make_rig(
        controller_type=ControllerType.PID_POSITION,
        controller_position_tn=0.2,
        controller_position_i_disable_while_positioning=1,
        simulation_drift=-10.0,
    )
    rig.seconds(5.0)
    assert rig.axis.controller.position_i_part == pytest.approx(10.0, rel=1e-2)
    commands.start(rig.axis, 1, 100.0, V)
    rig.run(1)
    while rig.axis.set_motion_phase:
        assert rig.axis.controller.position_i_part == 0.0
        rig.run(1)
    rig.seconds(5.0)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-3)


def disturb(axis: Any, source: random.Random) -> None:
    """A command, an enable, an override at random."""
    way, speed = source.uniform(-50.0, 50.0), source.uniform(1.0, 300.0)
    source.choice(
        (
            lambda: commands.start(axis, 2, way, speed),
            lambda: commands.universal_start(axis, 3, 0.0, velocity=speed),
            lambda: commands.universal_start(axis, 1, way, speed, buffer_mode=1),
            lambda: commands.home(axis),
            lambda: commands.stop(axis),
            lambda: commands.reset(axis),
            lambda: commands.start_reversing(axis, 1, way, -way, speed, 0.1),
            lambda: commands.start_external_setpoint(axis, 1, way),
            lambda: commands.stop_external_setpoint(axis),
            lambda: setattr(axis, "velocity_override", source.randrange(1_000_001)),
            lambda: setattr(axis, "control_dword", source.choice((7, 7, 7, 0, 3))),
            lambda: axis.wake(adapts=True),
        )
    )()


def test_whatever_moves_the_set_point_the_i_part_is_off(make_rig: Any) -> None:
    """Commands, enables, overrides, parameters at random: 0 in each cycle that positions."""
    source = random.Random(118)
    moved = rested = 0
    for number in range(12):
        rig = make_rig(
            compiled=bool(number % 2),
            controller_type=ControllerType.PID_POSITION,
            controller_position_tn=source.uniform(0.01, 1.0),
            controller_position_tv=source.choice((0.0, 0.02)),
            controller_position_i_limit=source.uniform(0.0, 1.0),
            controller_position_i_disable_while_positioning=1,
            simulation_drift=source.uniform(-50.0, 50.0),
        )
        axis = rig.axis
        for _ in range(60):
            disturb(axis, source)
            for _ in range(source.randrange(1, 80)):
                rig.run(1)
                if axis.set_motion_phase or axis.set_velocity:
                    moved += 1
                    assert axis.controller.position_i_part == 0.0
                elif axis.controller.position_i_part:
                    rested += 1
    assert moved > 5_000
    assert rested > 1_000


def test_the_d_part_is_the_damped_derivative(make_rig: Any) -> None:
    kv, tv, td = 10.0, 0.05, 0.03
    rig = make_rig(
        controller_type=ControllerType.PID_POSITION,
        controller_position_kv=kv,
        controller_position_tv=tv,
        controller_position_td=td,
        controller_position_d_limit=1.0,
        controller_velocity_feedforward_weight=0.5,
        **FREE,
    )
    rig.run(1)
    commands.start(rig.axis, 3, 0.0, V)
    before, part = rig.axis.following_error, 0.0
    for _ in range(100):
        rig.run(1)
        error = rig.axis.following_error
        rate = kv * tv * (error - before) / rig.dt
        part += (rate - part) * rig.dt / (td + rig.dt)
        before = error
        assert rig.axis.controller.position_d_part == pytest.approx(part, abs=1e-5)
    rig.axis.controller.position_d_limit = 0.0001
    rig.run(1)
    assert abs(rig.axis.controller.position_d_part) <= 0.22 * (1 + 1e-12)
    assert rig.axis.controller.position_d_limit_active == 1


def test_the_integrator_is_held_while_the_output_is_limited(make_rig: Any) -> None:
    rig = blocked(
        make_rig,
        10.0,
        controller_type=ControllerType.PID_POSITION,
        controller_position_tn=1.0,
        controller_position_i_limit=1.0,
        controller_output_limit=0.05,
    )
    rig.run(2)
    rig.axis.set_position = 0.0
    rig.seconds(0.5)
    before = rig.axis.controller.position_i_part
    assert rig.axis.controller.position_arw_active == 1
    rig.seconds(1.0)
    assert rig.axis.controller.position_i_part == before
    assert rig.axis.controller.output == pytest.approx(0.05 * 2200.0)


@pytest.mark.parametrize("kind", [1, 2, 3])
def test_acceleration_feedforward(make_rig: Any, kind: int) -> None:
    ka = 0.02
    rig = make_rig(controller_type=kind, controller_acceleration_feedforward_ka=ka, **FREE)
    commands.start(rig.axis, 3, 0.0, V)
    for _ in range(60):
        rig.run(1)
        axis = rig.axis
        share = ka * axis.set_acceleration
        assert axis.controller.acceleration_feedforward == pytest.approx(share)
        assert axis.drive.output == pytest.approx(
            axis.controller.output + axis.set_velocity + share, abs=1e-9
        )


def test_offset_calibration_learns_the_drift(make_rig: Any) -> None:
    rig = make_rig(
        controller_auto_offset_enable=1,
        controller_auto_offset_time_constant=0.5,
        simulation_drift=-8.0,
    )
    rig.seconds(10.0)
    assert rig.axis.controller.auto_offset_part == pytest.approx(8.0, abs=0.05)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("hold", "fading", "share"), [(0, 0, 0.0), (1, 0, 1.0), (1, 1, None)])
def test_offset_calibration_above_its_limit(
    make_rig: Any, hold: int, fading: int, share: float | None
) -> None:
    rig = make_rig(
        controller_auto_offset_enable=1,
        controller_auto_offset_time_constant=0.5,
        controller_auto_offset_hold=hold,
        controller_auto_offset_fading=fading,
        controller_auto_offset_feedforward_limit=0.05,
        simulation_drift=-8.0,
    )
    rig.seconds(10.0)
    commands.start(rig.axis, 3, 0.0, V)
    rig.until(lambda axis: axis.set_velocity > 0.05 * 2200.0 - 1.5)
    learned = rig.axis.controller.auto_offset_part
    rig.until(lambda axis: axis.set_velocity > 0.05 * 2200.0)
    if share is None:
        before = rig.axis.controller.auto_offset_part
        rig.run(100)
        fade = (1.0 - rig.dt / 0.5) ** 100
        assert rig.axis.controller.auto_offset_part == pytest.approx(before * fade, rel=1e-6)
    else:
        rig.run(100)
        assert rig.axis.controller.auto_offset_part == pytest.approx(learned * share, abs=0.1)


def test_the_position_error_filter(make_rig: Any) -> None:
    rig = blocked(make_rig, 2.0, controller_position_error_filter_time=0.1)
    rig.run(2)
    rig.axis.set_position = rig.axis.actual_position
    rig.seconds(2.0)
    start = rig.axis.controller.position_p_part
    rig.axis.set_position += 1.0
    for n in range(1, 50):
        rig.run(1)
        left = (0.1 / (0.1 + rig.dt)) ** n
        part = start + 20.0 * 1.0 * (1.0 - left)
        assert rig.axis.controller.position_p_part == pytest.approx(part, abs=1e-6)


def test_a_velocity_loop_gets_feedforward_and_position_part(make_rig: Any) -> None:
    kp = 0.6
    rig = make_rig(controller_type=ControllerType.P_VELOCITY, controller_velocity_kp=kp, **FREE)
    commands.start(rig.axis, 3, 0.0, V)
    for _ in range(300):
        rig.run(1)
        axis = rig.axis
        goal = axis.set_velocity + axis.controller.position_p_part
        assert axis.controller.velocity_controller_input == pytest.approx(goal)
        part = kp * (goal - axis.actual_velocity)
        assert axis.controller.velocity_p_part == pytest.approx(part, abs=1e-5)
        assert axis.drive.output == pytest.approx(axis.controller.output)
    assert axis.controller.output == pytest.approx(part)


def test_a_pi_velocity_loop_leaves_no_error(make_rig: Any) -> None:
    rig = make_rig(
        controller_type=ControllerType.PI_VELOCITY,
        controller_velocity_kp=0.5,
        controller_velocity_tn=0.05,
        controller_velocity_i_limit=1.0,
        controller_output_limit=1.0,
        simulation_drift=-20.0,
        **FREE,
    )
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(5.0)
    assert rig.axis.actual_velocity == pytest.approx(V, rel=1e-4)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-3)
    assert rig.axis.controller.velocity_i_part == pytest.approx(V + 20.0, rel=1e-3)
    rig.axis.controller.velocity_i_limit = 0.01
    rig.run(1)
    assert rig.axis.controller.velocity_i_part == pytest.approx(22.0)
    assert rig.axis.controller.velocity_i_limit_active == 1


def test_filters_and_dead_band_of_the_velocity_error(make_rig: Any) -> None:
    for name in ("controller_velocity_error_pt1_filter", "controller_velocity_error_pt2_filter"):
        rig = blocked(
            make_rig,
            0.0,
            controller_type=ControllerType.P_VELOCITY,
            controller_position_kv=0.0,
            controller_velocity_kp=2.0,
            **{name: 0.05},
        )
        commands.start(rig.axis, 3, 0.0, 100.0, 1e4, 1e4, 1e8)
        rig.until(lambda axis: axis.set_velocity == 100.0)
        rig.run(1)
        assert rig.axis.controller.velocity_p_part < 150.0
        rig.seconds(2.0)
        assert rig.axis.controller.velocity_p_part == pytest.approx(200.0)
    rig = blocked(
        make_rig,
        0.0,
        controller_type=ControllerType.P_VELOCITY,
        controller_position_kv=0.0,
        controller_velocity_dead_band=150.0,
    )
    commands.start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(2.0)
    assert rig.axis.controller.velocity_p_part == 0.0


def test_the_observer_follows_the_axis(make_rig: Any) -> None:
    rig = make_rig(
        controller_type=ControllerType.PI_VELOCITY,
        controller_velocity_kp=0.5,
        controller_velocity_tn=0.05,
        controller_velocity_i_limit=1.0,
        controller_observer_mode=1,
        controller_motor_inertia=0.002,
        controller_motor_torque_constant=0.5,
        **(FREE | {"simulation_time_constant": 0.01}),
    )
    commands.start(rig.axis, 3, 0.0, V)
    for _ in range(1000):
        rig.run(1)
        axis = rig.axis
        torque = axis.controller.observer_motor_current * 0.5
        assert abs(axis.controller.observer_position_error) < 0.5
        assert abs(axis.controller.observer_velocity1 - axis.actual_velocity) < 10.0
    assert axis.controller.observer_position == pytest.approx(axis.actual_position, abs=1e-3)
    assert axis.controller.observer_velocity1 == pytest.approx(V, rel=1e-3)
    assert axis.controller.observer_velocity2 == pytest.approx(V, rel=1e-3)
    assert axis.controller.observer_acceleration == pytest.approx(0.0, abs=1.0)
    assert torque == pytest.approx(0.0, abs=1e-3)


def test_the_set_position_lags_the_set_velocity_by_the_delay(make_rig: Any) -> None:
    delay = 0.01
    rig = make_rig(setpoint_velocity_position_delay=delay, **FREE)
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(3.0)
    assert rig.axis.set_position - rig.axis.actual_position == pytest.approx(delay * V, rel=1e-3)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-3)


def test_an_external_part_and_the_velocity_offset_are_added(make_rig: Any) -> None:
    rig = make_rig(drive_velocity_offset=7.0, **FREE)
    rig.axis.external_controller_component = 5.0
    rig.seconds(3.0)
    assert rig.axis.following_error == pytest.approx(-12.0 / 20.0)
    assert rig.axis.drive.output == pytest.approx(0.0, abs=1e-6)


def test_the_difference_of_following_errors_of_master_and_slave(make_rig: Any) -> None:
    """Master less slave in units of the master; 0x6100:0x22 and 0x23 show what it was at most."""
    rig = make_rig(count=2, controller_velocity_feedforward_weight=0.5, **FREE)
    master, slave = rig.nc
    slave.controller.following_error_difference_scaling = 0.25
    commands.couple(slave, 1, 1, 0, 0, 2.0)
    commands.start(master, 3, 0.0, V)
    rig.seconds(2.0)
    error = master.following_error
    assert slave.following_error == pytest.approx(2.0 * error)
    assert slave.following_error_difference == pytest.approx(0.5 * error)
    assert slave.following_error_difference_peak_positive >= 0.5 * error > 0.0
    commands.decouple(slave)
    assert slave.following_error_difference == 0.0


def test_kcp_holds_the_slave_beside_its_actual_master(make_rig: Any) -> None:
    beside = []
    for kcp in (0.0, 100.0):
        rig = make_rig(count=2, **FREE)
        master, slave = rig.nc
        master.controller.velocity_feedforward_weight = 0.5
        slave.controller.slave_coupling_kcp = kcp
        commands.couple(slave, 1, 1, 0, 0, 1.0)
        commands.start(master, 3, 0.0, V)
        rig.seconds(2.0)
        beside.append(slave.actual_position - master.actual_position)
    assert abs(beside[1]) < 0.3 * abs(beside[0])
