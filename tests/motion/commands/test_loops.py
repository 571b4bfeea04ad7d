"""Switching of control loops: abrupt, or without a step in the output."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import Axis, AxisParameters, MotionPhase, Nc, commands

STANDARD, INTERNAL, PARAMETER = 1, 2, 3

P = {"controller_position_kv": 10.0, "encoder_scaling_factor": 0.001}
PID = {**P, "controller_type": 3, "controller_position_tn": 0.5, "controller_position_i_limit": 1.0}
PI_VELOCITY = {
    **P, "controller_type": 6, "controller_velocity_kp": 0.5, "controller_velocity_tn": 0.1,
    "controller_velocity_i_limit": 1.0,
}  # fmt: skip


@pytest.fixture(params=[False, True], ids=["plain", "compiled"])
def make(request: pytest.FixtureRequest) -> Any:
    def nc(second: dict[str, float]) -> Nc:
        result = Nc(
            2_000_000,
            [
                AxisParameters(
                    1,
                    values={
                        "control_dword": 7, "velocity_override": 1_000_000,
                        "controller_velocity_feedforward_weight": 0.9,
                        "simulation_time_constant": 0.0,
                    },
                    encoder_ids=(1, 2), controller_ids=(1, 2),
                    elements=[{"encoder_position_offset": 100.0, **second}],
                )
            ],
            compiled=request.param,
        )  # fmt: skip
        run(result, 5)
        return result

    return nc


def run(nc: Nc, cycles: int) -> None:
    for _ in range(cycles):
        nc.cycle()


def moving(nc: Nc) -> Axis:
    """The axis in the middle of a move at 50 mm/s; its following error is (1 - 0.9) v / Kv."""
    axis = nc.axis(1)
    assert commands.start(axis, 1, 200.0, 50.0) == 0
    run(nc, 1000)
    assert axis.set_velocity == pytest.approx(50.0)
    assert axis.following_error == pytest.approx(0.1 * 50.0 / 20.0, abs=0.01)
    return axis


def test_the_standard_switch_is_like_a_reset(make: Any) -> None:
    nc = make(P)
    axis = moving(nc)
    assert commands.switch_control_loop(axis, 1, STANDARD, 0.0) == 0
    assert axis.active_control_loop == 1
    assert axis.set_motion_phase == MotionPhase.NONE
    assert axis.set_position == axis.target_position == axis.actual_position
    run(nc, 500)
    assert axis.controller.position_kv == 10.0
    assert axis.actual_position == pytest.approx(axis.set_position, abs=0.002)
    assert axis.error_code == 0


@pytest.mark.parametrize("second", [P, PID, PI_VELOCITY], ids=["P", "PID", "PI velocity"])
def test_the_output_has_no_step(make: Any, second: dict[str, float]) -> None:
    nc = make(second)
    axis = moving(nc)
    before, target, place = axis.drive.output, axis.target_position, axis.actual_position
    assert commands.switch_control_loop(axis, 1, INTERNAL, 0.0) == 0
    shift = axis.actual_position - place
    assert shift == pytest.approx(100.0, abs=0.1)
    run(nc, 1)
    assert axis.drive.output == pytest.approx(before, abs=0.2)
    assert axis.set_velocity == pytest.approx(50.0)
    end = axis.target_position
    assert end == pytest.approx(target + shift, abs=0.5)
    run(nc, 4000)
    assert axis.set_position == pytest.approx(end, abs=1e-9)
    assert axis.actual_position == pytest.approx(end, abs=0.01)
    assert axis.error_code == 0


@pytest.mark.parametrize(
    ("second", "part"),
    [(P, "controller_position_p_part"), (PID, "controller_position_i_part")],
    ids=["P", "PID"],
)
def test_the_output_begins_with_the_value_given(make: Any, second: Any, part: str) -> None:
    nc = make(second)
    axis = nc.axis(1)
    assert commands.switch_control_loop(axis, 1, PARAMETER, 8.0) == 0
    run(nc, 1)
    assert axis.drive.output == pytest.approx(8.0, abs=0.05)
    assert getattr(axis, part) == pytest.approx(8.0, abs=0.05)


def test_a_position_loop_in_the_drive_keeps_the_following_error(make: Any) -> None:
    nc = make({**P, "controller_type": 9})
    axis = moving(nc)
    error = axis.set_position - axis.actual_position
    commands.switch_control_loop(axis, 1, INTERNAL, 0.0)
    assert axis.set_position - axis.actual_position == pytest.approx(error)


def test_there_and_back(make: Any) -> None:
    nc = make(P)
    axis = moving(nc)
    commands.switch_control_loop(axis, 1, INTERNAL, 0.0)
    run(nc, 20)
    commands.switch_control_loop(axis, 0, INTERNAL, 0.0)
    run(nc, 4000)
    assert axis.active_control_loop == 0
    assert axis.actual_position == pytest.approx(200.0, abs=1.0)
    assert axis.set_position == pytest.approx(axis.actual_position, abs=1e-3)


def test_an_open_loop_just_changes(make: Any) -> None:
    nc = make(P)
    axis = nc.axis(1)
    axis.control_dword = 0
    run(nc, 2)
    for kind in (INTERNAL, PARAMETER, STANDARD):
        assert commands.switch_control_loop(axis, 1 - axis.active_control_loop, kind, 0.0) == 0
        run(nc, 2)
        assert axis.set_position == axis.actual_position


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((2, STANDARD, 0.0), NcError.REQUEST_PARAMETER),
        ((1, 0, 0.0), NcError.FUNCTION_TYPE),
        ((1, 4, 0.0), NcError.FUNCTION_TYPE),
        ((1, PARAMETER, 1e6), NcError.REQUEST_PARAMETER),
        ((1, PARAMETER, float("nan")), NcError.REQUEST_PARAMETER),
        ((1, PARAMETER, 0.0, 2), NcError.REQUEST_PARAMETER),
    ],
)
def test_what_is_no_switch(make: Any, arguments: Any, error: NcError) -> None:
    nc = make(P)
    before = nc.digest()
    assert NcError.of(commands.switch_control_loop(nc.axis(1), *arguments)) is error
    assert nc.digest() == before


def test_homing_is_given_up_by_the_standard_switch_alone(make: Any) -> None:
    nc = make(P)
    axis = nc.axis(1)
    commands.home(axis)
    run(nc, 100)
    assert commands.switch_control_loop(axis, 1, INTERNAL, 0.0) == NcError.GROUP_BUSY.number
    assert commands.switch_control_loop(axis, 1, STANDARD, 0.0) == 0
    assert axis.homing_state == 0


def test_the_homed_flag_and_the_probes_belong_to_the_encoder(make: Any) -> None:
    nc = make(P)
    axis = nc.axis(1)
    commands.set_homed_flag(axis, 1)
    commands.activate_touch_probe(axis, 1, 0, 1, 1)
    commands.switch_control_loop(axis, 1, STANDARD, 0.0)
    assert (axis.homed, axis.encoder.latch_active) == (0, 0)
    commands.switch_control_loop(axis, 0, STANDARD, 0.0)
    assert (axis.homed, axis.encoder.latch_active) == (1, 1)
