"""ProgramRun: one run of a part program, from its start to its end or fault.

In each cycle the interpreter gives commands as long as they can be carried out; the first that
cannot waits for the next cycle, and the channel shows its reason (`achse.motion.channels.waits`).
"""

import logging

from achse.codes import NcError
from achse.gcode.canon import (
    Canonical,
    DecoderStop,
    Origin,
    ProgramEnd,
    ProgramStop,
    StopKind,
)
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.line_run import LineRun
from achse.motion.channels.feeder import Feeder, FeedOutcome
from achse.motion.channels.program_fault import (
    ProgramFault,
    named_block,
    named_position,
    refusal,
)
from achse.motion.channels.program_states import ProgramStates
from achse.motion.channels.states import InterpreterEvent, InterpreterState
from achse.motion.channels.waits import WaitReason
from achse.motion.checks import OK
from achse.motion.groups.path_group import PathGroup

log = logging.getLogger("achse.channel")

_COMMANDS_PER_CYCLE = 64
"""Commands that one cycle carries out at most, besides the limit of segments (0x514)."""

_LINES_PER_CYCLE = 200
"""Lines of the program that one cycle runs at most: loops without an end cost no more."""

_FEWEST_LINES = 2
"""Fewer lines at once cost more than one by one."""

_NEAR = 0.01
"""Distance of the axes from the start of a block search, mm, that is still at it."""

_E, _W = InterpreterEvent, WaitReason


