"""Two-speed axes and stepper motors: phases, control bytes, brake, whole steps."""

from itertools import pairwise
from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.axis import CommandState
from achse.codes.nc.choices import AxisType, ControllerType, DriveType, StepperMode
from achse.motion import MotionPhase, StateBit, commands

MINUS_HIGH, MINUS_LOW, PLUS_LOW, PLUS_HIGH, BRAKE_OPEN, BRAKE = 1, 2, 4, 8, 64, 128
RAPID, CREEP = 200.0, 20.0


@pytest.fixture
def two_speeds(make_rig: Any) -> Any:
    """Rapid 200 mm/s, creep 20 mm/s, no lag: the motor moves as it is switched."""
    return make_rig(
        axis_type=AxisType.DISCRETE_RAPID_CREEP,
        drive_type=DriveType.RAPID_CREEP,
        controller_type=ControllerType.RAPID_CREEP_POSITION,
        drive_reference_velocity=RAPID,
        simulation_creep_velocity=CREEP / RAPID,
        simulation_time_constant=0.0,
        creep_distance_positive=10.0,
        creep_distance_negative=10.0,
        brake_distance_positive=1.0,
        brake_distance_negative=2.0,
        brake_delay_positive=0.1,
        brake_release_delay=0.05,
        rapid_to_creep_switch_time=0.04,
        target_position_window=3.0,
    )


def phases(rig: Any, seconds: float) -> list[tuple[int, int, int]]:
    """Control byte, AxisState and duration in cycles of each phase."""
    seen: list[list[int]] = []
    for _ in range(round(seconds / rig.dt)):
        rig.run(1)
        now = [rig.axis.drive.control_byte, rig.axis.motion_state]
        if seen and seen[-1][:2] == now:
            seen[-1][2] += 1
        else:
            seen.append([*now, 1])
    return [(byte, state, count) for byte, state, count in seen]


def test_a_movement_passes_its_phases(two_speeds: Any) -> None:
    rig = two_speeds
    assert rig.axis.drive.control_byte == BRAKE
    assert commands.start(rig.axis, 1, 100.0, 100.0) == 0
    released, rapid, switching, near, braking, braked = phases(rig, 3.0)
    assert released[:2] == (BRAKE_OPEN, 1)
    assert released[2] == pytest.approx(0.05 / rig.dt, abs=1)
    assert rapid[:2] == (BRAKE_OPEN | PLUS_HIGH, 1)
    assert rapid[2] == pytest.approx((100.0 - 10.0) / RAPID / rig.dt, abs=2)
    assert switching[:2] == (BRAKE_OPEN, 2)
    assert switching[2] == pytest.approx(0.04 / rig.dt, abs=1)
    assert near[:2] == (BRAKE_OPEN | PLUS_LOW, 3)
    assert near[2] == pytest.approx((10.0 - 1.0) / CREEP / rig.dt, abs=15)
    assert braking[:2] == (BRAKE_OPEN, 4)
    assert braking[2] == pytest.approx(0.1 / rig.dt, abs=1)
    assert braked[:2] == (BRAKE, 0)
    assert rig.axis.actual_position == pytest.approx(99.0, abs=CREEP * 2 * rig.dt)
    assert rig.axis.set_position == rig.axis.actual_position
    assert rig.has(StateBit.NOT_MOVING)
    assert rig.has(StateBit.IN_TARGET_POSITION)
    assert not rig.has(StateBit.HAS_JOB)


def test_backwards_and_slowly(two_speeds: Any) -> None:
    rig = two_speeds
    assert commands.start(rig.axis, 1, -30.0, 50.0) == 0
    _, main, near, *_ = phases(rig, 3.0)
    assert main[:2] == (BRAKE_OPEN | MINUS_LOW, 1)
    assert main[2] == pytest.approx(20.0 / CREEP / rig.dt, abs=2)
    assert near[:2] == (BRAKE_OPEN | MINUS_LOW, 3)
    assert rig.axis.actual_position == pytest.approx(-28.0, abs=CREEP * 2 * rig.dt)


