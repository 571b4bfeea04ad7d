"""What an axis has accepted: numbers, states, a full buffer."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import BufferMode, StateBit, commands
from achse.motion.fields.setpoint import COMMAND_BUFFER

V = 200.0


def refused(rig: Any, code: int, error: NcError) -> None:
    assert NcError.of(code) is error, hex(code)


def test_the_job_shows_before_the_next_cycle(rig: Any) -> None:
    commands.start(rig.axis, 1, 100.0, V)
    assert rig.has(StateBit.HAS_JOB)
    assert not rig.has(StateBit.IN_TARGET_POSITION)


def test_a_full_buffer(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    for n in range(COMMAND_BUFFER):
        assert commands.universal_start(rig.axis, 2, 1.0 + n, V, buffer_mode=1) == 0
    full = commands.universal_start(rig.axis, 2, 1.0, V, buffer_mode=1)
    refused(rig, full, NcError.COMMAND_BUFFER_FULL)
    rig.until(lambda axis: axis.set_motion_phase == 0 and axis.buffer_count == 0)
    assert rig.axis.set_position == pytest.approx(100.0 + sum(range(1, COMMAND_BUFFER + 1)))


def test_an_aborting_command_empties_the_buffer(rig: Any) -> None:
    commands.universal_start(rig.axis, 1, 100.0, V)
    commands.universal_start(rig.axis, 1, 200.0, V, buffer_mode=BufferMode.BUFFERED)
    commands.universal_start(rig.axis, 1, 50.0, V)
    rig.until_rest()
    rig.seconds(1.0)
    assert rig.axis.set_position == 50.0


def test_command_numbers_are_16_bits_and_never_zero(rig: Any) -> None:
    rig.axis.command_counter = 0xFFFF
    commands.universal_start(rig.axis, 1, 1.0, V)
    assert rig.axis.command_counter == 1
