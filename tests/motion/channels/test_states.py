"""The table of transitions: every pair of state and event is tried."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.motion import commands
from achse.motion.channels.states import (
    ACTIVE_STATES,
    TRANSITIONS,
    InterpreterEvent,
    InterpreterState,
    ProgramMode,
)


@pytest.mark.parametrize("state", InterpreterState)
@pytest.mark.parametrize("event", InterpreterEvent)
def test_every_pair(state: InterpreterState, event: InterpreterEvent) -> None:
    after = TRANSITIONS.get((state, event))
    if event is InterpreterEvent.RESET:
        assert after is InterpreterState.RESETTING
    elif event is InterpreterEvent.STOP:
        stops = state in ACTIVE_STATES or state is InterpreterState.ABORTING
        assert after is (InterpreterState.STOPPING if stops else None)
    elif event is InterpreterEvent.LOAD:
        loads = state in (InterpreterState.IDLE, InterpreterState.READY)
        assert after is (InterpreterState.READY if loads else None)
    elif event is InterpreterEvent.FAIL:
        assert (after is InterpreterState.ABORTING) == (state in ACTIVE_STATES)
    elif event is InterpreterEvent.START:
        assert (after is not None) == (
            state in (InterpreterState.READY, InterpreterState.SINGLE_STOP)
        )
    else:
        assert after is None or state is not InterpreterState.INITIALISATION_FAILED


def test_numbers_of_the_public_pages() -> None:
    assert [state.value for state in InterpreterState] == list(range(18))


_S, _E = InterpreterState, InterpreterEvent
_LONG = "G1 F600\n" + "\n".join(f"X{n}" for n in range(1, 60)) + "\nM30"


def _begin(program: Any, text: str = _LONG, **settings: Any) -> None:
    for name, value in settings.items():
        setattr(program.channel, name, value)
    assert program.run(text) == 0


def _fault(program: Any) -> None:
    commands.set_external_error(program.nc.axis(1), 0x4650)


def _searching(program: Any) -> None:
    program.write("N10 R1=R1+1\n@100 K-10\nN20 X5")
    assert program.channel.load("part.nc") == 0
    assert program.channel.enable_search(1, 1, 20, 0.0) == 0
    assert program.channel.start() == 0


def _moving(program: Any, act: Callable[[], object]) -> None:
    _begin(program)
    program.cycle(100)
    act()


_WAYS: dict[InterpreterState, Callable[[Any], object]] = {
    _S.IDLE: lambda program: None,
    _S.READY: lambda program: (program.write(_LONG), program.channel.load("part.nc")),
    _S.STARTED: _begin,
    _S.RUNNING: lambda program: _begin(program, "N10 H1\n@100 K-10"),
    _S.TABLE_FULL: _begin,
    _S.SEARCHING: _searching,
    _S.END: lambda program: _begin(program, "G1 X10 F600\nM30"),
    _S.SINGLE_STOP: lambda program: _begin(program, operation_mode=ProgramMode.SINGLE_BLOCK),
    _S.WAITING: lambda program: _begin(program, "M40\nG1 X10 F600\nM30"),
    _S.ABORTING: lambda program: _moving(program, lambda: _fault(program)),
    _S.ABORTED: lambda program: _begin(program, "G999"),
    _S.STOPPING: lambda program: _moving(program, program.channel.stop),
    _S.RESETTING: lambda program: _moving(program, program.channel.reset),
}
"""How a channel gets into each state that it can be in."""


@pytest.mark.parametrize("state", _WAYS)
@pytest.mark.parametrize("event", [_E.LOAD, _E.START, _E.STOP, _E.RESET, _E.FAIL])
def test_every_command_in_every_state(
    program: Any, state: InterpreterState, event: InterpreterEvent
) -> None:
    """What the table says happens at once; what it does not say changes nothing."""
    channel = program.channel
    _WAYS[state](program)
    program.until_state(state)
    expected = TRANSITIONS.get((state, event), state)
    if event is _E.FAIL:
        _fault(program)
        if state in ACTIVE_STATES and state is not _S.SEARCHING:  # a search moves nothing
            program.until(lambda: channel.state in (_S.ABORTING, _S.ABORTED), 5.0)
        elif state in (_S.IDLE, _S.READY, _S.ABORTED):
            program.cycle(5)
            assert channel.state is state
        return
    act = {
        _E.LOAD: lambda: channel.load("part.nc"),
        _E.START: channel.start,
        _E.STOP: channel.stop,
        _E.RESET: channel.reset,
    }[event]
    if event is _E.LOAD:
        program.write(_LONG)
    code = act()
    if (state, event) in TRANSITIONS:
        assert code == 0
        after = {expected, _S.IDLE} if event is _E.RESET else {expected}
        assert channel.state in after
    else:
        assert channel.state is state
        assert code or event is _E.STOP