def test_the_extended_byte_has_direction_and_speed_apart(two_speeds: Any) -> None:
    rig = two_speeds
    commands.start(rig.axis, 4, 0.0, 100.0)
    rig.seconds(0.5)
    assert rig.axis.drive.extended_control_byte == BRAKE_OPEN | 1 | 8
    assert rig.axis.actual_velocity == pytest.approx(-RAPID, rel=1e-6)
    rig.axis.velocity_override = 500_000
    rig.run(1)
    assert rig.axis.drive.extended_control_byte == BRAKE_OPEN | 1 | 4


def test_the_override_chooses_the_speed_in_the_main_phase_only(two_speeds: Any) -> None:
    rig = two_speeds
    commands.start(rig.axis, 1, 100.0, 100.0)
    rig.seconds(0.2)
    for override, byte in (
        (500_001, BRAKE_OPEN | PLUS_HIGH),
        (500_000, BRAKE_OPEN | PLUS_LOW),
        (100, BRAKE_OPEN | PLUS_LOW),
        (99, BRAKE),
    ):
        rig.axis.velocity_override = override
        rig.seconds(0.1)
        assert rig.axis.drive.control_byte == byte, override
    stood = rig.axis.actual_position
    rig.seconds(1.0)
    assert rig.axis.actual_position == stood
    assert rig.has(StateBit.HAS_JOB)
    rig.axis.velocity_override = 1_000_000
    rig.until(lambda axis: axis.motion_state == 4)
    rig.axis.velocity_override = 0
    rig.until(lambda axis: axis.drive.control_byte == BRAKE, 0.2)
    assert not rig.has(StateBit.HAS_JOB) or rig.axis.set_motion_phase == 0


def test_a_distance_within_the_braking_distance_is_refused(two_speeds: Any) -> None:
    two_speeds.refuses(NcError.DISTANCE_BELOW_BRAKING_DISTANCE, commands.start, 1, 1.0, 100.0)
    two_speeds.refuses(NcError.DISTANCE_BELOW_BRAKING_DISTANCE, commands.start, 1, -2.0, 100.0)
    assert commands.start(two_speeds.axis, 1, 1.1, 100.0) == 0


def test_a_stop_creeps_its_distance_and_brakes(make_rig: Any, two_speeds: Any) -> None:
    rig = two_speeds
    rig.axis.creep_distance_stop = 5.0
    commands.start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(0.5)
    commands.stop(rig.axis)
    rig.run(1)
    begin = rig.axis.actual_position
    rig.run(1)
    assert rig.axis.drive.control_byte == BRAKE_OPEN | PLUS_LOW
    rig.until_rest()
    assert rig.axis.drive.control_byte == BRAKE
    assert rig.axis.actual_position - begin == pytest.approx(5.0, abs=4 * RAPID * rig.dt)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)


def test_without_enable_the_brake_holds(two_speeds: Any) -> None:
    rig = two_speeds
    commands.start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(0.3)
    rig.axis.control_dword = 0
    rig.seconds(0.1 + 0.1)
    assert rig.axis.drive.control_byte == BRAKE
    assert rig.axis.machine.velocity == 0.0
    assert rig.axis.error_code == 0x4260


STEP = 0.05


@pytest.fixture
def stepper(make_rig: Any) -> Any:
    return lambda **values: make_rig(
        axis_type=AxisType.CONTINUOUS_STEPPER,
        drive_type=DriveType.STEPPER,
        controller_type=ControllerType.STEPPER_POSITION,
        stepper_step_scaling=STEP,
        stepper_min_velocity=1.0,
        max_velocity=STEP / 0.002,
        default_acceleration=100.0,
        default_deceleration=100.0,
        default_jerk=1000.0,
        controller_following_error_position_monitoring_enable=0,
        **values,
    )


