"""Stops, halts and the lock."""

from math import nan
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import CommandState, StartType, StateBit, commands

V = 200.0


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


def test_stop_and_lock_holds_the_axis_until_released(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    assert commands.universal_start(rig.axis, StartType.STOP_AND_LOCK, 0.0, 0.0) == 0
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED)
    locked = NcError.AXIS_LOCKED_BY_STOP
    rig.refuses(locked, commands.universal_start, 1, 0.0, V)
    rig.refuses(locked, commands.universal_start, StartType.HALT, 0.0, 0.0)
    rig.until_rest()
    rig.run(1)
    assert rig.has(StateBit.MOTION_COMMANDS_LOCKED)
    rig.refuses(locked, commands.start, 1, 0.0, V)
    assert commands.release_lock(rig.axis) == 0
    assert commands.start(rig.axis, 1, 0.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 0.0


def test_halt_can_be_aborted(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    assert commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0) == 0
    rig.run(5)
    assert rig.has(StateBit.HAS_BEEN_STOPPED)
    assert commands.universal_start(rig.axis, 1, 500.0, V) == 0
    rig.until_rest()
    assert rig.axis.set_position == 500.0
    assert not rig.has(StateBit.HAS_BEEN_STOPPED)


def test_a_halt_is_a_command_with_number_and_state(rig: Any) -> None:
    commands.universal_start(rig.axis, 3, 0.0, V)
    rig.seconds(0.5)
    commands.universal_start(rig.axis, StartType.HALT, 0.0, 0.0)
    assert rig.axis.set_command_number == rig.axis.command_counter == 2
    assert rig.axis.set_command_state == CommandState.ACTIVE
    rig.until_rest()
    assert rig.axis.set_command_state == CommandState.DONE


def test_an_emergency_stop_is_no_weaker_than_the_move(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    for data in ((1000.0, 3000.0), (3000.0, 2000.0), (0.0, 3000.0), (3000.0, nan)):
        rig.refuses(NcError.EMERGENCY_STOP_DATA, commands.emergency_stop, *data)
    begin = rig.axis.set_position
    assert commands.emergency_stop(rig.axis, 4000.0, 80000.0) == 0
    rig.until_rest()
    time = V / 4000.0 + 4000.0 / 80000.0
    assert rig.axis.set_position - begin == pytest.approx(V * time / 2.0)


def test_a_parameterized_stop_has_its_own_ramp(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    zero = commands.parameterized_stop(rig.axis, 0.0, 1.0)
    refused(rig, zero, NcError.DECELERATION_NOT_POSITIVE)
    begin = rig.axis.set_position
    assert commands.parameterized_stop(rig.axis, 100.0, 1000.0) == 0
    rig.until_rest()
    time = V / 100.0 + 100.0 / 1000.0
    assert rig.axis.set_position - begin == pytest.approx(V * time / 2.0)


def test_a_running_stop_is_not_weakened(rig: Any) -> None:
    commands.start(rig.axis, 3, 0.0, V)
    rig.seconds(1.0)
    begin = rig.axis.set_position
    commands.emergency_stop(rig.axis, 4000.0, 80000.0)
    rig.run(1)
    commands.parameterized_stop(rig.axis, 10.0, 10.0)
    rig.until_rest()
    assert rig.axis.set_position - begin == pytest.approx(V * 0.1 / 2.0)
