"""One run of a program: the reason of each wait, and what ends it."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import NcError
from achse.motion import commands
from achse.motion.channels.states import InterpreterState, ProgramMode
from achse.motion.channels.waits import WAITS, WaitEnd, WaitReason

_W = WaitReason
_LONG = "G1 F600\n" + "\n".join(f"X{n}" for n in range(1, 60)) + "\nM30"

PROGRAMS: dict[WaitReason, str] = {
    _W.TABLE_FULL: _LONG,
    _W.PATH: "G1 X5 F6000\n@714\nM30",
    _W.DELETABLE_MOVE: "G1 X50 F6000 DelDTG\nY10\nM30",
    _W.HANDSHAKE: "M40\nG1 X5 F6000\nM30",
    _W.HOMING: "G74 X\nG1 X5 F6000\nM30",
    _W.EXTERNAL_TRIGGER: "@717\nG1 X5 F6000\nM30",
    _W.PROGRAM_END: "G1 X5 F6000\nM30",
    _W.FAULT: "G1 X5 F6000\nG999\nM30",
    _W.ABORT: _LONG,
    _W.RETRY: "G999",
    _W.STOP: _LONG,
    _W.RESET: _LONG,
    _W.SINGLE_BLOCK: "G1 X5 F6000\nX6\nM30",
}
"""A program that comes to each wait."""

ACTIONS: dict[WaitReason, Callable[[Any], object]] = {
    _W.ABORT: lambda program: commands.set_external_error(program.nc.axis(1), 0x4650),
    _W.STOP: lambda program: program.channel.stop(),
    _W.RESET: lambda program: program.channel.reset(),
}
"""What a program that moves needs for its wait."""

ENDS: dict[WaitReason, Callable[[Any], object]] = {
    _W.HANDSHAKE: lambda program: setattr(program.channel, "granted", 1),
    _W.EXTERNAL_TRIGGER: lambda program: program.channel.go_ahead(),
    _W.SINGLE_BLOCK: lambda program: program.channel.start(),
    _W.RETRY: lambda program: program.channel.reset(),
}
"""What ends a wait that does not end by itself."""


def _wait(program: Any, reason: WaitReason) -> None:
    if reason is _W.SINGLE_BLOCK:
        program.channel.set_operation_mode(ProgramMode.SINGLE_BLOCK)
    assert program.run(PROGRAMS[reason]) == 0
    if reason in ACTIONS:
        program.cycle(100)
        ACTIONS[reason](program)
    program.until(lambda: program.channel.waiting is reason)


@pytest.mark.parametrize("reason", PROGRAMS)
def test_wait_shows_its_state_and_ends_as_its_row_says(program: Any, reason: WaitReason) -> None:
    _wait(program, reason)
    channel, row = program.channel, WAITS[reason]
    assert channel.state is row.state
    if row.ended_by in (WaitEnd.FUNCTION, WaitEnd.PLC):
        program.cycle(500)
        assert channel.waiting is reason
        ENDS[reason](program)
    program.until(lambda: channel.waiting is not reason)
    if row.then is not None:
        program.until(lambda: channel.waiting is row.then)
        assert channel.state is WAITS[row.then].state


def test_found_block_is_left_by_step_on_alone(program: Any) -> None:
    channel = program.channel
    program.write("N10 G1 X0 F6000\nN20 X5\nM30")
    assert channel.waiting is _W.LOAD
    channel.load("part.nc")
    assert channel.waiting is _W.START
    assert channel.step_on_after_search() == NcError.CHANNEL_COMMAND_NOT_NOW
    assert channel.enable_search(1, 1, 20, 0.0) == 0
    assert channel.start() == 0
    program.until(lambda: channel.waiting is _W.FOUND_BLOCK)
    program.cycle(200)
    assert (channel.waiting, channel.state) == (_W.FOUND_BLOCK, InterpreterState.SEARCHING)
    assert channel.start() == NcError.CHANNEL_NOT_READY
    assert channel.step_on_after_search() == 0
    program.finish()
    assert program.at()[0] == 5.0


def test_external_trigger_may_come_before_the_stop_is_reached(program: Any) -> None:
    program.run("G1 X20 F6000\n@717\nX25\nM30")
    program.until(lambda: program.channel.waiting is _W.PATH)
    assert program.channel.go_ahead() == 0
    seen = set()
    while program.channel.state is not InterpreterState.READY:
        program.cycle()
        seen.add(program.channel.waiting)
    assert _W.EXTERNAL_TRIGGER not in seen
    assert program.at()[0] == 25.0


def test_trigger_without_its_stop_is_refused(program: Any) -> None:
    assert program.channel.go_ahead() == NcError.CHANNEL_NO_DECODER_STOP
    program.run("M40\n@717\nM30")
    program.until(lambda: program.channel.waiting is _W.HANDSHAKE)
    assert program.channel.go_ahead() == NcError.CHANNEL_NO_DECODER_STOP
