"""Manual travel: each start type has its velocity or its distance."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit, commands
from achse.motion.commands.jog import JOGS

VELOCITIES = {
    "jog_velocity_slow": 50.0,
    "jog_velocity_fast": 150.0,
    "rapid_traverse_velocity": 400.0,
}
DISTANCES = {"pulse_distance_positive": 3.0, "pulse_distance_negative": 4.0}


def test_the_types_are_those_of_the_library() -> None:
    assert sorted(JOGS) == [
        272, 273, 288, 289, 528, 529, 544, 545, 784, 785, 800, 801, 1056, 1057, 1312, 1313,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("start_type", "velocity"),
    [(272, 50.0), (273, -50.0), (528, 150.0), (529, -150.0), (784, 400.0), (785, -400.0)],
)
def test_endless_at_a_manual_velocity(make_rig: Any, start_type: int, velocity: float) -> None:
    rig = make_rig(**VELOCITIES)
    assert commands.start(rig.axis, start_type, 0.0, 0.0) == 0
    assert rig.has(StateBit.HAS_JOB)
    cycles = rig.until(lambda axis: axis.set_velocity == velocity)
    # up to v: v / a + a / j where a is reached, else 2 sqrt(v / j)
    a, j, v = rig.axis.default_acceleration, rig.axis.default_jerk, abs(velocity)
    time = v / a + a / j if v * j >= a * a else 2.0 * (v / j) ** 0.5
    assert cycles * rig.dt == pytest.approx(time, abs=2 * rig.dt)
    assert rig.has(StateBit.CONTINUOUS_MOTION)
    assert rig.has(StateBit.POSITIVE_DIRECTION if velocity > 0 else StateBit.NEGATIVE_DIRECTION)
    assert commands.stop(rig.axis) == 0
    rig.until_rest()


@pytest.mark.parametrize(
    ("start_type", "distance"),
    [
        (288, 3.0), (289, -4.0), (544, 0.001), (545, -0.001), (800, 0.01), (801, -0.01),
        (1056, 0.1), (1057, -0.1), (1312, 1.0), (1313, -1.0),
    ],
)  # fmt: skip
def test_a_step_at_the_commanded_velocity(make_rig: Any, start_type: int, distance: float) -> None:
    rig = make_rig(**DISTANCES)
    assert commands.universal_start(rig.axis, start_type, 99.0, 20.0) == 0
    fastest = max(abs(v) for _, v, _ in rig.trace(2000))
    assert rig.axis.set_motion_phase == 0
    assert rig.axis.set_position == pytest.approx(distance, abs=1e-12)
    # half the way to the top speed: s / 2 = v^1.5 / sqrt(j) without the velocity limit
    free = (abs(distance) / 2.0) ** (2.0 / 3.0) * rig.axis.default_jerk ** (1.0 / 3.0)
    assert fastest <= min(20.0, free) * (1.0 + 1e-9)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, commands.start, start_type, 0.0, 0.0)


def test_a_manual_velocity_beyond_the_limit_is_refused(make_rig: Any) -> None:
    rig = make_rig(jog_velocity_fast=2500.0)
    rig.refuses(NcError.SET_VELOCITY_NOT_ALLOWED, commands.start, 528, 0.0, 10.0)


def test_only_servo_axes_jog(make_rig: Any) -> None:
    rig = make_rig(axis_type=2)
    rig.refuses(NcError.AXIS_INCOMPATIBLE, commands.start, 272, 0.0, 10.0)


def test_jogging_ends_at_a_soft_limit(make_rig: Any) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=20.0, **VELOCITIES)
    assert commands.start(rig.axis, 272, 0.0, 0.0) == 0
    rig.until(lambda axis: axis.error_code == NcError.SOFT_LIMIT_MAX_PASSED.number)
    commands.reset(rig.axis)
    rig.until_rest()
    rig.refuses(NcError.SOFT_LIMIT_MAX_AT_START, commands.start, 272, 0.0, 0.0)
    assert commands.start(rig.axis, 273, 0.0, 0.0) == 0
