"""Simulated drive against its equations."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes.nc.choices import ControllerType, DriveType
from achse.motion import AxisParameters, Nc, commands
from achse.motion.control.drive import characteristic
from achse.motion.states import DriveOperationMode

V = 200.0


def test_dead_time_delays_the_drive(make_rig: Any) -> None:
    for dead_cycles in (0, 1, 5):
        rig = make_rig(
            simulation_dead_time=dead_cycles * 0.002,
            simulation_time_constant=0.0,
            controller_position_kv=0.0,
            encoder_scaling_factor=1e-9,
            encoder_velocity_filter_time=0.0,
        )
        commands.start(rig.axis, 3, 0.0, V)
        outputs, velocities = [], []
        for _ in range(200):
            rig.run(1)
            outputs.append(rig.axis.drive.output)
            velocities.append(rig.axis.actual_velocity)
        late = 1 + dead_cycles  # the encoder shows what the drive did until this cycle
        assert velocities[late:] == pytest.approx(outputs[:-late], abs=1e-5)


def test_the_velocity_follows_with_a_first_order_lag(make_rig: Any) -> None:
    constant = 0.05
    rig = make_rig(
        simulation_time_constant=constant,
        controller_position_kv=0.0,
        controller_following_error_position_monitoring_enable=0,
        encoder_scaling_factor=1e-9,
        encoder_velocity_filter_time=0.0,
        default_acceleration=1e4,
        default_jerk=1e9,
    )
    commands.start(rig.axis, 3, 0.0, V)
    rig.until(lambda axis: axis.set_velocity == V)
    missing = V - rig.axis.actual_velocity
    rig.run(25)
    factor = (constant / (constant + rig.dt)) ** 25
    assert V - rig.axis.actual_velocity == pytest.approx(missing * factor, rel=0.02)


@pytest.mark.parametrize(("kpc", "scaling", "gain"), [(20_000, 1.0, 20.0), (10_000, 4.0, 10.0)])
def test_a_position_loop_in_the_drive_has_its_gain(
    make_rig: Any, kpc: int, scaling: float, gain: float
) -> None:
    """PROFIdrive with DSC: the NC gives feed-forward alone, the drive closes the position loop."""
    rig = make_rig(
        drive_type=DriveType.PROVIDRIVE_MC,
        drive_dsc_kpc=kpc,
        drive_dsc_xerr_scaling=scaling,
        controller_position_kv=500.0,
        controller_velocity_feedforward_weight=0.0,
        controller_following_error_position_max=50.0,
        simulation_dead_time=0.02,
    )
    commands.start(rig.axis, 1, 1000.0, V)
    rig.seconds(2.0)
    assert rig.axis.controller.output == rig.axis.drive.output == 0.0
    assert rig.axis.following_error == pytest.approx(V / gain, rel=1e-3)
    rig.axis.drive.dsc_xerr_scaling = 2.0 * scaling  # more than the drive expects
    rig.seconds(1.0)
    assert rig.axis.following_error == pytest.approx(V / gain / 2.0, rel=1e-3)
    rig.until_rest()
    rig.seconds(2.0)
    assert rig.axis.actual_position == pytest.approx(1000.0, abs=1e-3)
    assert rig.axis.machine.velocity == 0.0


def test_only_a_profidrive_closes_its_position_loop(make_rig: Any) -> None:
    digests = []
    for kpc in (0, 20_000):
        rig = make_rig(drive_type=DriveType.SERCOS, drive_dsc_kpc=kpc)
        commands.start(rig.axis, 1, 100.0, V)
        rig.seconds(0.5)
        digests.append((rig.axis.actual_position, rig.axis.controller.output))
    assert digests[0] == digests[1]


def test_an_ideal_drive_has_no_following_error(make_rig: Any) -> None:
    rig = make_rig(simulation_ideal=1)
    commands.start(rig.axis, 1, 100.0, V)
    while rig.axis.set_motion_phase or rig.axis.set_position == 0.0:
        rig.run(1)
        assert abs(rig.axis.following_error) <= 0.5001e-4
    assert rig.axis.actual_position == pytest.approx(100.0, abs=1e-9)


def test_a_wrong_counting_direction_runs_away(make_rig: Any) -> None:
    rig = make_rig(encoder_count_direction=1, simulation_encoder_inverted=0)
    commands.start(rig.axis, 1, 50.0, V)
    rig.until(lambda axis: axis.error_code == 0x4550, 5.0)


FREE = {
    "controller_following_error_position_monitoring_enable": 0,
    "encoder_scaling_factor": 1e-9,
    "encoder_velocity_filter_time": 0.0,
}


def test_the_reference_output_scales_the_velocity_at_full_output(make_rig: Any) -> None:
    rig = make_rig(drive_reference_velocity=1000.0, drive_reference_output=0.5, **FREE)
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(3.0)
    assert rig.axis.drive.output_percent == pytest.approx(100.0 * V / 2000.0, rel=1e-6)
    rig.axis.drive.reference_output = 1.0
    rig.run(1)
    assert rig.axis.drive.output_percent == pytest.approx(100.0 * V / 1000.0, rel=1e-6)


def test_the_characteristic_of_a_non_linear_drive(make_rig: Any) -> None:
    rig = make_rig(
        drive_type=DriveType.MDP_252_NONLINEAR,
        drive_reference_velocity=1000.0,
        drive_velocity_reference_point=0.1,
        drive_output_reference_point=0.4,
        drive_quadrant_compensation_factor=0.5,
    )
    axis = rig.axis
    for share, output in (
        (0.05, 0.2),
        (0.1, 0.4),
        (0.55, 0.7),
        (1.0, 1.0),
        (-0.05, -0.1),
        (-1, -0.5),
    ):
        assert characteristic(axis, share) == pytest.approx(output)
    commands.start(axis, 3, 0.0, 50.0)
    rig.seconds(3.0)
    assert axis.drive.output_percent == pytest.approx(5.0, abs=0.01)
    assert axis.drive.output_percent_nonlinear == pytest.approx(20.0, abs=0.04)
    assert axis.actual_velocity == pytest.approx(50.0, rel=1e-3)
    assert characteristic(make_rig().axis, 0.3) == pytest.approx(0.3)


def test_the_output_offset_moves_the_axis_like_drift(make_rig: Any) -> None:
    rig = make_rig(drive_output_offset=0.01, drive_reference_velocity=1000.0, **FREE)
    rig.seconds(3.0)
    assert rig.axis.following_error == pytest.approx(-10.0 / 20.0, rel=1e-4)
    rig.axis.drive.output_offset = 0.0
    rig.axis.simulation_drift = -10.0
    rig.seconds(3.0)
    assert rig.axis.following_error == pytest.approx(0.5, rel=1e-4)
    rig.axis.drive.velocity_offset = 10.0
    rig.seconds(3.0)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-4)


def test_the_velocity_output_delay_is_dead_time(make_rig: Any) -> None:
    rig = make_rig(
        drive_velocity_output_delay=0.006,
        simulation_dead_time=0.004,
        simulation_time_constant=0.0,
        controller_position_kv=0.0,
        **FREE,
    )
    commands.start(rig.axis, 3, 0.0, V)
    outputs, velocities = [], []
    for _ in range(200):
        rig.run(1)
        outputs.append(rig.axis.drive.output)
        velocities.append(rig.axis.actual_velocity)
    assert velocities[6:] == pytest.approx(outputs[:-6], abs=1e-5)


FULL = 20_000.0

INCREMENT = 0.51
"""Torques go out and come back in whole thousandths, a cycle later."""


def test_the_torque_accelerates_the_load(make_rig: Any) -> None:
    """1000 = 100 % gives the configured acceleration; load and friction come on top."""
    rig = make_rig(
        simulation_full_torque_acceleration=FULL,
        simulation_load_torque=50.0,
        simulation_friction_torque=20.0,
        simulation_time_constant=0.02,
        **FREE,
    )
    commands.start(rig.axis, 1, 100.0, V)
    rig.run(1)
    before = rig.axis.machine.velocity
    torque_before = rig.axis.drive.actual_torque
    reported = rig.axis.machine.torque
    for _ in range(300):
        rig.run(1)
        velocity = rig.axis.machine.velocity
        torque = (velocity - before) / rig.dt / FULL * 1000.0 + 50.0
        torque += 20.0 * ((velocity > 0.0) - (velocity < 0.0))
        assert rig.axis.drive.actual_torque == pytest.approx(reported, abs=INCREMENT)
        rate = (rig.axis.drive.actual_torque - torque_before) / rig.dt
        assert rig.axis.drive.actual_torque_derivative == pytest.approx(rate, abs=1e-3)
        before, torque_before, reported = velocity, rig.axis.drive.actual_torque, torque


def test_torque_scaling_and_filters(make_rig: Any) -> None:
    rig = make_rig(
        simulation_load_torque=100.0,
        simulation_torque_weight=1.0,
        drive_actual_torque_scaling=0.1,
        drive_actual_torque_filter_time=0.05,
        drive_actual_torque_derivative_filter_time=0.02,
        controller_position_kv=0.0,
        control_dword=0,
        simulation_blocked=1,
    )
    rig.run(2)
    rate = rig.axis.drive.actual_torque_derivative
    torque = rig.axis.drive.actual_torque
    for _ in range(100):
        rig.run(1)
        step = (10.0 - torque) * rig.dt / (0.05 + rig.dt)
        torque += step
        rate += (step / rig.dt - rate) * rig.dt / (0.02 + rig.dt)
        assert rig.axis.drive.actual_torque == pytest.approx(torque, rel=1e-9)
        assert rig.axis.drive.actual_torque_derivative == pytest.approx(rate, rel=1e-6)
    assert torque == pytest.approx(10.0, rel=0.05)


def test_a_load_leaves_an_error_that_a_torque_offset_removes(make_rig: Any) -> None:
    lag, load = 0.02, 60.0
    rig = make_rig(simulation_load_torque=load, simulation_time_constant=lag, **FREE)
    rig.seconds(3.0)
    missing = load / 1000.0 * FULL * lag
    assert rig.axis.following_error == pytest.approx(missing / 20.0, rel=1e-4)
    rig.axis.set_torque_offset = load
    rig.seconds(3.0)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-4)
    assert rig.axis.drive.actual_torque == pytest.approx(load, rel=1e-6)


def test_in_torque_mode_the_motor_obeys_its_torque(make_rig: Any) -> None:
    rig = make_rig(
        simulation_load_torque=100.0,
        simulation_friction_torque=50.0,
        controller_following_error_velocity_monitoring_enable=0,
        **FREE,
    )
    rig.axis.drive_operation_mode = DriveOperationMode.TORQUE
    rig.axis.set_torque = 120.0  # load and friction hold it, as 120 - 100 is less than 50
    rig.seconds(1.0)
    assert rig.axis.machine.velocity == pytest.approx(0.0, abs=1e-9)
    rig.axis.set_torque = 200.0
    begin = rig.axis.machine.velocity
    rig.run(100)
    gained = (200.0 - 100.0 - 50.0) / 1000.0 * FULL * 100 * rig.dt
    assert rig.axis.machine.velocity - begin == pytest.approx(gained)
    assert rig.axis.drive.actual_torque == pytest.approx(200.0)


def test_friction_holds_a_drive_that_pulls_weakly(make_rig: Any) -> None:
    lag = 0.02
    rig = make_rig(simulation_friction_torque=10.0, simulation_time_constant=lag, **FREE)
    stick = 10.0 / 1000.0 * FULL * lag / 20.0  # kv 20
    commands.start(rig.axis, 1, 10.0, V)
    rig.until_rest()
    rig.seconds(2.0)
    assert 0.0 < abs(rig.axis.following_error) <= stick * (1 + 1e-6)


def position_drive(make_rig: Any, **values: float) -> Any:
    return make_rig(
        drive_type=DriveType.SERCOS,
        controller_type=ControllerType.SERCOS_POSITION,
        **(FREE | values),
    )


def test_a_drive_with_position_interface_follows_the_set_position(make_rig: Any) -> None:
    rig = position_drive(make_rig)
    commands.start(rig.axis, 1, 100.0, V)
    for _ in range(100):
        before = rig.axis.set_position  # which the drive hears of, and goes to within a cycle
        rig.run(1)
        assert rig.axis.actual_position == pytest.approx(before, abs=1e-8)
        assert rig.axis.following_error == pytest.approx(0.0, abs=1e-8)
        assert rig.axis.controller.output == 0.0


def test_the_moving_average_of_the_position_output(make_rig: Any) -> None:
    count = 10
    rig = position_drive(
        make_rig, drive_output_filter_type=1, drive_output_filter_time=count * 0.002
    )
    commands.start(rig.axis, 1, 30.0, V)
    sets = [rig.axis.set_position] * count
    filtered = [rig.axis.set_position] * 3
    for _ in range(300):
        rig.run(1)
        sets.append(rig.axis.set_position)
        filtered.append(sum(sets[-count:]) / count)
        axis = rig.axis
        assert axis.drive.filtered_set_position == pytest.approx(filtered[-1], abs=1e-9)
        velocity = (filtered[-1] - filtered[-2]) / rig.dt
        assert axis.drive.filtered_set_velocity == pytest.approx(velocity, abs=1e-6)
        assert axis.actual_position == pytest.approx(filtered[-2], abs=1e-8)
    rig.seconds(1.0)
    assert rig.axis.actual_position == pytest.approx(30.0, abs=1e-8)


@pytest.mark.parametrize("order", [1, 3])
def test_the_p_tn_filter_of_the_position_output(make_rig: Any, order: int) -> None:
    time = 0.03
    rig = position_drive(
        make_rig,
        drive_output_filter_type=2,
        drive_output_filter_time=time,
        drive_output_filter_order=order,
    )
    commands.start(rig.axis, 3, 0.0, V)
    stages = [0.0] * order
    weight = rig.dt / (time / order + rig.dt)
    for _ in range(200):
        rig.run(1)
        value = rig.axis.set_position
        for n in range(order):
            stages[n] += (value - stages[n]) * weight
            value = stages[n]
        assert rig.axis.drive.filtered_set_position == pytest.approx(value, abs=1e-9)
    rig.seconds(3.0)
    assert rig.axis.following_error == pytest.approx(V * time, rel=1e-4)
    commands.stop(rig.axis)
    rig.until_rest()
    rig.seconds(2.0)
    assert rig.axis.following_error == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("mode", [1, 2])
def test_dead_time_compensation_of_the_position_output(make_rig: Any, mode: int) -> None:
    late = 0.004
    rig = position_drive(
        make_rig,
        drive_dead_time_compensation_mode=mode,
        drive_dead_time_compensation_shift=round(late * 1e9),
    )
    commands.start(rig.axis, 1, 100.0, V)
    for _ in range(150):
        axis = rig.axis
        sent = axis.set_position + axis.drive.dead_time_position_correction
        rig.run(1)
        way = late * axis.set_velocity
        way += 0.5 * late * late * axis.set_acceleration if mode == 2 else 0.0
        assert axis.drive.dead_time_position_correction == pytest.approx(way)
        assert axis.actual_position == pytest.approx(sent, abs=1e-8)
        assert axis.following_error == pytest.approx(0.0, abs=1e-8)


def test_renaming_positions_does_not_move_a_filtered_drive(make_rig: Any) -> None:
    rig = position_drive(make_rig, drive_output_filter_type=2, drive_output_filter_time=0.03)
    commands.start(rig.axis, 1, 30.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    counts = rig.axis.encoder.software_increments
    assert commands.set_actual_position(rig.axis, 1, 1000.0) == 0
    for _ in range(100):
        rig.run(1)
        assert rig.axis.encoder.software_increments == pytest.approx(counts, abs=10)
        assert rig.axis.drive.filtered_set_position == pytest.approx(1000.0, abs=1e-6)


@pytest.mark.parametrize("filter_type", [1, 2])
def test_a_filtered_drive_does_not_jump_when_its_position_loop_comes_back(
    make_rig: Any, filter_type: int
) -> None:
    rig = position_drive(
        make_rig, drive_output_filter_type=filter_type, drive_output_filter_time=0.03
    )
    axis = rig.axis
    torque = 0x3001, 0, 0, 0, 100.0, 0.0, V, -V, 0.0, 0.0, 0.0
    phases: list[tuple[Callable[[], int], Callable[[Any], int]]] = [
        (lambda: commands.start_torque_control(axis, *torque), commands.stop),
        (lambda: commands.start_drive_output(axis, 2, 0.5 * V), commands.stop_drive_output),
    ]
    for begin, end in phases:
        before = axis.actual_position
        assert begin() == 0
        rig.until(lambda axis, goal=before + 20.0: axis.actual_position > goal)
        assert end(axis) == 0
        for _ in range(500):
            before = axis.actual_position
            rig.run(1)
            assert abs(axis.actual_position - before) <= V * rig.dt * 1.1
        assert axis.set_motion_phase == 0


def test_a_second_encoder_counts_the_same_motor() -> None:
    for compiled in (False, True):
        nc = Nc(
            2_000_000,
            [
                AxisParameters(
                    1,
                    values={"control_dword": 7, "velocity_override": 1_000_000},
                    encoder_ids=(1, 9),
                    elements=[{"encoder_scaling_factor": 0.01, "encoder_position_offset": 5.0}],
                ),
                AxisParameters(2),
            ],
            compiled=compiled,
        )
        axis, second = nc.axis(1), nc.element("encoder", 9)
        assert second.actual_position == 5.0
        commands.start(axis, 1, 50.0, V)
        for _ in range(2000):
            nc.cycle()
            assert second.actual_position == pytest.approx(axis.actual_position + 5.0, abs=0.5)
        assert second.actual_position == pytest.approx(55.0, abs=0.01)
        assert second.software_increments == 5000
        assert nc.axis(2).actual_position == 0.0
