"""The cycle: plain and compiled are bit-identical, resting axes stay right."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import Axis, AxisParameters, Nc, commands
from achse.motion.elements import control_loop_count

FULL = 1_000_000


def _axes(dice: random.Random) -> list[AxisParameters]:
    """Axes of quite different kinds."""
    return [
        AxisParameters(
            number,
            values={
                "control_dword": 7,
                "velocity_override": FULL,
                "override_type": dice.randrange(1, 5),
                "max_velocity": 10 ** dice.uniform(1, 4),
                "default_acceleration": 10 ** dice.uniform(2, 4),
                "default_deceleration": 10 ** dice.uniform(2, 4),
                "default_jerk": 10 ** dice.uniform(3, 6),
                "fast_axis_stop_deceleration": dice.choice([0.0, 5000.0]),
                "encoder_scaling_factor": dice.choice([1e-4, 0.0125, 1 / 3e5]),
                "encoder_modulo_factor": dice.choice([360.0, 1 / 3]),
                "encoder_soft_limit_max_enable": dice.randrange(2),
                "encoder_soft_limit_max": 700.0,
                "encoder_position_filter_time": dice.choice([0.0, 0.003]),
                "encoder_count_direction": number % 2,
                "drive_motor_polarity": number % 2,
                "controller_position_kv": dice.choice([5.0, 20.0, 30.0]),
                "controller_velocity_feedforward_weight": dice.choice([0.0, 0.9, 1.0]),
                "controller_following_error_position_max": dice.choice([1.0, 50.0]),
                "simulation_ideal": number == 3,
                "simulation_time_constant": dice.choice([0.0, 0.004, 0.02]),
                "simulation_dead_time": dice.choice([0.0, 0.002, 0.005]),
                "motion_monitoring_enable": 1,
                "peh_monitoring_enable": dice.randrange(2),
                "error_reaction_mode": dice.randrange(2),
                "error_reaction_delay": 0.05,
            },
        )
        for number in range(1, 6)
    ]


def _kinds(dice: random.Random) -> list[AxisParameters]:
    """Axes that use what most axes do not."""
    common: dict[str, float] = {
        "control_dword": 7, "velocity_override": FULL,
        "controller_following_error_position_max": 500.0,
    }  # fmt: skip
    kinds: list[dict[str, float]] = [
        {
            "encoder_mask": dice.choice([0xFFFFFF, 3_600_000]),
            "encoder_raw_value_filter_mask": dice.choice([0, 3]),
            "encoder_reference_system": dice.choice([0, 1, 2]),
            "encoder_actual_position_correction_enable": 1,
            "encoder_actual_position_correction_filter_time": 0.02,
            "actual_position_correction": 0.5,
            "encoder_dead_time_compensation_mode": 2,
            "encoder_dead_time_compensation_shift": 3_000_000,
            "encoder_simulation_noise_scaling": 2.5,
            "backlash_compensation_enable": 1,
            "backlash": 0.2,
        },
        {
            "controller_type": 3,
            "controller_position_tn": 0.3,
            "controller_position_tv": 0.01,
            "controller_position_td": 0.02,
            "controller_acceleration_feedforward_ka": 0.004,
            "simulation_load_torque": 100.0,
            "simulation_friction_torque": 30.0,
            "drive_type": 6,
            "drive_velocity_reference_point": 0.3,
            "drive_output_reference_point": 0.6,
            "drive_actual_torque_filter_time": 0.01,
        },
        {
            "controller_type": 6,
            "controller_velocity_kp": 0.8,
            "controller_velocity_tn": 0.05,
            "controller_velocity_i_limit": 1.0,
            "controller_observer_mode": 1,
            "setpoint_velocity_position_delay": 0.004,
        },
        {
            "controller_type": 9,
            "drive_type": 9,
            "drive_output_filter_type": dice.choice([1, 2]),
            "drive_output_filter_time": 0.02,
            "drive_output_filter_order": 3,
            "drive_dead_time_compensation_mode": 2,
            "drive_dead_time_compensation_shift": 2_000_000,
        },
        {
            "axis_type": 2,
            "drive_type": 7,
            "brake_release_delay": 0.02,
            "brake_delay_positive": 0.05,
            "rapid_to_creep_switch_time": 0.03,
        },
    ]
    return [
        AxisParameters(
            number,
            values=common | values,
            encoder_ids=(number, number + 100) if number == 1 else (),
            elements=[{"encoder_scaling_factor": 0.003}] if number == 1 else (),
        )
        for number, values in enumerate(kinds, 1)
    ]


def _generate(axis: Axis, dice: random.Random) -> int:
    """One random start or stop of a special generator; its answer."""
    first, second = dice.uniform(-90.0, 90.0), dice.uniform(-90.0, 90.0)
    match dice.randrange(9):
        case 0:
            axis.external_set_position = axis.set_position
            return commands.start_external_setpoint(axis, dice.choice([1, 2]), first)
        case 1:
            return commands.stop_external_setpoint(axis)
        case 2:
            return commands.start_reversing(axis, 1, first, second, 5.0, dice.choice([0.0, 0.02]))
        case 3:
            return commands.start_velocity_steps(axis, 1, 0.1 * first, 0.1 * second, 0.03, 0.01, 3)
        case 4:
            return commands.start_sine_oscillation(
                axis, 1, 2.0, 1.7, dice.choice([0.0, 0.01]), 1.0, 1.0, 30.0, 0.1, 4, 1
            )
        case 5:
            return commands.start_drive_output(axis, 1, 0.1 * first)
        case 6:
            return commands.stop_drive_output(axis)
        case 7:
            return commands.set_drive_operation_mode(axis, dice.choice([0, 1, 2, 4, 17, 18, 20]))
        case _:
            return commands.start_torque_control(
                axis, dice.choice([0x3001, 0x3002]), 0, 0, 0, first, dice.choice([0.0, 500.0]),
                abs(second), -abs(second), dice.choice([0.0, 300.0]), 0.0, 0.0,
            )  # fmt: skip


def _look(axis: Axis, dice: random.Random) -> int:
    """A random command to the encoder and its latches."""
    unit, edge = dice.randrange(1, 5), dice.randrange(2)
    match dice.randrange(10):
        case 0 | 1 | 2:
            axis.encoder.reference_mode = dice.randrange(1, 8)
            axis.encoder.homing_cam_search_inverse = dice.randrange(2)
            axis.machine.cam_end = dice.uniform(-50.0, 50.0)
            axis.machine.cam_begin = axis.machine.cam_end - dice.choice([1.0, 1e6])
            return commands.home(axis)
        case 3 | 4:
            axis.machine.cam_input, axis.machine.mark_input = 1, dice.randrange(3)
            source = dice.choice([0, 1, 2, 128, 129])
            return commands.activate_touch_probe(axis, unit, edge, dice.randrange(1, 3), source)
        case 5:
            return commands.deactivate_touch_probe(axis, unit, edge)
        case 6:
            axis.machine.drive_inputs = dice.randrange(16)
        case 7:
            way = dice.uniform(-30.0, 30.0)
            return dice.choice(
                [
                    commands.set_actual_position_on_the_fly(axis, 2, edge, way),
                    commands.set_actual_position_only(axis, 2, 0.01 * way),
                    commands.set_actual_position_in_drive(axis, 2, way),
                ]
            )
        case 8:
            factor = axis.encoder.scaling_factor * dice.choice([0.999, 1.001])
            return commands.set_encoder_scaling_factor(axis, 2, 0, factor)
        case _:
            loop = dice.randrange(control_loop_count(axis))
            return commands.reinitialize_encoder(axis) + commands.switch_control_loop(
                axis, loop, dice.randrange(1, 4), dice.uniform(-5.0, 5.0)
            )
    return 0


def _act(axis: Axis, dice: random.Random) -> int:
    """One random command or change; its answer."""
    position = dice.uniform(-900.0, 900.0)
    velocity = 10 ** dice.uniform(-1, 4)
    dynamics: Any = [dice.choice([0.0, 10 ** dice.uniform(2, 5)]) for _ in range(3)]
    acceleration, deceleration, jerk = dynamics
    kind = dice.choice([1, 2, 3, 4, 5, 261, 517, 773, 4096, 8192])
    match dice.randrange(16):
        case 0 | 1 | 2 | 3:
            mode = dice.choice([0, 0, 1, 18, 19, 20, 21])
            if kind > 5:
                position = abs(position) % axis.encoder.modulo_factor
            return commands.universal_start(
                *(axis, kind, position, velocity, acceleration, deceleration, jerk, mode)
            )
        case 4:
            return commands.start(axis, kind, position, velocity)
        case 5:
            return commands.new_end_position_and_velocity(
                axis,
                dice.choice([1, 2, 3, 9, 10, 11]),
                dice.choice([1, 2, 3, 5]),
                position,
                velocity,
                axis.set_position + dice.uniform(-50.0, 50.0),
            )
        case 6:
            return dice.choice(
                [
                    commands.stop(axis),
                    commands.emergency_stop(axis, *dynamics[:2]),
                    commands.parameterized_stop(axis, *dynamics[:2]),
                    commands.new_dynamics(axis, *dynamics),
                ]
            )
        case 7:
            axis.velocity_override = dice.choice([0, 1, 333_333, FULL, FULL + 1])
        case 8:
            axis.control_dword = dice.choice([7, 7, 7, 7, 3, 5, 0])
        case 9:
            axis.machine.blocked = dice.random() < 0.1
        case 10:
            return commands.set_actual_position(axis, dice.choice([1, 2, 5]), position)
        case 11:
            return _generate(axis, dice)
        case 13 | 14:
            return _look(axis, dice)
        case 12:
            axis.external_set_position = axis.set_position + dice.uniform(-0.05, 0.05)
            axis.external_set_velocity = dice.uniform(-50.0, 50.0)
            axis.setpoint_consistency_check = dice.randrange(2)
            axis.allow_motion_commands_with_external_setpoint = dice.randrange(2)
        case _:
            axis.control_dword = 7
            axis.machine.blocked = 0
            return commands.reset(axis) + commands.release_lock(axis)
    return 0


@pytest.mark.parametrize("axes", [_axes, _kinds])
def test_both_kernels_give_bit_identical_states(axes: Any, many: Callable[[int], int]) -> None:
    for seed in range(many(1)):
        _compare_kernels(seed, axes)


def _compare_kernels(seed: int, axes: Any) -> None:
    sides = [
        (Nc(2_000_000, axes(dice), compiled=compiled), dice)
        for compiled, dice in ((False, random.Random(seed)), (True, random.Random(seed)))
    ]
    errors = 0
    for _ in range(250):
        outcome: list[Any] = []
        for nc, dice in sides:
            answers = [_act(nc.axis(dice.randrange(1, 6)), dice) for _ in range(3)]
            for _ in range(dice.randrange(1, 20)):
                nc.cycle()
            outcome.append((answers, nc.digest()))
        assert outcome[0] == outcome[1]
        errors += any(axis.error_code for axis in sides[0][0])
    assert errors > (2 if axes is _axes else 0)
    assert min(axis.command_counter for axis in sides[0][0]) > 5


def test_an_idle_axis_comes_to_rest_and_still_counts(rig: Any) -> None:
    commands.start(rig.axis, 1, 10.0, 100.0)
    rig.until(lambda axis: axis.resting == 1, 10.0)
    counted, digest = rig.axis.set_cycle_counter, rig.axis.pack()
    rig.run(100)
    assert rig.axis.set_cycle_counter == counted + 100
    assert commands.start(rig.axis, 1, 20.0, 100.0) == 0
    assert rig.axis.resting == 0
    rig.until_rest()
    assert rig.axis.set_position == 20.0
    assert digest != rig.axis.pack()


def test_rest_changes_nothing(make_rig: Any) -> None:
    resting, awake = make_rig(compiled=False), make_rig(compiled=False)
    for rig in (resting, awake):
        commands.start(rig.axis, 1, 33.3, 200.0)
        rig.seconds(6.0)
    assert resting.axis.resting == 1
    for _ in range(200):
        awake.axis.resting = 0
        awake.run(1)
        resting.run(1)
    awake.axis.resting = 1
    awake.axis.quiet_cycles = resting.axis.quiet_cycles
    awake.axis._record.resting = 1
    assert awake.axis.pack() == resting.axis.pack()


def test_an_axis_that_was_never_enabled_rests_too(make_rig: Any) -> None:
    rig = make_rig(control_dword=0)
    rig.run(100)
    assert rig.axis.resting == 1
    rig.axis.control_dword = 7
    rig.run(1)
    assert rig.axis.loop_closed == 1


def test_a_second_encoder_sees_every_step_of_a_stepper() -> None:
    """Also where the frequency changes between two steps."""
    values = {
        "control_dword": 7,
        "velocity_override": 1_000_000,
        "axis_type": 3,
        "drive_type": 8,
        "controller_following_error_position_monitoring_enable": 0,
    }
    nc = Nc(
        2_000_000,
        [
            AxisParameters(
                1, values=values, encoder_ids=(1, 2), elements=[{"encoder_scaling_factor": 1e-3}]
            )
        ],
        compiled=False,
    )
    axis = nc.axis(1)
    for target, velocity in [(30.0, 25.0), (-11.0, 7.0), (13.0, 60.0), (2.0, 3.0)]:
        assert commands.universal_start(axis, 1, target, velocity) == 0
        for _ in range(700):
            nc.cycle()
            assert axis.encoders[1].actual_position == pytest.approx(axis.actual_position)


def _delayed_error(dice: random.Random) -> tuple[dict[str, float], Callable[[Axis], None]]:
    """A following error, which is an error only some time after it was seen."""
    values = {
        "error_reaction_mode": 1.0,
        "error_reaction_delay": dice.uniform(0.01, 0.2),
        "controller_following_error_position_max": 10 ** dice.uniform(-4, -2),
        "controller_following_error_position_filter_time": dice.choice([0.0, 0.02]),
    }
    return values, lambda _: None


def _output_limit(dice: random.Random) -> tuple[dict[str, float], Callable[[Axis], None]]:
    """The output comes to a limit, the upper or the lower one as the move goes."""
    limit = dice.uniform(0.001, 0.01)
    values = {
        "drive_output_limit_max": limit,
        "drive_output_limit_min": -limit,
        "controller_following_error_position_monitoring_enable": 0.0,
    }
    return values, lambda _: None


def _invalid_data(dice: random.Random) -> tuple[dict[str, float], Callable[[Axis], None]]:
    """I/O data become invalid."""

    def fall_out(axis: Axis) -> None:
        axis.machine.io_invalid = 1  # of the machine: nobody writes to the axis

    return {"simulation_dead_time": dice.choice([0.0, 0.01])}, fall_out


def _feed_enable(dice: random.Random) -> tuple[dict[str, float], Callable[[Axis], None]]:
    """The axis turns back without the feed enable of that direction: it stops."""

    def turn(axis: Axis) -> None:
        ahead = axis.set_velocity > 0.0
        assert commands.universal_start(axis, 1, -1e4 if ahead else 1e4, velocity) == 0
        axis.control_dword = 3 if ahead else 5

    velocity = dice.uniform(20.0, 100.0)
    return {}, turn


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("event", [_delayed_error, _output_limit, _invalid_data, _feed_enable])
@pytest.mark.parametrize("way", [1, -1])
def test_what_begins_within_a_plain_move_ends_its_short_way(
    same_both_ways: Callable[[Nc, Nc, int], list[bool]],
    event: Callable[[random.Random], tuple[dict[str, float], Callable[[Axis], None]]],
    seed: int,
    way: int,
) -> None:
    """Each of these has to be looked for from the cycle on in which it begins by itself."""
    dice = random.Random(f"{event.__name__} {seed} {way}")
    values, happen = event(dice)
    velocity = dice.uniform(20.0, 100.0)
    values = {
        "control_dword": 7.0,
        "velocity_override": float(FULL),
        "max_velocity": 200.0,
        "encoder_soft_limit_min_enable": 0.0,
        "encoder_soft_limit_max_enable": 0.0,
        **values,
    }
    both = [Nc(2_000_000, [AxisParameters(1, values=values)], compiled=True) for _ in "12"]
    short, long = both
    same_both_ways(short, long, 3)
    for nc in both:
        assert commands.start(nc.axis(1), 1, way * 1000.0, velocity) == 0
    plain = same_both_ways(short, long, dice.randrange(150, 250))
    assert any(plain)
    for nc in both:
        happen(nc.axis(1))
    same_both_ways(short, long, 400)
