"""Special generators: what forbids each of them, and that a refusal changes nothing."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import CommandState, MotionPhase, StateBit, commands
from achse.motion.commands.special_generators.generators import begin_generator

SINE = (1, 10.0, 2.0, 0.0, 10.0, 20.0, 100.0, 2.0, 3, 1)

STARTS: dict[str, tuple[Callable[..., int], tuple[Any, ...]]] = {
    "external": (commands.start_external_setpoint, (1, 0.0)),
    "reversing": (commands.start_reversing, (1, 10.0, -10.0, 100.0, 0.1)),
    "steps": (commands.start_velocity_steps, (1, 10.0, -10.0, 0.1, 0.1, 0)),
    "sine": (commands.start_sine_oscillation, SINE),
    "output": (commands.start_drive_output, (1, 1.0)),
    "torque": (
        commands.start_torque_control,
        (0x3001, 0, 0, 0, 10.0, 0.0, 100.0, -100.0, 0.0, 0.0, 0.0),
    ),
}

every_start = pytest.mark.parametrize("name", STARTS)


@every_start
@pytest.mark.parametrize(
    ("values", "error"),
    [
        ({"control_dword": 6}, NcError.CONTROLLER_ENABLE_MISSING),
        ({"drive_output_disabled": 1}, NcError.CONTROLLER_ENABLE_MISSING),
        ({"axis_disabled": 1}, NcError.AXIS_NOT_READY),
        ({"simulation_not_ready": 1}, NcError.DRIVE_NOT_READY_AT_START),
        ({"axis_type": 2, "drive_type": 7}, NcError.GENERATOR_FUNCTION_MISSING),
    ],
)
def test_the_axis_must_be_ready(
    make_rig: Any, name: str, values: dict[str, float], error: NcError
) -> None:
    start, arguments = STARTS[name]
    if name == "output" and error is NcError.GENERATOR_FUNCTION_MISSING:
        return  # any axis has an output
    make_rig(**values).refuses(error, start, *arguments)


@every_start
def test_no_generator_in_error_or_lock(rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    commands.set_external_error(rig.axis, 0x4466)
    rig.run(2)
    error = NcError.of(0x4466)
    rig.refuses(error, start, *arguments)
    commands.reset(rig.axis)
    commands.universal_start(rig.axis, 4096, 0.0, 0.0)
    rig.run(2)
    rig.refuses(NcError.AXIS_LOCKED_BY_STOP, start, *arguments)


@every_start
def test_no_generator_besides_another(rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    commands.start_velocity_steps(rig.axis, 1, 10.0, -10.0, 0.1, 0.1, 0)
    rig.refuses(NcError.GROUP_BUSY, start, *arguments)


@every_start
def test_no_generator_besides_external_set_points(make_rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    rig = make_rig(allow_motion_commands_with_external_setpoint=1)
    commands.start_external_setpoint(rig.axis, 1, 0.0)
    rig.run(1)
    rig.refuses(NcError.EXTERNAL_GENERATOR_ACTIVE, start, *arguments)


@pytest.mark.parametrize("name", ["reversing", "steps", "sine"])
@pytest.mark.parametrize("control", [3, 5])
def test_what_moves_both_ways_needs_both_feed_enables(
    make_rig: Any, name: str, control: int
) -> None:
    start, arguments = STARTS[name]
    make_rig(control_dword=control).refuses(NcError.ENABLE_MISSING, start, *arguments)


@pytest.mark.parametrize("name", ["output", "torque"])
def test_what_moves_one_way_needs_its_feed_enable(make_rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    make_rig(control_dword=5).refuses(NcError.ENABLE_MISSING, start, *arguments)
    assert start(make_rig(control_dword=3).axis, *arguments) == 0


@every_start
def test_an_accepted_generator_is_the_active_command_at_once(rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    number = rig.axis.command_counter
    assert start(rig.axis, *arguments) == 0
    assert rig.axis.set_command_number == rig.axis.command_counter == number + 1
    assert rig.axis.set_command_state == CommandState.ACTIVE
    assert rig.has(StateBit.HAS_JOB)
    assert not rig.has(StateBit.NOT_MOVING)


@every_start
def test_commands_of_moves_do_not_fit_a_generator(rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    if name == "reversing":
        return  # is made of moves
    start(rig.axis, *arguments)
    rig.run(1)
    error = NcError.EXTERNAL_GENERATOR_ACTIVE if name == "external" else NcError.GROUP_BUSY
    rig.refuses(error, commands.new_end_position, 1, 10.0)
    rig.refuses(error, commands.start, 1, 10.0, 100.0)


@every_start
def test_reset_drops_it(rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    start(rig.axis, *arguments)
    rig.run(20)
    commands.reset(rig.axis)
    rig.run(1)
    assert rig.axis.set_motion_phase == MotionPhase.NONE
    assert rig.axis.set_velocity == pytest.approx(0.0, abs=200.0)
    rig.run(5)
    assert rig.axis.external_setpoint_active == 0


@every_start
def test_a_universal_start_takes_over(make_rig: Any, name: str) -> None:
    start, arguments = STARTS[name]
    rig = make_rig(controller_following_error_position_monitoring_enable=0)
    start(rig.axis, *arguments)
    rig.run(40)
    if name == "external":
        return  # refused, see the external tests
    before = rig.axis.set_velocity
    assert commands.universal_start(rig.axis, 1, 50.0, 100.0) == 0
    rig.run(1)
    change = rig.axis.default_jerk * rig.dt**2 + abs(rig.axis.set_acceleration) * rig.dt
    assert rig.axis.set_velocity == pytest.approx(before, abs=change + 0.02)
    rig.until_rest()
    assert rig.axis.set_position == 50.0
    assert rig.axis.error_code == 0


def test_a_generator_takes_the_dynamics_of_the_axis(make_rig: Any) -> None:
    rig = make_rig(default_deceleration=5000.0, max_deceleration=3000.0)
    begin_generator(rig.axis, MotionPhase.VELOCITY_STEPS)
    assert rig.axis.job.acceleration == rig.axis.default_acceleration
    assert rig.axis.job.deceleration == 3000.0
    assert rig.axis.job.jerk == rig.axis.default_jerk


@given(
    name=st.sampled_from(sorted(set(STARTS) - {"external"})),
    cycles=st.integers(0, 600),
    how=st.sampled_from(["stop", "halt", "clear", "move"]),
)
@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_whenever_it_ends_the_set_point_goes_on_smoothly(
    make_rig: Any, name: str, cycles: int, how: str
) -> None:
    rig = make_rig(controller_following_error_position_monitoring_enable=0, max_acceleration=1e6)
    start, arguments = STARTS[name]
    assert start(rig.axis, *arguments) == 0
    rig.run(cycles)
    ends: dict[str, Callable[[], int]] = {
        "stop": lambda: commands.stop(rig.axis),
        "halt": lambda: commands.universal_start(rig.axis, 8192, 0.0, 0.0),
        "clear": lambda: commands.clear(rig.axis),
        "move": lambda: commands.universal_start(rig.axis, 1, 30.0, 50.0),
    }
    before = rig.axis.set_velocity
    if name in ("output", "torque"):
        rig.run(1)
        before = rig.axis.set_velocity
    assert ends[how]() == 0
    for _ in range(6000):
        rig.run(1)
        axis = rig.axis
        most = max(axis.job.acceleration, axis.job.deceleration) + axis.job.jerk * rig.dt
        assert abs(axis.set_velocity - before) <= most * rig.dt + 1e-6
        before = axis.set_velocity
        if axis.set_motion_phase == MotionPhase.NONE:
            break
    assert axis.set_motion_phase == MotionPhase.NONE
    assert axis.error_code == 0
    if how == "move":
        assert axis.set_position == 30.0
