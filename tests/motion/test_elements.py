"""Control loops: an axis works with other parts of its own, the motor stays."""

import pytest

from achse.motion import AxisParameters, Nc, commands
from achse.motion.elements import choose_control_loop, control_loop_count


@pytest.fixture(params=[False, True], ids=["plain", "compiled"])
def nc(request: pytest.FixtureRequest) -> Nc:
    return Nc(
        2_000_000,
        [
            AxisParameters(
                1,
                values={
                    "control_dword": 7,
                    "velocity_override": 1_000_000,
                    "controller_position_kv": 10.0,
                    "drive_reference_velocity": 1000.0,
                },
                encoder_ids=(1, 2),
                controller_ids=(1, 2, 3),
                elements=[
                    {
                        "encoder_scaling_factor": 0.01,
                        "encoder_position_offset": 100.0,
                        "controller_position_kv": 30.0,
                        "drive_reference_velocity": 500.0,
                    }
                ],
            )
        ],
        compiled=request.param,
    )


def run(nc: Nc, cycles: int) -> None:
    for _ in range(cycles):
        nc.cycle()


def test_an_axis_works_with_other_parts_and_back(nc: Nc) -> None:
    axis = nc.axis(1)
    assert control_loop_count(axis) == 3
    run(nc, 5)
    choose_control_loop(axis, 1)
    assert axis.active_control_loop == 1
    assert (axis.encoder.scaling_factor, axis.controller.position_kv) == (0.01, 30.0)
    assert axis.drive.reference_velocity == 1000.0  # there is one drive
    assert nc.element("encoder", 2) is axis.encoder
    assert nc.element("controller", 2) is axis.controller
    assert nc.element("drive", 1) is axis.drive
    assert [encoder.in_use for encoder in axis.encoders] == [0, 1]
    assert nc.element("encoder", 1).scaling_factor == 1e-4
    assert nc.element("controller", 1).position_kv == 10.0
    choose_control_loop(axis, 0)
    assert (axis.encoder.scaling_factor, axis.controller.position_kv) == (1e-4, 10.0)
    assert nc.element("encoder", 2).scaling_factor == 0.01


def test_the_axis_moves_on_with_its_other_encoder(nc: Nc) -> None:
    axis = nc.axis(1)
    commands.start(axis, 1, 20.0, 100.0)
    run(nc, 2500)
    assert nc.element("encoder", 2).actual_position == pytest.approx(120.0, abs=0.02)
    axis.control_dword = 0
    run(nc, 5)
    choose_control_loop(axis, 1)
    axis.control_dword = 7
    run(nc, 5)
    assert axis.set_position == pytest.approx(120.0, abs=0.02)
    assert commands.start(axis, 1, 150.0, 100.0) == 0
    run(nc, 2500)
    assert axis.actual_position == pytest.approx(150.0, abs=0.02)
    assert nc.element("encoder", 1).actual_position == pytest.approx(50.0, abs=0.03)


def test_a_loop_that_is_not_there(nc: Nc) -> None:
    with pytest.raises(IndexError, match=r"control loop 3, expected 0\.\.2"):
        choose_control_loop(nc.axis(1), 3)
