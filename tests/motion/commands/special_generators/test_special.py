"""Special start: a second velocity from a position on."""

from math import nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands


@pytest.mark.parametrize(("first", "second"), [(200.0, 80.0), (80.0, 200.0)])
def test_the_velocity_changes_at_its_position(make_rig: Any, first: float, second: float) -> None:
    rig = make_rig(default_jerk=15_000.0)
    assert commands.start_special(rig.axis, 1, 400.0, first, 200.0, second) == 0
    trace = rig.trace(4000)
    moving = [(p, v) for p, v, _ in trace if v != 0.0]
    highest = max(v for _, v in moving)
    assert highest == pytest.approx(200.0)
    before = [v for p, v in moving if 100.0 <= p <= 199.0]
    assert before
    assert {round(v, 6) for v in before} == {first}
    ramp = abs(first * first - second * second) / (2 * 1500.0) + 200.0 * 1500.0 / 15_000.0
    after = [v for p, v in moving if 201.0 + ramp <= p <= 350.0]
    assert after
    assert {round(v, 6) for v in after} == {second}
    assert rig.axis.set_position == 400.0


def test_an_endless_one_has_its_own_dynamics(rig: Any) -> None:
    assert commands.start_special(rig.axis, 4, 0.0, 50.0, -20.0, 100.0, 800.0, 900.0, 5000.0) == 0
    assert (rig.axis.job.acceleration, rig.axis.job.deceleration) == (800.0, 900.0)
    rig.seconds(2.0)
    assert rig.axis.set_velocity == -100.0


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((1, 100.0, 50.0, 101.0, 20.0), NcError.ACTIVATION_POSITION_NOT_ON_WAY),
        ((1, 100.0, 50.0, -1.0, 20.0), NcError.ACTIVATION_POSITION_NOT_ON_WAY),
        ((3, 0.0, 50.0, -1.0, 20.0), NcError.ACTIVATION_POSITION_NOT_ON_WAY),
        ((1, 100.0, 50.0, nan, 20.0), NcError.START_AXIS_DATA),
        ((1, nan, 50.0, 10.0, 20.0), NcError.START_AXIS_DATA),
        ((1, 100.0, 0.0, 50.0, 20.0), NcError.SET_VELOCITY_NOT_ALLOWED),
        ((1, 100.0, 50.0, 50.0, 2001.0), NcError.SET_VELOCITY_NOT_ALLOWED),
        ((7, 100.0, 50.0, 50.0, 20.0), NcError.START_TYPE),
        ((8192, 0.0, 50.0, 0.0, 20.0), NcError.START_TYPE),
        ((1, 100.0, 50.0, 50.0, 20.0, -1.0), NcError.ACCELERATION_NOT_POSITIVE),
    ],
)
def test_mistakes(rig: Any, arguments: tuple[float, ...], error: NcError) -> None:
    rig.refuses(error, commands.start_special, *arguments)


def test_not_during_a_job(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, 50.0)
    rig.refuses(NcError.GROUP_BUSY, commands.start_special, 1, 200.0, 50.0, 150.0, 20.0)
