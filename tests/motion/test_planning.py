"""Planning from any state: changes at awkward moments neither jump nor turn the axis."""

from itertools import pairwise
from typing import Any

import pytest

from achse.motion import StartType, commands

V = 200.0


@pytest.mark.parametrize("kind", [StartType.ABSOLUTE, StartType.ENDLESS_POSITIVE, StartType.HALT])
def test_a_command_with_less_jerk_does_not_turn_a_braking_axis(rig: Any, kind: int) -> None:
    """Released with the new jerk, 3000 mm/s² would take 90 mm/s, more than is left."""
    strong, weak = 100_000.0, 50_000.0
    commands.universal_start(rig.axis, 1, 300.0, V, 3000.0, 3000.0, strong)
    rig.until(lambda axis: axis.set_velocity < 50.0 and axis.set_position > 200.0)
    assert rig.axis.set_acceleration == pytest.approx(-3000.0)
    rig.until(lambda axis: axis.set_velocity < 20.0 or axis.set_acceleration > -3000.0)
    here = rig.axis.set_position
    v, a = rig.axis.set_velocity, rig.axis.set_acceleration
    assert a * a / (2.0 * weak) > v
    assert commands.universal_start(rig.axis, kind, 500.0, V, 3000.0, 3000.0, weak) == 0
    samples = rig.trace(2500)
    assert min(speed for _, speed, _ in samples) >= 0.0
    steps = pairwise(samples)
    assert all(abs(b - a) <= strong * rig.dt * (1.0 + 1e-6) for (_, _, a), (_, _, b) in steps)
    end = samples[-1][0]
    if kind == StartType.ABSOLUTE:
        assert end == 500.0
    elif kind == StartType.HALT:
        assert here <= end <= 300.0 + 1e-9
    else:
        assert samples[-1][1] == V