def test_a_stepper_arrives_by_whole_steps(stepper: Any) -> None:
    rig = stepper()
    commands.start(rig.axis, 1, 10.0, 20.0)
    steps = {rig.axis.drive.stepper_step}
    while rig.axis.set_motion_phase or rig.axis.set_position == 0.0:
        rig.run(1)
        steps.add(rig.axis.drive.stepper_step)
        assert rig.axis.machine.position == pytest.approx(rig.axis.drive.stepper_step * STEP)
    rig.seconds(2.0)
    assert rig.axis.drive.stepper_step == round(10.0 / STEP)
    assert steps == set(range(max(steps) + 1))
    assert rig.axis.actual_position == pytest.approx(10.0, abs=1e-9)


@pytest.mark.parametrize("gain", [2.0, 20.0])
@pytest.mark.parametrize("target", [10.0, -9.95, 0.05])
def test_no_step_is_missing_at_the_target(stepper: Any, gain: float, target: float) -> None:
    """The controller asks for less than the minimum velocity for the last steps."""
    rig = stepper(controller_position_kv=gain)
    commands.start(rig.axis, 1, target, 20.0)
    rig.seconds(4.0)
    step = rig.axis.drive.stepper_step
    assert step == round(target / STEP)
    rig.seconds(1.0)
    assert rig.axis.drive.stepper_step == step


@pytest.mark.parametrize(("mode", "cycles"), [(1, 4), (2, 6)])
def test_the_masks_follow_the_steps(stepper: Any, mode: int, cycles: int) -> None:
    masks = {f"drive_stepper_mask_cycle{n}": n for n in range(1, 9)}
    rig = stepper(stepper_operation_mode=mode, drive_stepper_mask_holding_current=0x10, **masks)
    rig.run(2)
    assert rig.axis.drive.control_byte == 1 | 0x10
    commands.start(rig.axis, 3, 0.0, 10.0)
    rig.until(lambda axis: axis.drive.stepper_step > 20)
    for _ in range(100):
        rig.run(1)
        assert rig.axis.drive.control_byte == 1 + rig.axis.drive.stepper_step % cycles


def test_a_power_section_gets_frequency_and_direction(stepper: Any) -> None:
    rig = stepper(stepper_operation_mode=StepperMode.POWER_SECTION)
    for start, forward in ((3, 2), (4, 0)):
        commands.universal_start(rig.axis, start, 0.0, 10.0)
        rig.seconds(2.0)
        assert rig.axis.drive.control_byte == 0
        assert rig.axis.drive.extended_control_byte == rig.axis.drive.stepper_step % 2 | forward


def test_the_frequency_is_that_of_the_velocity(stepper: Any) -> None:
    rig = stepper(controller_position_kv=0.0)
    commands.start(rig.axis, 3, 0.0, 5.0)  # a step in five cycles
    rig.until(lambda axis: axis.set_velocity == 5.0)
    rig.run(10)
    before = rig.axis.drive.stepper_step
    rig.run(500)
    assert rig.axis.drive.stepper_step - before == pytest.approx(100, abs=1)
    assert rig.axis.drive.stepper_level == 5


def test_never_below_the_minimum_velocity(stepper: Any) -> None:
    rig = stepper(controller_position_kv=0.0)
    commands.start(rig.axis, 3, 0.0, 0.6)
    rig.seconds(1.0)
    assert rig.axis.drive.stepper_level == round(STEP / 1.0 / rig.dt)
    rig = stepper(controller_position_kv=0.0)
    commands.start(rig.axis, 3, 0.0, 0.4)
    rig.seconds(1.0)
    assert rig.axis.drive.stepper_level == 0
    assert rig.axis.drive.stepper_step == 0


def test_a_level_lasts_its_steps(stepper: Any) -> None:
    rig = stepper(stepper_steps_per_velocity_level=8, controller_position_kv=0.0)
    commands.start(rig.axis, 3, 0.0, 20.0)
    levels: list[tuple[int, int]] = []
    rig.until(lambda axis: axis.drive.stepper_level > 0)
    for cycle in range(2000):
        if cycle % 300 == 0:
            rig.axis.velocity_override = 1_000_000 if cycle % 600 else 400_000
        if not levels or levels[-1][0] != rig.axis.drive.stepper_level:
            levels.append((rig.axis.drive.stepper_level, rig.axis.drive.stepper_step))
        rig.run(1)
    steps = [after - before for (_, before), (_, after) in pairwise(levels)]
    assert len(steps) >= 2
    assert min(steps) >= 8


