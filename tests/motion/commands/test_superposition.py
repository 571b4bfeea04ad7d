"""Section compensation: what it refuses, and with which code."""

from math import inf, nan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import NcError
from achse.motion import AxisParameters, Nc, commands
from achse.motion.commands import Compensation
from achse.motion.setpoints.superposition import superposed_way

GOOD = Compensation(1, 0.0, 0.0, 20.0, 100.0, 5.0, 100.0)


def refused(rig: Any, error: NcError, **wrong: Any) -> None:
    before = rig.nc.digest()
    code, _ = commands.start_superposition(rig.axis, GOOD._replace(**wrong))
    assert NcError.of(code) is error, hex(code)
    assert rig.nc.digest() == before


@pytest.fixture
def moving(rig: Any) -> Any:
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    return rig


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"type": 0}, NcError.COMPENSATION_TYPE),
        ({"type": 7}, NcError.COMPENSATION_TYPE),
        ({"acceleration_increase": -1.0}, NcError.COMPENSATION_DYNAMICS),
        ({"deceleration_increase": nan}, NcError.COMPENSATION_DYNAMICS),
        ({"process_velocity": 0.0}, NcError.COMPENSATION_DYNAMICS),
        ({"process_velocity": inf}, NcError.COMPENSATION_DYNAMICS),
        ({"process_velocity": 5e-324}, NcError.COMPENSATION_DYNAMICS),
        ({"process_velocity": 1e300}, NcError.COMPENSATION_DYNAMICS),
        ({"type": 3, "acceleration_increase": 5e-324}, NcError.COMPENSATION_DYNAMICS),
        ({"velocity_increase": 5e-324}, NcError.COMPENSATION_CAMBER),
        ({"distance": 1e300}, NcError.SUPERIMPOSED_MOVE_DATA),
        ({"length": 5e-324}, NcError.COMPENSATION_DISTANCE),
        ({"velocity_increase": 0.0}, NcError.COMPENSATION_CAMBER),
        ({"velocity_increase": -1.0}, NcError.COMPENSATION_CAMBER),
        ({"distance": 0.0}, NcError.SUPERIMPOSED_MOVE_DATA),
        ({"distance": nan}, NcError.SUPERIMPOSED_MOVE_DATA),
        ({"length": 0.0}, NcError.COMPENSATION_DISTANCE),
        ({"length": inf}, NcError.COMPENSATION_DISTANCE),
        ({"type": 2, "distance": 100.0}, NcError.COMPENSATION_DISTANCE),
        ({"acceleration_increase": 1e9}, NcError.ACCELERATION_NOT_PERMITTED),
    ],
)
def test_data(moving: Any, wrong: dict[str, float], error: NcError) -> None:
    refused(moving, error, **wrong)


def test_the_axis_must_travel(rig: Any) -> None:
    refused(rig, NcError.COMPENSATION_ACTIVE)
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    commands.stop(rig.axis)
    rig.run(1)
    refused(rig, NcError.COMPENSATION_ACTIVE)


def test_one_at_a_time(moving: Any) -> None:
    assert commands.start_superposition(moving.axis, GOOD)[0] == 0
    refused(moving, NcError.COMPENSATION_ACTIVE)


def test_states_that_refuse_any_command(moving: Any, make_rig: Any) -> None:
    commands.set_external_error(moving.axis, 0x4466)
    moving.run(1)
    refused(moving, NcError.ENCODER_IO_INVALID)
    rig = make_rig()
    assert commands.start_external_setpoint(rig.axis, 1, 0.0) == 0
    refused(rig, NcError.EXTERNAL_GENERATOR_ACTIVE)
    refused(make_rig(axis_type=2), NcError.AXIS_INCOMPATIBLE)


def test_an_axis_at_its_limit_cannot_gain_but_lose(make_rig: Any) -> None:
    rig = make_rig(max_velocity=100.0)
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    refused(rig, NcError.SET_VELOCITY_NOT_ALLOWED)
    code, done = commands.start_superposition(rig.axis, GOOD._replace(distance=-5.0))
    assert (code, done.warning, done.distance) == (0, 0, -5.0)


def test_velocity_stays_below_the_limit_and_above_rest(make_rig: Any) -> None:
    rig = make_rig(max_velocity=110.0)
    commands.universal_start(rig.axis, 3, 0.0, 100.0)
    rig.seconds(1.0)
    wish = GOOD._replace(type=3, velocity_increase=500.0)
    code, done = commands.start_superposition(rig.axis, wish)
    assert (code, done.velocity_increase) == (0, pytest.approx(10.0))
    rig.until(lambda axis: not axis.compensating)
    code, done = commands.start_superposition(rig.axis, wish._replace(distance=-80.0, length=300.0))
    assert (code, done.velocity_increase) == (0, 100.0)
    assert min(v for _, v, _ in rig.trace(1000)) >= -1e-9


def test_accelerations_of_zero_are_the_defaults(moving: Any) -> None:
    _, done = commands.start_superposition(moving.axis, GOOD)
    axis = moving.axis
    assert done.acceleration_increase == axis.default_acceleration
    assert done.deceleration_increase == axis.default_deceleration


@settings(max_examples=75, deadline=None)
@given(
    kind=st.integers(1, 6),
    acceleration=st.floats(1.0, 1e5),
    deceleration=st.floats(1.0, 1e5),
    increase=st.floats(1e-3, 1900.0),
    process=st.floats(1.0, 2000.0),
    distance=st.floats(-500.0, 500.0).filter(lambda s: abs(s) > 1e-6),
    length=st.floats(1e-3, 5000.0),
)
def test_what_is_carried_out_is_possible(
    kind: int,
    acceleration: float,
    deceleration: float,
    increase: float,
    process: float,
    distance: float,
    length: float,
) -> None:
    """The trapezoid covers what is answered, within way, time and velocity that were given."""
    presets = {"control_dword": 7, "velocity_override": 1_000_000}
    axis = Nc(2_000_000, [AxisParameters(1, values=presets)], compiled=False).axis(1)
    commands.universal_start(axis, 3, 0.0, 100.0)
    compensation = Compensation(
        kind, acceleration, deceleration, increase, process, distance, length
    )
    base = length - distance if kind in (2, 4, 6) else length
    code, done = commands.start_superposition(axis, compensation)
    if base <= 0.0:
        assert NcError.of(code) is NcError.COMPENSATION_DISTANCE
        return
    assert code == 0
    assert done.acceleration_increase <= acceleration * (1.0 + 1e-9)
    assert done.deceleration_increase <= deceleration * (1.0 + 1e-9)
    top = done.velocity_increase
    c = 1.0 / done.acceleration_increase + 1.0 / done.deceleration_increase
    assert 0.0 < top <= increase * (1.0 + 1e-9)
    end = axis.superposed.end
    assert top * end - 0.5 * c * top * top == pytest.approx(abs(done.distance), rel=1e-6, abs=1e-9)
    assert end <= base / process * (1.0 + 1e-9)
    assert 0.0 <= axis.superposed.rise_end <= axis.superposed.fall_begin * (1.0 + 1e-9)
    used = done.length - done.distance if kind in (2, 4, 6) else done.length
    assert used == pytest.approx(process * end, rel=1e-6)
    assert (done.warning == 0) == (done.distance == distance)
    assert abs(done.distance) <= abs(distance)
    samples = [superposed_way(axis, end * n / 64) for n in range(65)]
    assert samples == sorted(samples)
    assert samples[-1] == pytest.approx(abs(done.distance), rel=1e-9)
