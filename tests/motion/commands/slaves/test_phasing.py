"""Phasing: what it refuses, and with which code."""

from math import inf, nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((0, 0, 0, 1.0, 10.0), NcError.JOB_START_TYPE),
        ((3, 0, 0, 1.0, 10.0), NcError.JOB_START_TYPE),
        ((1, 0, 256, 1.0, 10.0), NcError.AXIS_ID),
        ((1, 0, 0, nan, 10.0), NcError.START_AXIS_DATA),
        ((1, 0, 0, inf, 10.0), NcError.START_AXIS_DATA),
        ((1, 0, 0, 1e16, 10.0), NcError.DYNAMICS_NOT_ALLOWED),
        ((1, 0, 0, 1.0, 0.0), NcError.SET_VELOCITY_NOT_ALLOWED),
        ((1, 0, 0, 1.0, 2500.0), NcError.SET_VELOCITY_NOT_ALLOWED),
        ((1, 0, 0, 1.0, 10.0, -1.0), NcError.ACCELERATION_NOT_POSITIVE),
        ((1, 0, 0, 1.0, 10.0, 1.0, -1.0), NcError.DECELERATION_NOT_POSITIVE),
        ((2, 0, 0, 1.0, 10.0, 1.0, 1.0, nan), NcError.JERK_NOT_POSITIVE),
        ((4096, 0, 0, 1.0, 10.0, 1.0, 1.0, -1.0), NcError.JERK_NOT_POSITIVE),
        ((1, 0, 0, 1.0, 10.0, 1.0, 1.0, 1.0, 1), NcError.FUNCTION_NOT_AVAILABLE),
        ((1, 0, 0, 1.0, 10.0, 1.0, 1.0, 1.0, 0, 5.0), NcError.FUNCTION_NOT_AVAILABLE),
    ],
)
def test_refusals(rig: Any, arguments: tuple[Any, ...], error: NcError) -> None:
    code = commands.start_phasing(rig.axis, *arguments)
    assert NcError.of(code) is error
    assert rig.axis.phasing_active == 0


def test_a_disabled_axis_shifts_no_phase(rig: Any) -> None:
    commands.disable(rig.axis)
    rig.refuses(NcError.AXIS_NOT_READY, commands.start_phasing, 1, 0, 0, 1.0, 10.0)


def test_without_dynamics_the_axis_defaults_count(rig: Any) -> None:
    assert commands.start_phasing(rig.axis, 1, 0, 0, 500.0, 100.0) == 0
    assert rig.axis.phasing.jerk[0] == rig.axis.default_jerk
