"""NC and machine with scaling, directions and resolution drawn at random.

Where they agree the motion is right. Where one parameter of the NC is wrong by a factor, the
machine moves by that factor, as a real one does; where a direction is wrong, it runs away and
monitoring reports it.
"""

from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.codes.nc.choices import ControllerType, DriveType
from achse.motion import Axis, AxisParameters, Nc, commands
from achse.native.backend import compiler_installed

DT = 0.002
V = 50.0
KV = 20.0

ANALOG: dict[str, float] = {"drive_type": DriveType.MDP_252}
DIGITAL: dict[str, float] = {"drive_type": DriveType.MDP_742}
POSITION: dict[str, float] = {
    "drive_type": DriveType.SERCOS,
    "controller_type": ControllerType.SERCOS_POSITION,
}

FACTORS = st.floats(0.6, 1.6).filter(lambda k: abs(k - 1.0) > 0.05)


@st.composite
def setups(draw: Any, *interfaces: dict[str, float]) -> dict[str, float]:
    """What an axis is set to; its machine is built accordingly."""
    resolution = 10.0 ** draw(st.floats(-6.0, -2.0))
    return {
        **draw(st.sampled_from(interfaces)),
        "encoder_scaling_factor": resolution,
        "encoder_count_direction": draw(st.integers(0, 1)),
        "encoder_mask": draw(st.sampled_from([0xFFFF_FFFF, 0xFF_FFFF, 3_599_999])),
        "drive_motor_polarity": draw(st.integers(0, 1)),
        "drive_reference_velocity": draw(st.floats(2.0 * V, 100.0 * V)),
        "drive_reference_output": draw(st.floats(0.2, 1.0)),
        "drive_position_scaling": draw(st.floats(0.5, 4.0)),
        "drive_velocity_scaling": draw(st.floats(1e3, 1e5)),
        "drive_output_mask": draw(st.sampled_from([0x7FFF, 0xF_FFFF, 0x7FFF_FFFF])),
        "simulation_time_constant": draw(st.floats(0.0, 0.01)),
        "default_jerk": 1e5,
        "velocity_override": 1_000_000,
    }


def build(values: dict[str, float], compiled: bool) -> tuple[Nc, Axis]:
    """An NC with this axis, at rest and disabled."""
    nc = Nc(2_000_000, [AxisParameters(1, values=values)], compiled=compiled)
    nc.cycle(2)
    return nc, nc.axis(1)


def enable(nc: Nc, axis: Axis) -> None:
    axis.control_dword = 7
    nc.cycle(3)


def last_bit(axis: Axis) -> float:
    """Velocity of one increment of the output."""
    analog = axis.amplifier.full_velocity / axis.amplifier.full_output
    return max(analog, 1.0 / axis.amplifier.velocity_weight)


def coarseness(axis: Axis) -> float:
    """What is left at the target: some increments, and an output that is none."""
    return 2.0 * axis.sensor.encoder_resolution + last_bit(axis) / KV + 1e-9


PHASES = [Phase.explicit, Phase.reuse, Phase.generate]
"""What fails is told as it was drawn: a run is long."""

KERNELS = st.sampled_from([False, True] if compiler_installed() else [False])


@settings(max_examples=7, deadline=None, phases=PHASES)
@given(setups(ANALOG, DIGITAL, POSITION), KERNELS, st.sampled_from([-30.0, 25.0]))
def test_where_they_agree_the_motion_is_right(
    values: dict[str, float], compiled: bool, target: float
) -> None:
    nc, axis = build(values, compiled)
    enable(nc, axis)
    assert commands.start(axis, 1, target, V) == 0
    nc.cycle(700)
    assert axis.error_code == 0
    assert axis.actual_position == pytest.approx(target, abs=coarseness(axis))
    assert axis.machine.position == pytest.approx(target, abs=coarseness(axis))
    commands.start(axis, 3, 0.0, V)
    nc.cycle(300)
    assert axis.machine.velocity == pytest.approx(V, abs=2.0 * last_bit(axis) + 0.5)


