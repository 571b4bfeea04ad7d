"""Starts: each refusal has its documented code and changes nothing."""

from math import inf, nan, sqrt
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import BufferMode, StartType, StateBit, commands

V = 200.0


def ramp(change: float, acceleration: float, jerk: float) -> float:
    """Time of a change of velocity between two states without acceleration."""
    if change * jerk <= acceleration * acceleration:
        return 2.0 * sqrt(change / jerk)
    return change / acceleration + acceleration / jerk


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


@pytest.mark.parametrize(
    ("control", "target", "error"),
    [
        (0b000, 10.0, NcError.CONTROLLER_ENABLE_MISSING),
        (0b110, 10.0, NcError.CONTROLLER_ENABLE_MISSING),
        (0b101, 10.0, NcError.ENABLE_MISSING),
        (0b011, -10.0, NcError.ENABLE_MISSING),
    ],
)
def test_enables_are_needed(make_rig: Any, control: int, target: float, error: NcError) -> None:
    rig = make_rig(control_dword=control)
    before = rig.nc.digest()
    rig.refuses(error, commands.start, StartType.ABSOLUTE, target, V)
    rig.refuses(error, commands.universal_start, StartType.ABSOLUTE, target, V)
    assert rig.nc.digest() == before


def test_one_feed_enable_is_enough_for_its_direction(make_rig: Any) -> None:
    assert commands.start(make_rig(control_dword=0b011).axis, 1, 10.0, V) == 0
    assert commands.start(make_rig(control_dword=0b101).axis, 1, -10.0, V) == 0


@pytest.mark.parametrize(
    ("velocity", "error"),
    [
        (0.0, NcError.SET_VELOCITY_NOT_ALLOWED),
        (-1.0, NcError.SET_VELOCITY_NOT_ALLOWED),
        (nan, NcError.SET_VELOCITY_NOT_ALLOWED),
        (inf, NcError.SET_VELOCITY_NOT_ALLOWED),
        (2000.1, NcError.SET_VELOCITY_NOT_ALLOWED),
        (1e-4, NcError.SET_VELOCITY_RANGE),
    ],
)
def test_velocities(rig: Any, velocity: float, error: NcError) -> None:
    for kind in (StartType.ABSOLUTE, StartType.ENDLESS_POSITIVE):
        rig.refuses(error, commands.start, kind, 10.0, velocity)
        rig.refuses(error, commands.universal_start, kind, 10.0, velocity)


def test_velocity_above_the_reference_velocity(make_rig: Any) -> None:
    rig = make_rig(drive_reference_velocity=150.0)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, commands.start, 1, 10.0, V)


@pytest.mark.parametrize(
    ("dynamics", "error"),
    [
        ((0.0, 1.0, 1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((1.0, -1.0, 1.0), NcError.DECELERATION_NOT_POSITIVE),
        ((1.0, 1.0, 0.0), NcError.JERK_NOT_POSITIVE),
        ((nan, 1.0, 1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((1e9, 1.0, 1.0), NcError.ACCELERATION_NOT_PERMITTED),
        ((1.0, 1e9, 1.0), NcError.ACCELERATION_NOT_PERMITTED),
        ((1.0, 1.0, 1e31), NcError.JERK_NOT_PERMITTED),
        ((1.0, 1.0, inf), NcError.JERK_NOT_PERMITTED),
    ],
)
def test_dynamics(rig: Any, dynamics: tuple[float, float, float], error: NcError) -> None:
    rig.refuses(error, commands.start, 1, 10.0, V, *dynamics)
    if 0.0 not in dynamics:
        rig.refuses(error, commands.universal_start, 1, 10.0, V, *dynamics)


def test_zero_dynamics_of_the_universal_start_are_the_defaults(rig: Any) -> None:
    assert commands.universal_start(rig.axis, 1, 10.0, V) == 0
    assert rig.axis.job.acceleration == rig.axis.default_acceleration
    assert rig.axis.job.jerk == rig.axis.default_jerk


@pytest.mark.parametrize(
    ("kind", "position", "error"),
    [
        (0, 10.0, NcError.START_TYPE),
        (7, 10.0, NcError.START_TYPE),
        (1, nan, NcError.START_AXIS_DATA),
        (2, inf, NcError.START_AXIS_DATA),
        (1, 1e11, NcError.PRECISION_LOST),
        (StartType.MODULO_SHORTEST, 360.0, NcError.MODULO_START_RANGE),
        (StartType.MODULO_POSITIVE, -1.0, NcError.MODULO_START_RANGE),
        (StartType.MODULO_NEGATIVE, 720.0, NcError.MODULO_START_RANGE),
    ],
)
def test_targets(rig: Any, kind: int, position: float, error: NcError) -> None:
    rig.refuses(error, commands.start, kind, position, V)
    rig.refuses(error, commands.universal_start, kind, position, V)


def test_the_old_start_knows_neither_halt_nor_lock(rig: Any) -> None:
    for kind in (StartType.HALT, StartType.STOP_AND_LOCK):
        rig.refuses(NcError.START_TYPE, commands.start, kind, 0.0, V)


def test_targets_beyond_soft_limits(make_rig: Any) -> None:
    rig = make_rig(
        encoder_soft_limit_min_enable=1,
        encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-10.0,
        encoder_soft_limit_max=20.0,
    )
    rig.refuses(NcError.SOFT_LIMIT_MIN_AT_START, commands.start, 1, -10.1, V)
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 2, 20.1, V)
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 517, 90.0, V)
    assert commands.start(rig.axis, 1, 20.0, V) == 0
    rig.until_rest()
    assert rig.axis.error_code == 0
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 3, 0.0, V)
    assert commands.start(rig.axis, 1, 0.0, V) == 0
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.new_end_position, 1, 30.0)


