"""Commands of oscillations: mistakes, each with its code."""

from math import inf, nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands

REVERSING = {"kind": 1, "first": 10.0, "second": -10.0, "velocity": 100.0, "idle": 0.1}
STEPS = {"kind": 1, "first": 10.0, "second": -10.0, "move": 0.1, "idle": 0.1, "repeat": 0}
SINE = {
    "kind": 1, "base": 10.0, "frequency": 2.0, "amplitude": 1.0, "feed": 10.0, "start": 20.0,
    "stop": 250.0, "duration": 2.0, "count": 20, "parallel": 1,
}  # fmt: skip

DATA = NcError.START_AXIS_DATA


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"kind": 2}, NcError.START_TYPE),
        ({"velocity": 0.0}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"velocity": 2000.1}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"idle": -1.0}, DATA),
        ({"idle": nan}, DATA),
        ({"first": inf}, DATA),
        ({"second": nan}, DATA),
        ({"second": 10.0}, NcError.COMMAND_SAME_TARGET),
        ({"second": -50.1}, NcError.SOFT_LIMIT_MIN_AT_START),
        ({"first": 50.1}, NcError.SOFT_LIMIT_MAX_AT_START),
    ],
)
def test_reversing(make_rig: Any, wrong: dict[str, float], error: NcError) -> None:
    rig = make_rig(
        encoder_soft_limit_min_enable=1,
        encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-50.0,
        encoder_soft_limit_max=50.0,
    )
    rig.refuses(error, commands.start_reversing, *(REVERSING | wrong).values())
    assert commands.start_reversing(rig.axis, *REVERSING.values()) == 0  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"kind": 2}, NcError.START_TYPE),
        ({"first": 2000.1}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"second": -2000.1}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"second": nan}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"first": 0.0, "second": 0.0}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"move": 0.0}, DATA),
        ({"move": nan}, DATA),
        ({"idle": -0.1}, DATA),
        ({"move": 5.1}, NcError.SOFT_LIMIT_MAX_AT_START),
        ({"first": -10.0, "second": 15.0, "move": 5.1}, NcError.SOFT_LIMIT_MIN_AT_START),
    ],
)
def test_velocity_steps(make_rig: Any, wrong: dict[str, float], error: NcError) -> None:
    rig = make_rig(
        encoder_soft_limit_min_enable=1,
        encoder_soft_limit_max_enable=1,
        encoder_soft_limit_min=-50.0,
        encoder_soft_limit_max=50.0,
    )
    rig.refuses(error, commands.start_velocity_steps, *(STEPS | wrong).values())
    one_way = STEPS | {"second": 0.0}
    assert commands.start_velocity_steps(rig.axis, *one_way.values()) == 0  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        ({"kind": 2}, NcError.START_TYPE),
        ({"base": 0.0}, DATA),
        ({"base": nan}, DATA),
        ({"base": 2000.0}, NcError.SET_VELOCITY_NOT_ALLOWED),
        ({"frequency": 10.1}, DATA),
        ({"frequency": -1.0}, DATA),
        ({"amplitude": -1.0}, DATA),
        ({"feed": 0.0}, DATA),
        ({"start": 0.9}, DATA),
        ({"stop": 250.1}, DATA),
        ({"stop": 0.5}, DATA),
        ({"duration": 0.0}, DATA),
        ({"count": 0}, DATA),
        ({"count": 201}, DATA),
        ({"amplitude": 500.0}, NcError.ACCELERATION_NOT_PERMITTED),
        ({"base": 1000.0}, NcError.SOFT_LIMIT_MAX_AT_START),
    ],
)
def test_sine(make_rig: Any, wrong: dict[str, float], error: NcError) -> None:
    rig = make_rig(encoder_soft_limit_max_enable=1, encoder_soft_limit_max=50.0)
    rig.refuses(error, commands.start_sine_oscillation, *(SINE | wrong).values())
    falling = SINE | {"start": 250.0, "stop": 1.0}
    assert commands.start_sine_oscillation(rig.axis, *falling.values()) == 0  # type: ignore[arg-type]


def test_the_farthest_way_of_a_sine_counts_against_soft_limits(make_rig: Any) -> None:
    """A base oscillation of 40 mm/s at 1 Hz goes 40 / pi mm to one side."""
    only_base = (1, 40.0, 1.0, 0.0, 10.0, 20.0, 100.0, 1.0, 2, 1)
    limited = {"encoder_soft_limit_max_enable": 1.0, "encoder_soft_limit_max": 12.7}
    error = NcError.SOFT_LIMIT_MAX_AT_START
    make_rig(**limited).refuses(error, commands.start_sine_oscillation, *only_base)
    rig = make_rig(**limited | {"encoder_soft_limit_max": 12.8})
    assert commands.start_sine_oscillation(rig.axis, *only_base) == 0
    rig.until_rest()
    assert rig.axis.error_code == 0