@settings(max_examples=7, deadline=None, phases=PHASES)
@given(setups(ANALOG, DIGITAL, POSITION), KERNELS, FACTORS)
def test_a_wrong_scaling_of_the_encoder_moves_farther_or_less(
    values: dict[str, float], compiled: bool, factor: float
) -> None:
    nc, axis = build(values, compiled)
    axis.controller.following_error_position_monitoring_enable = 0
    axis.encoder.scaling_factor *= factor
    enable(nc, axis)
    assert commands.start(axis, 1, 20.0, V) == 0
    nc.cycle(700)
    assert axis.actual_position == pytest.approx(20.0, abs=2.0 * coarseness(axis))
    assert axis.machine.position == pytest.approx(20.0 / factor, abs=4.0 * coarseness(axis))


@settings(max_examples=7, deadline=None, phases=PHASES)
@given(
    setups(ANALOG),
    KERNELS,
    st.sampled_from(["drive_reference_velocity", "drive_reference_output"]),
    FACTORS,
)
def test_a_wrong_reference_of_an_analog_output_is_a_wrong_velocity(
    values: dict[str, float], compiled: bool, name: str, factor: float
) -> None:
    nc, axis = build(values, compiled)
    axis.controller.following_error_position_monitoring_enable = 0
    setattr(axis, name, factor * getattr(axis, name))
    enable(nc, axis)
    assert commands.start_drive_output(axis, 2, 0.5 * V) == 0  # an output, whatever comes of it
    nc.cycle(200)
    wrong = 1.0 / factor if name == "drive_reference_velocity" else factor
    reached, rough = 0.5 * V * wrong, 2.0 * last_bit(axis) + 0.05
    assert axis.machine.velocity == pytest.approx(reached, abs=rough)
    rough += 0.2 * axis.sensor.encoder_resolution / DT  # an increment a cycle, filtered
    assert axis.actual_velocity == pytest.approx(reached, abs=rough)


@settings(max_examples=7, deadline=None, phases=PHASES)
@given(setups(DIGITAL, POSITION), KERNELS, FACTORS)
def test_a_wrong_weight_of_a_digital_output_is_a_wrong_motion(
    values: dict[str, float], compiled: bool, factor: float
) -> None:
    nc, axis = build(values, compiled)
    axis.controller.following_error_position_monitoring_enable = 0
    axis.controller.position_kv = 0.0
    if axis.drive.type == DriveType.SERCOS:
        axis.drive.position_scaling *= factor
    else:
        axis.drive.velocity_scaling *= factor
    enable(nc, axis)
    assert commands.start(axis, 1, 20.0, V) == 0
    nc.cycle(700)
    assert axis.machine.position == pytest.approx(20.0 * factor, rel=0.01)
    assert axis.actual_position == pytest.approx(axis.machine.position, abs=coarseness(axis))


@settings(max_examples=7, deadline=None, phases=PHASES)
@given(
    setups(ANALOG, DIGITAL, POSITION),
    KERNELS,
    st.sampled_from(["drive_motor_polarity", "encoder_count_direction"]),
    st.sampled_from([3, 4]),
)
def test_a_wrong_direction_runs_away_and_is_reported(
    values: dict[str, float], compiled: bool, name: str, start_type: int
) -> None:
    nc, axis = build(values, compiled)
    setattr(axis, name, 1 - getattr(axis, name))
    enable(nc, axis)
    assert commands.start(axis, start_type, 0.0, V) == 0
    nc.cycle(500)
    assert NcError.of(axis.error_code) is NcError.FOLLOWING_ERROR_POSITION
    assert axis.loop_closed == 0
    nc.cycle(500)
    assert axis.machine.velocity == pytest.approx(0.0, abs=1e-6)  # the drive is not enabled


@settings(max_examples=7, deadline=None, phases=PHASES)
@given(setups(ANALOG, DIGITAL), KERNELS)
def test_two_wrong_directions_move_the_other_way(values: dict[str, float], compiled: bool) -> None:
    nc, axis = build(values, compiled)
    axis.drive.motor_polarity = 1 - axis.drive.motor_polarity
    axis.encoder.count_direction = 1 - axis.encoder.count_direction
    enable(nc, axis)
    assert commands.start(axis, 1, 20.0, V) == 0
    nc.cycle(700)
    assert axis.error_code == 0
    assert axis.machine.position == pytest.approx(-20.0, abs=coarseness(axis))