class ProgramRun:
    """The commands of one run on their way from the interpreter to the path."""

    def __init__(
        self,
        channel: ProgramStates,
        group: PathGroup,
        interpreter: Interpreter,
        feeder: Feeder,
        *,
        steps_on: bool = False,
    ) -> None:
        """`steps_on` lets a search go on by itself where the axes are at the found block."""
        self.interpreter = interpreter
        self.feeder = feeder
        self.released = False
        """True once the function that ends the present wait was called."""
        self._channel = channel
        self._group = group
        self._steps_on = steps_on
        self._command: Canonical | None = None
        """Command that could not be carried out in the last cycle."""
        self._lines: LineRun | None = None
        """Lines that are on their way to the path, all before `_command`."""
        self._refused: ProgramFault | None = None
        """A fault that ends the program once the moves before it are made."""

    @property
    def waits_for_trigger(self) -> bool:
        """True if the command to come is a decoder stop with external trigger."""
        stop = self._command
        return isinstance(stop, DecoderStop) and stop.kind is StopKind.EXTERNAL

    def step_on(self) -> int:
        """Go on with the found block: 0x4171 if the axes are elsewhere, 0x4109 without one."""
        group, result = self._group, self._channel.search_result
        if self._channel.state is not InterpreterState.SEARCHING or result is None:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        for axis, place in zip(group.places, result.position, strict=False):
            if axis is not None and abs(axis.set.position - place) > _NEAR:
                return NcError.START_NOT_ON_CONTOUR
        code = group.begin()
        if code:
            return code
        self.released = True
        return OK

    def fault_at(self, code: int, origin: Origin) -> ProgramFault:
        """Return a fault of this run at a block, with the R parameters of the first fault."""
        refused = self._refused
        registers = self._channel.data.registers.own if refused is None else refused.registers
        return ProgramFault(code, origin, origin, tuple(registers))

    def step(self, granted: int) -> ProgramEnd | ProgramFault | None:
        """Work for one cycle; return the end or the fault that ends the run.

        `granted` is the M function that the PLC acknowledges.
        """
        feeder, channel = self.feeder, self._channel
        feeder.granted = granted
        feeder.pass_marks()
        if self._refused is None:
            feeder.begin_cycle()
            try:
                end = self._feed()
            except GcodeError as refused:
                registers = tuple(channel.data.registers.own)
                self._refuse(refusal(refused, self.interpreter, registers))
            else:
                if end is not None:
                    return end
        return None if self._refused is None else self._finish_moves(self._refused)

    def _feed(self) -> ProgramEnd | None:
        channel, feeder, interpreter = self._channel, self.feeder, self.interpreter
        if channel.state is InterpreterState.SINGLE_STOP:
            return None
        last_step = interpreter.steps + _LINES_PER_CYCLE
        for _ in range(_COMMANDS_PER_CYCLE):
            if self._command is None and not self._feed_lines():
                return None
            if self._command is None:
                self._command = interpreter.advance(last_step - interpreter.steps)
            command = self._command
            if command is None:
                self._without_command()
                return None
            fed = feeder.feed(command)
            if fed is FeedOutcome.DONE:
                self._log(command)
            if fed is FeedOutcome.REFUSED:
                self._refuse(self.fault_at(feeder.error, command.origin))
                return None
            if fed is FeedOutcome.FULL:
                channel.wait(_W.TABLE_FULL)
                return None
            if fed is FeedOutcome.WAITS:
                at_end = isinstance(command, ProgramEnd)
                channel.wait(_W.PROGRAM_END if at_end else feeder.waits_for)
                self._show_single_block()
                return None
            if isinstance(command, DecoderStop):
                if not self._pass_stop(command):
                    return None
            elif isinstance(command, ProgramStop):
                self._command = None
                channel.wait(_W.SINGLE_BLOCK)
                return None
            elif isinstance(command, ProgramEnd):
                return command
            self._command = None
            channel.waiting = None
            if channel.state is not InterpreterState.SEARCHING:
                channel.happens(_E.RUN)
        self._show_single_block()
        return None

    def _feed_lines(self) -> bool:
        """Feed lines in a row at once. Return True if there may be more in this cycle."""
        channel, feeder, run = self._channel, self.feeder, self._lines
        if run is None:
            if feeder.room < _FEWEST_LINES or channel.trace_mode or channel.feeder_log_enable:
                return True
            run = self._lines = self.interpreter.lines(feeder.room)
            if run is None:
                return True
        fed = feeder.feed_lines(run)
        if fed is FeedOutcome.REFUSED:
            self._refuse(self.fault_at(feeder.error, run.origin(run.taken)))
            return False
        if run.taken == len(run):
            self._lines = None
        if fed is FeedOutcome.DONE:
            channel.waiting = None
            channel.happens(_E.RUN)
            return True
        channel.wait(_W.TABLE_FULL)
        return False

    def _log(self, command: Canonical) -> None:
        """Log what parameters 0x08 and 0x0A request."""
        channel, origin = self._channel, command.origin
        if channel.trace_mode:
            text = channel.line_at(origin.index) if channel.trace_mode > 1 else ""
            log.info("channel %d: %s:%d %s", channel.channel_id, origin.program, origin.line, text)
        if channel.feeder_log_enable:
            log.info("channel %d: %s", channel.channel_id, command)

    def _show_single_block(self) -> None:
        """Wait where the path rests at a segment's end: single block in the set-point task."""
        if self._group.at_block_end:
            self._channel.wait(_W.SINGLE_BLOCK)

    def _without_command(self) -> None:
        channel, interpreter = self._channel, self.interpreter
        if interpreter.state is not RunState.FOUND:
            self._show_single_block()
            return
        channel.search_result = interpreter.search_result
        channel.wait(_W.FOUND_BLOCK)
        if self._steps_on:
            self._steps_on = False
            self._step_on_or_wait()
        if self.released:
            self.released = False
            interpreter.go_ahead()
            channel.end_wait()
            channel.happens(_E.RUN)

    def _step_on_or_wait(self) -> None:
        """Go on with a retry or skip, or log the place to which the axes have to be brought."""
        channel = self._channel
        code, result = self.step_on(), channel.search_result
        if code and result is not None:
            log.warning(
                "channel %d: waiting at %s (0x%04X): expected axes at %s, they are at %s; "
                "bring them there, then step on (function 0x19)",
                channel.channel_id,
                named_block(result.origin),
                code,
                named_position(result.position),
                named_position(self._group.positions[:3]),
            )

    def _pass_stop(self, stop: DecoderStop) -> bool:
        """Go on behind a decoder stop. Return False if it waits for its external trigger."""
        if stop.kind is StopKind.EXTERNAL and not self.released:
            self._channel.wait(_W.EXTERNAL_TRIGGER)
            return False
        self.released = False
        x, y, z, *auxiliary = self._group.positions
        if stop.kind is StopKind.RESCAN:
            self._group.take_positions()
        if stop.kind in (StopKind.RESCAN, StopKind.READ_POSITIONS):
            self.interpreter.go_ahead((x, y, z), tuple(auxiliary))
        else:
            self.interpreter.go_ahead()
        return True

    def _refuse(self, fault: ProgramFault) -> None:
        """Let the program fail at a block that cannot be run, after the moves before it."""
        self._refused = fault
        log.error("channel %d: %s", self._channel.channel_id, fault)

    def _finish_moves(self, fault: ProgramFault) -> ProgramFault | None:
        """Return the fault once the path is at the begin of its block."""
        if self.feeder.done:
            return fault
        if self._channel.state is not InterpreterState.SINGLE_STOP:
            self._channel.wait(_W.FAULT)
            self._show_single_block()
        return None