def test_a_loop_of_two_speeds_comes_back_to_its_target(two_speeds: Any) -> None:
    rig = two_speeds
    rig.axis.loop_enable = 1
    rig.axis.loop_distance = 20.0
    assert commands.start(rig.axis, 1, 100.0, 100.0) == 0
    farthest = 0.0
    while rig.axis.set_motion_phase or rig.axis.set_cycle_counter < 10:
        rig.run(1)
        farthest = max(farthest, rig.axis.actual_position)
    # it brakes at once where braking begins: 1 mm before in positive, 2 mm in negative direction
    assert farthest == pytest.approx(119.0, abs=CREEP * rig.dt * 1.01)
    assert rig.axis.actual_position == pytest.approx(102.0, abs=CREEP * rig.dt * 1.01)
    assert rig.axis.target_position == 100.0
    assert commands.start(rig.axis, 1, 50.0, 100.0) == 0
    rig.until_rest()
    assert rig.axis.actual_position == pytest.approx(52.0, abs=CREEP * rig.dt * 1.01)


def test_the_loop_of_two_speeds_is_longer_than_its_braking(two_speeds: Any) -> None:
    rig = two_speeds
    rig.axis.loop_enable = 1
    rig.axis.loop_distance = 2.0
    rig.refuses(NcError.LOOP_BELOW_BRAKING_DISTANCE, commands.start, 1, 100.0, 100.0)
    assert commands.start(rig.axis, 1, -100.0, 100.0) == 0


def test_a_stop_ends_the_loop_of_two_speeds(two_speeds: Any) -> None:
    rig = two_speeds
    rig.axis.loop_enable = 1
    rig.axis.loop_distance = 20.0
    commands.start(rig.axis, 1, 100.0, 100.0)
    rig.seconds(0.3)
    commands.stop(rig.axis)
    rig.until_rest()
    assert rig.axis.actual_position < 100.0
    rig.seconds(1.0)
    assert rig.axis.drive.control_byte == BRAKE


@pytest.mark.parametrize(
    ("percent", "control", "speed"),
    [(60.0, 0x48, 1.0), (50.0, 0x44, 0.1), (-60.0, 0x41, -1.0), (-1.0, 0x42, -0.1)],
)
def test_a_direct_output_switches_the_speed(
    make_rig: Any, percent: float, control: int, speed: float
) -> None:
    rig = make_rig(axis_type=2, drive_type=7)
    axis = rig.axis
    assert commands.start_drive_output(axis, 1, percent) == 0
    rig.seconds(0.2)
    assert axis.drive.control_byte == control
    assert axis.machine.velocity == pytest.approx(speed * axis.drive.full)
    assert commands.change_drive_output(axis, 1, 0.0) == 0
    rig.run(1)
    assert (axis.drive.control_byte, axis.machine.velocity) == (0x80, 0.0)
    assert commands.stop_drive_output(axis) == 0
    rig.run(2)
    assert axis.set_motion_phase == MotionPhase.NONE


def test_a_released_brake_lets_the_motor_run_out(make_rig: Any) -> None:
    rig = make_rig(axis_type=2, drive_type=7, simulation_time_constant=0.1)
    commands.start_drive_output(rig.axis, 1, 60.0)
    rig.seconds(0.5)
    commands.release_brake(rig.axis, 1)
    commands.change_drive_output(rig.axis, 1, 0.0)
    before = rig.axis.machine.velocity
    rig.run(1)
    assert rig.axis.machine.velocity == pytest.approx(before * (1.0 - rig.dt / (0.1 + rig.dt)))


