"""The origin of positions and the homed flag."""

from math import nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StateBit, commands

V = 200.0


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


@pytest.mark.parametrize(
    ("kind", "value", "before", "after"),
    [(1, 50.0, 10.0, 50.0), (2, 5.0, 10.0, 15.0), (5, 20.0, 730.0, 740.0)],
)
def test_set_actual_position(
    rig: Any, kind: int, value: float, before: float, after: float
) -> None:
    commands.start(rig.axis, 1, before, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert commands.set_actual_position(rig.axis, kind, value) == 0
    rig.run(50)
    assert rig.axis.actual_position == pytest.approx(after, abs=1e-9)
    assert rig.axis.set_position == pytest.approx(after, abs=1e-9)
    assert rig.axis.actual_velocity == 0.0
    assert rig.has(StateBit.IN_TARGET_POSITION)
    commands.start(rig.axis, 1, 0.0, V)
    rig.until_rest()
    assert rig.axis.set_position == 0.0


def test_actual_positions_that_cannot_be_set(make_rig: Any) -> None:
    rig = make_rig()
    out_of_range = NcError.ENCODER_SET_POSITION_RANGE
    rig.refuses(out_of_range, commands.set_actual_position, 1, 1e11)
    rig.refuses(out_of_range, commands.set_actual_position, 1, nan)
    rig.refuses(NcError.JOB_START_TYPE, commands.set_actual_position, 3, 1.0)
    absolute = make_rig(encoder_is_absolute=1)
    code = commands.set_actual_position(absolute.axis, 1, 1.0)
    refused(absolute, code, NcError.FUNCTION_NOT_ALLOWED)


def test_the_homed_flag(rig: Any) -> None:
    assert commands.set_homed_flag(rig.axis, 1) == 0
    rig.run(1)
    assert rig.has(StateBit.HOMED)
    rig.refuses(NcError.ENCODER_HOMED_FLAG, commands.set_homed_flag, 2)
