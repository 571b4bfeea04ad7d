"""Reset, errors from outside, enables."""

from math import sqrt
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import StartType, StateBit, commands

V = 200.0


def test_an_axis_in_error_answers_its_error(rig: Any) -> None:
    assert commands.set_external_error(rig.axis, NcError.DRIVE_IO_INVALID.number) == 0
    rig.run(1)
    assert rig.has(StateBit.ERROR)
    assert commands.start(rig.axis, 1, 10.0, V) == NcError.DRIVE_IO_INVALID.number
    assert (
        commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0)
        == NcError.DRIVE_IO_INVALID.number
    )
    assert commands.reset(rig.axis) == 0
    assert not rig.has(StateBit.ERROR)
    assert commands.start(rig.axis, 1, 10.0, V) == 0
    assert rig.axis.reset_command_counter == 1
    rig.refuses(NcError.REQUEST_PARAMETER, commands.set_external_error, 0)


def test_reset_during_a_move_stops_abruptly(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    p = rig.axis.set_position
    commands.reset(rig.axis)
    rig.run(1)
    assert (rig.axis.set_position, rig.axis.set_velocity) == (p, 0.0)
    assert not rig.has(StateBit.HAS_JOB)


def test_a_disabled_axis_takes_no_command(rig: Any) -> None:
    commands.disable(rig.axis)
    rig.run(1)
    assert not rig.has(StateBit.CONTROL_LOOP_CLOSED)
    rig.refuses(NcError.AXIS_NOT_READY, commands.start, 1, 1.0, V)
    rig.refuses(NcError.AXIS_NOT_READY, commands.universal_start, 8192, 1.0, V)
    commands.enable(rig.axis)
    assert commands.start(rig.axis, 1, 1.0, V) == 0


def test_the_drive_output_can_be_switched_off(rig: Any) -> None:
    commands.set_drive_output(rig.axis, False)
    rig.run(1)
    assert not rig.has(StateBit.OPERATIONAL)
    rig.refuses(NcError.CONTROLLER_ENABLE_MISSING, commands.start, 1, 1.0, V)
    commands.set_drive_output(rig.axis, True)
    rig.run(1)
    assert rig.has(StateBit.OPERATIONAL)


def test_an_error_from_outside_brakes_the_axis_with_its_strongest_ramp(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 1000.0, V, 900.0, 900.0, 1000.0)
    commands.universal_start(rig.axis, 1, 2000.0, V, buffer_mode=1)
    rig.seconds(1.5)
    assert rig.axis.set_velocity == V
    begin = rig.axis.set_position
    assert commands.set_external_error(rig.axis, 0x4A00) == 0
    rig.run(1)
    assert rig.has(StateBit.ERROR)
    assert not rig.has(StateBit.HAS_JOB)
    assert not rig.has(StateBit.COMMAND_BUFFERED)
    assert rig.has(StateBit.CONTROL_LOOP_CLOSED)
    time = 2.0 * sqrt(V / rig.axis.default_jerk)  # 1500 mm/s² are not reached
    assert abs(rig.until_rest() + 1 - time / rig.dt) < 1.001
    assert rig.axis.set_position == pytest.approx(begin + 0.5 * V * time)
    assert commands.start(rig.axis, 1, 0.0, V) == 0x4A00
    commands.reset(rig.axis)
    assert commands.start(rig.axis, 1, 0.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 0.0
