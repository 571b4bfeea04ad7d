"""G74 that is interrupted: the axis stops, no other program leaves it out, a retry homes it."""

from typing import Any

import pytest

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.gcode.canon import StopKind
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.search import BlockSearch, DryRun, SearchMode
from achse.gcode.text.program import PartProgram
from achse.motion import commands
from achse.motion.channels.states import InterpreterState as State

HOMES = "N10 G01 X10 Y0 F6000\nN20 G74 X\nN30 X5\nM30\n"


@pytest.fixture
def homing(program: Any) -> Any:
    assert program.run(HOMES) == 0
    axis = program.nc.axis(1)
    program.until(lambda: axis.set_motion_phase == MotionPhase.HOMING)
    program.cycle(100)
    assert axis.set_velocity != 0.0
    return program


def _runs(program: Any) -> None:
    """The next program moves all axes."""
    assert program.run("N1 G1 X3 Y4 F3000\nM30") == 0
    program.finish()
    assert program.at() == [3.0, 4.0, 0.0]


@pytest.mark.parametrize("function", ["stop", "reset"])
def test_a_stop_and_a_reset_stop_the_axis_that_homes(homing: Any, function: str) -> None:
    axis, channel = homing.nc.axis(1), homing.channel
    assert getattr(channel, function)() == 0
    velocity, most = axis.set_velocity, 0.0
    while axis.set_motion_phase:
        homing.cycle()
        most = max(most, abs(axis.set_velocity - velocity))
        velocity = axis.set_velocity
    assert most <= axis.max_deceleration * 0.002
    homing.until_state(State.IDLE)
    assert not axis.homed
    channel.reset()
    homing.until_state(State.IDLE)
    _runs(homing)


def test_an_emergency_stop_ends_the_program(homing: Any) -> None:
    """The axis is not homed, so the program cannot go on; a retry homes it again."""
    assert homing.group.emergency_stop(1e4, 1e6) == 0
    homing.until_state(State.ABORTED)
    assert homing.channel.error_code == NcError.GROUP_CONSEQUENTIAL_ERROR
    homing.cycle(100)
    assert not homing.nc.axis(1).set_motion_phase
    assert homing.group.reset() == 0
    assert homing.channel.retry() == 0
    homing.until(lambda: homing.channel.state is State.SEARCHING)
    homing.cycle(5)
    if homing.channel.state is State.SEARCHING:  # it is not where the block begins
        assert homing.group.dissolve() == 0
        x = homing.channel.search_result.position[0]
        assert commands.start(homing.nc.axis(1), 1, x, 100.0) == 0
        homing.until(lambda: not homing.nc.axis(1).set_motion_phase)
        assert homing.group.assign([1, 2, 3]) == 0
        assert homing.channel.step_on_after_search() == 0
    homing.finish()
    assert homing.nc.axis(1).homed
    assert homing.at() == [5.0, 0.0, 0.0]


def test_a_stop_of_the_axis_does_not_home_it(homing: Any) -> None:
    assert commands.stop(homing.nc.axis(1)) == 0
    homing.until_state(State.ABORTED)
    assert not homing.nc.axis(1).homed
    homing.channel.reset()
    homing.until_state(State.IDLE)
    _runs(homing)


def test_the_program_waits_until_the_application_has_homed_the_axis(program: Any) -> None:
    axis = program.nc.axis(1)
    axis.encoder.reference_mode = 20
    assert program.run(HOMES) == 0
    program.until(lambda: axis.application_request)
    program.cycle(200)
    assert program.at()[0] == 10.0
    assert commands.set_homed_flag(axis, 1) == 0
    program.finish()
    assert program.at()[0] == 5.0
    assert program.run(HOMES) == 0
    program.until(lambda: axis.application_request)
    assert program.channel.stop() == 0
    program.until_state(State.IDLE)
    assert not axis.application_request


@pytest.mark.parametrize("dry_run", list(DryRun))
def test_a_block_that_stops_the_decoder_is_found(dry_run: DryRun) -> None:
    """G74 homes and reads the positions: both come behind the search."""
    run = Interpreter(PartProgram("N10 G1 X10 F600\nN20 G74 X\nN30 X5\nM30"))
    run.search(BlockSearch(SearchMode.BLOCK_NUMBER, 20, dry_run))
    while run.advance() is not None or run.state is RunState.RUNNING:
        pass
    assert run.state is RunState.FOUND
    run.go_ahead()
    assert run.state is RunState.DECODER_STOP
    names = [type(run.advance()).__name__ for _ in range(2)]
    assert names == ["HomeAxis", "DecoderStop"]
    assert run.stop is not None
    assert run.stop.kind is StopKind.RESCAN
    run.go_ahead((0.0, 0.0, 0.0), (0.0,) * 5)
    move = run.advance()
    assert move is not None
    assert move.origin.block == 30