def test_commands_wait_for_those_before(two_speeds: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    for target in (100.0, 50.0, 150.0):
        assert commands.universal_start(axis, 1, target, 100.0, buffer_mode=1) == 0
    for number, stands in ((1, 99.0), (2, 52.0), (3, 149.0)):
        assert axis.set_command_number == number
        rig.until(lambda axis: axis.set_motion_phase == MotionPhase.NONE)
        assert axis.set_command_state == CommandState.DONE
        assert axis.actual_position == pytest.approx(stands, abs=CREEP * 2 * rig.dt)
        rig.run(1)


def test_a_command_that_waits_takes_over_from_an_endless_one(two_speeds: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    commands.universal_start(axis, 3, 0.0, 100.0)
    commands.universal_start(axis, 1, -50.0, 100.0, buffer_mode=1)
    rig.until_rest()
    assert axis.actual_position == pytest.approx(-48.0, abs=CREEP * 2 * rig.dt)
    assert axis.set_command_number == 2


@pytest.mark.parametrize(("start_type", "target"), [(1, 200.0), (3, 0.0), (1, 50.0)])
def test_a_start_while_the_axis_runs_out_is_carried_out(
    two_speeds: Any, start_type: int, target: float
) -> None:
    rig, axis = two_speeds, two_speeds.axis
    commands.start(axis, 1, 100.0, 100.0)
    rig.until(lambda axis: axis.motion_state == 4)
    assert commands.universal_start(axis, start_type, target, 100.0) == 0
    if start_type == 3:
        rig.seconds(2.0)
        assert axis.actual_velocity == pytest.approx(RAPID)
        return
    rig.until_rest()
    assert axis.actual_position == pytest.approx(target, abs=2.0 + CREEP * 2 * rig.dt)
    assert axis.set_command_state == CommandState.DONE


def test_a_halt_is_done_and_a_stop_aborts(two_speeds: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    for state in (CommandState.DONE, CommandState.ABORTED):
        commands.start(axis, 3, 0.0, 100.0)
        rig.seconds(0.5)
        if state == CommandState.DONE:
            commands.universal_start(axis, 8192, 0.0, 0.0)
        else:
            commands.stop(axis)
        rig.until_rest()
        assert axis.set_command_state == state


def test_the_speed_changes_at_the_switch_position(two_speeds: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    assert commands.start_special(axis, 1, 100.0, 100.0, 60.0, 50.0) == 0
    rig.until(lambda axis: axis.set_velocity == CREEP)
    assert 60.0 <= axis.actual_position < 60.0 + 3 * RAPID * rig.dt
    rig.until_rest()
    assert axis.actual_position == pytest.approx(99.0, abs=CREEP * 2 * rig.dt)


def test_renaming_positions_does_not_shorten_a_stop(two_speeds: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    axis.creep_distance_stop = 5.0
    commands.start(axis, 3, 0.0, 100.0)
    rig.seconds(0.5)
    begin = axis.actual_position
    commands.stop(axis)
    rig.run(5)
    commands.set_actual_position_on_the_fly(axis, 2, 0, 1000.0)
    rig.until(lambda axis: axis.motion_state == 4)
    assert axis.actual_position - begin - 1000.0 >= 5.0


def test_phasing_at_two_speeds(two_speeds: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    assert commands.start_phasing(axis, 1, 0, 0, 10.0, 50.0) == 0
    rig.until(lambda axis: axis.phasing_active == 0)
    assert axis.phasing_position == 10.0


@pytest.mark.parametrize(
    "dropped", [commands.reset, lambda axis: commands.switch_control_loop(axis, 0, 1, 0.0)]
)
def test_without_its_job_the_axis_is_braked_at_once(two_speeds: Any, dropped: Any) -> None:
    rig, axis = two_speeds, two_speeds.axis
    commands.start(axis, 3, 0.0, 100.0)
    rig.seconds(0.5)
    assert dropped(axis) == 0
    rig.run(1)
    stands = axis.actual_position
    rig.seconds(1.0)
    assert axis.actual_position == pytest.approx(stands, abs=RAPID * rig.dt)
    assert axis.drive.control_byte == BRAKE
    assert commands.start(axis, 4, 0.0, 100.0) == 0