def test_the_way_back_from_beyond_a_soft_limit_is_open(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=20.0)
    commands.set_actual_position(rig.axis, 1, 30.0)
    assert commands.start(rig.axis, 1, 10.0, V) == 0
    rig.run(2)
    assert rig.has(StateBit.SOFT_LIMIT_MAX_EXCEEDED)
    rig.until_rest()
    assert rig.axis.error_code == 0
    assert not rig.has(StateBit.SOFT_LIMIT_MAX_EXCEEDED)


def test_old_services_are_busy_during_a_job(rig: Any) -> None:
    assert commands.start(rig.axis, 1, 100.0, V) == 0
    rig.refuses(NcError.GROUP_BUSY, commands.start, 1, 50.0, V)
    rig.refuses(NcError.GROUP_BUSY, commands.set_actual_position, 1, 0.0)
    rig.refuses(NcError.GROUP_BUSY, commands.disable)


def test_blending_wants_one_direction_and_a_way(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    back = commands.universal_start(rig.axis, 1, 50.0, V, buffer_mode=BufferMode.BLENDING_LOW)
    refused(rig, back, NcError.COMMAND_OTHER_DIRECTION)
    same = commands.universal_start(rig.axis, 1, 100.0, V, buffer_mode=BufferMode.BUFFERED)
    refused(rig, same, NcError.COMMAND_SAME_TARGET)


def test_modes_that_do_not_exist(rig: Any) -> None:
    code = commands.universal_start(rig.axis, 1, 50.0, V, buffer_mode=2)
    refused(rig, code, NcError.FUNCTION_NOT_AVAILABLE)


@pytest.mark.parametrize("name", ["segment_start_velocity", "segment_end_velocity"])
def test_segment_velocities_lie_between_0_and_the_velocity(rig: Any, name: str) -> None:
    for velocity in (-1.0, V * 1.001, nan):
        options: dict[str, Any] = {name: velocity}
        code = commands.universal_start(rig.axis, 1, 50.0, V, **options)
        refused(rig, code, NcError.VELOCITY_NOT_PERMITTED)


def test_a_blending_position_lies_on_the_way_of_the_command_before(rig: Any) -> None:
    rest = commands.universal_start(rig.axis, 1, 50.0, V, blending_position=nan)
    refused(rig, rest, NcError.START_AXIS_DATA)
    commands.universal_start(rig.axis, 1, 100.0, V)
    for position in (-10.0, 100.1):
        code = commands.universal_start(
            rig.axis, 1, 200.0, V, buffer_mode=BufferMode.BLENDING_LOW, blending_position=position
        )
        refused(rig, code, NcError.ACTIVATION_POSITION_NOT_ON_WAY)


def test_defaults_wider_than_anything_are_used_as_far_as_they_go(make_rig: Any) -> None:
    names = (
        "max_velocity", "drive_reference_velocity", "max_acceleration", "max_deceleration",
        "default_acceleration", "default_deceleration",
    )  # fmt: skip
    wide = dict.fromkeys(names, 1e20)
    rig = make_rig(**wide, default_jerk=1e30, simulation_ideal=1)  # 200 of 1e20 is not an output
    assert commands.start(rig.axis, 1, 100.0, V) == 0
    rig.run(1)
    assert rig.axis.set_velocity == pytest.approx(V)
    assert rig.until_rest() == pytest.approx(100.0 / V / rig.dt, abs=1.0)
    assert rig.axis.set_position == 100.0
    rig = make_rig(default_acceleration=1e9, default_deceleration=1e9)
    assert commands.universal_start(rig.axis, 1, 100.0, V) == 0
    assert rig.axis.job.acceleration == rig.axis.max_acceleration
    assert rig.axis.job.deceleration == rig.axis.max_deceleration


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(
    ("kind", "position", "way"),
    [
        (StartType.ABSOLUTE, 800.0, 710.0),
        (StartType.ABSOLUTE, -500.0, -590.0),
        (StartType.RELATIVE, -400.0, -400.0),
        (StartType.MODULO, 1000.0, 910.0),
        (StartType.MODULO, -600.0, -570.0),
        (StartType.MODULO_SHORTEST, 300.0, -150.0),
        (StartType.MODULO_SHORTEST, 200.0, 110.0),
        (StartType.MODULO_POSITIVE, 80.0, 350.0),
        (StartType.MODULO_POSITIVE, 89.0, -1.0),
        (StartType.MODULO_NEGATIVE, 100.0, -350.0),
        (StartType.MODULO_NEGATIVE, 91.0, 1.0),
    ],
)
def test_a_start_from_90_degrees_takes_its_way_in_its_time(
    make_rig: Any, kind: StartType, position: float, way: float, compiled: bool
) -> None:
    """Types 517 and 773 go straight back where the target is behind by less than 2 degrees."""
    v, a, d, j = 100.0, 400.0, 800.0, 8000.0
    rig = make_rig(compiled=compiled, encoder_modulo_tolerance_window=2.0)
    commands.set_actual_position(rig.axis, 1, 90.0)
    rig.run(1)
    before = rig.axis.command_counter
    assert commands.universal_start(rig.axis, kind, position, v, a, d, j) == 0
    assert rig.axis.command_counter == before + 1
    ramps = 0.5 * v * (ramp(v, a, j) + ramp(v, d, j))
    time = (abs(way) - ramps) / v + ramp(v, a, j) + ramp(v, d, j)
    if abs(way) < ramps:  # no acceleration limit is reached: four phases of t with 2 j t³ = way
        time = 4.0 * (abs(way) / (2.0 * j)) ** (1.0 / 3.0)
    rig.run(1)
    assert rig.has(StateBit.POSITIVE_DIRECTION) == (way > 0.0)
    assert rig.has(StateBit.NEGATIVE_DIRECTION) == (way < 0.0)
    assert rig.has(StateBit.HAS_JOB)
    assert not rig.has(StateBit.NOT_MOVING)
    assert not rig.has(StateBit.IN_TARGET_POSITION)
    samples = rig.trace(round(0.5 * time / rig.dt))
    assert rig.has(StateBit.CONSTANT_VELOCITY) == (abs(way) > ramps)
    left = rig.until_rest()
    assert abs(len(samples) + left - time / rig.dt) < 1.001
    assert rig.axis.set_position == pytest.approx(90.0 + way, abs=1e-12)
    assert rig.axis.set_velocity == rig.axis.set_acceleration == 0.0
    rig.run(30)
    assert rig.has(StateBit.NOT_MOVING)
    assert rig.has(StateBit.IN_TARGET_POSITION)
    assert not rig.has(StateBit.HAS_JOB)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_endless_start_is_in_velocity_after_its_ramp(rig: Any, sign: float) -> None:
    kind = StartType.ENDLESS_POSITIVE if sign > 0.0 else StartType.ENDLESS_NEGATIVE
    assert commands.universal_start(rig.axis, kind, 0.0, V, 500.0, 900.0, 5000.0) == 0
    time = ramp(V, 500.0, 5000.0)
    cycles = rig.until(lambda axis: axis.set_velocity == sign * V)
    assert abs(cycles - time / rig.dt) < 1.001
    assert rig.axis.set_position == pytest.approx(
        sign * V * (0.5 * time + cycles * rig.dt - time), rel=1e-9
    )
    rig.run(1)
    for bit in (StateBit.CONSTANT_VELOCITY, StateBit.CONTINUOUS_MOTION, StateBit.HAS_JOB):
        assert rig.has(bit)


def test_an_additive_start_counts_from_the_last_target_reached_or_not(rig: Any) -> None:
    """Type 6; what waits counts too, and where nothing has an end the set position does."""
    assert commands.universal_start(rig.axis, StartType.ABSOLUTE, 50.0, V) == 0
    rig.run(3)
    assert rig.axis.set_position < 49.0
    assert commands.universal_start(rig.axis, StartType.ADDITIVE, 10.0, V) == 0
    assert rig.axis.target_position == 60.0
    buffered = {"buffer_mode": BufferMode.BUFFERED}
    assert commands.universal_start(rig.axis, StartType.ADDITIVE, 5.0, V, **buffered) == 0
    rig.until(lambda axis: axis.set_position > 64.9)
    rig.until_rest()
    assert rig.axis.set_position == 65.0
    assert commands.universal_start(rig.axis, StartType.ADDITIVE, -5.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 60.0
    assert commands.universal_start(rig.axis, StartType.ENDLESS_POSITIVE, 0.0, V) == 0
    rig.run(100)
    here = rig.axis.set_position
    assert commands.universal_start(rig.axis, StartType.ADDITIVE, 500.0, V) == 0
    assert rig.axis.target_position == here + 500.0


def test_modulo_in_current_direction_goes_on_as_before(rig: Any) -> None:
    for first, target, end in ((20.0, 10.0, 370.0), (-20.0, 10.0, 10.0)):
        assert commands.universal_start(rig.axis, StartType.RELATIVE, first, V) == 0
        rig.until_rest()
        assert commands.universal_start(rig.axis, StartType.MODULO_CURRENT, target, V) == 0
        rig.until_rest()
        assert rig.axis.set_position == pytest.approx(end)
    rig.refuses(NcError.MODULO_START_RANGE, commands.start, StartType.MODULO_CURRENT, 360.0, V)
    assert commands.start(rig.axis, StartType.ABSOLUTE_INTERNAL, 5.0, V) == 0
    assert rig.axis.target_position == 5.0
