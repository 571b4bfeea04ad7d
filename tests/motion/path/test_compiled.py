"""The kernel of the path in machine code gives the bits of plain Python."""

import random

import pytest

from achse.motion.path import (
    PathDwell,
    PathLimits,
    PathLine,
    PathParameters,
    PathPlanner,
    Smoothing,
)
from achse.motion.path.compiled import KERNEL

pytestmark = pytest.mark.skipif(not KERNEL.available, reason="llvmlite is not installed")


def test_the_same_path_has_the_same_bits_in_both_forms() -> None:
    draw = random.Random(7)
    axes = [PathLimits(200.0, 1000.0, 20000.0) for _ in range(4)]
    plain, compiled = (PathPlanner(axes, [0.0] * 4, compiled=form) for form in (False, True))
    for n in range(12):
        end = [draw.uniform(-20.0, 20.0) for _ in range(4)]
        parameters = PathParameters(
            keep_jerk=draw.random() < 0.7,
            smoothing=draw.choice(list(Smoothing)),
            smoothing_radius=0.7,
        )
        dwells = draw.random() < 0.2
        for path in (plain, compiled):
            path.parameters = parameters
            path.append(PathLine(end, 100.0, block=n))
            if dwells:
                path.append(PathDwell(0.003))
    cycles = 0
    while not plain.finished:
        if cycles % 97 == 0:
            plain.override = compiled.override = draw.uniform(0.2, 1.0)
        plain.advance()
        compiled.advance()
        cycles += 1
        assert plain.position == compiled.position
        assert plain.axis_velocity == compiled.axis_velocity
        assert plain.axis_acceleration == compiled.axis_acceleration
        assert plain.block == compiled.block
    assert compiled.finished
    assert cycles > 100
