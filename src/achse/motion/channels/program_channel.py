"""ProgramChannel: a channel with an interpreter, which runs part programs on its 3D group.

One cycle: the interpreter is asked for commands as long as they can be carried out, the group moves
along its path, the PLC sees what the program tells it. Functions answer 0 or the NC error that
refuses them; they carry the index offset of 0x2200 + channel id (002 §6.4.2.3).
"""

import logging
from collections.abc import Iterable
from dataclasses import replace

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
from achse.gcode.interpreter import Interpreter, RunState
from achse.gcode.line_run import LineRun
from achse.gcode.modal import ModalState
from achse.gcode.program import PartProgram
from achse.gcode.search import BlockSearch, DryRun, SearchMode
from achse.motion.channels.feeder import Fed, Feeder
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_fault import (
    ProgramFault,
    named_block,
    named_position,
    refusal,
)
from achse.motion.channels.program_states import ProgramStates
from achse.motion.channels.states import (
    ACTIVE_STATES,
    TRANSITIONS,
    InterpreterEvent,
    InterpreterState,
    ProgramMode,
)
from achse.motion.channels.technology import TechnologyOutputs
from achse.motion.checks import OK
from achse.motion.groups.group import AxisGroup

__all__ = ["LOAD_BUFFER", "ProgramChannel"]

log = logging.getLogger("achse.channel")

LOAD_BUFFER = 1 << 24
"""Longest program, bytes (0x2000+ID:0x05); longer ones are 0x4114."""

_COMMANDS_PER_CYCLE = 64
"""Commands that one cycle carries out at most, besides the limit of segments (0x514)."""

_FEWEST_LINES = 2
"""Fewer lines at once cost more than one by one."""

_E = InterpreterEvent


class ProgramChannel(ProgramStates):
    """A channel with an interpreter. `skip_mask` and `granted` come from the PLC."""

    def __init__(
        self,
        parameters: ChannelParameters,
        groups: Iterable[AxisGroup],
        shared_registers: list[float] | None = None,
    ) -> None:
        super().__init__(parameters, groups, shared_registers)
        self.operation_mode = ProgramMode.DEFAULT
        self.error_code = OK
        self.text_index = 0
        self.program_number = 0
        self.outputs = TechnologyOutputs()
        self.granted = 0
        self.readout = 0
        """1: modal words, shifts and rotation are shown (0x53)."""
        self.load_log_mode = self.trace_mode = self.feeder_log_enable = 0
        self.nc_logger_level = 0
        self.whole_offsets: tuple[int, ...] = (0, 0, 0, 0)
        self.real_offsets: tuple[int, ...] = (0, 0, 0, 0)
        """Group states that the cyclic structure shows (0x55, 0x56)."""
        self.tolerance_balls = [0.0] * 9
        """Radius by group of the channel, mm; kept only, auxiliary axes go with the path."""
        self.modal = ModalState()
        """What is valid, of the last program too."""
        self.search_wanted: BlockSearch | None = None
        self._next: Canonical | None = None
        self._lines: LineRun | None = None
        """Lines that are on their way to the path, all before `_next`."""
        self._go_ahead = False
        self._step_on = False
        self._resumes = False
        """A retry or skip is under way: it goes on by itself where the axes are at the block."""
        self._refused: ProgramFault | None = None
        """A fault that ends the program once the moves before it are made."""
        self._registers: list[float] = []
        """R parameters as the program began."""

    # state machine

    def _happens(self, event: InterpreterEvent) -> bool:
        """Change the state as the table says; whether there is a row."""
        state = TRANSITIONS.get((self.state, event))
        if state is None:
            return False
        self.state = state
        return True

    @property
    def running(self) -> bool:
        """Whether it needs its cycle."""
        return self.state in ACTIVE_STATES or self.state in (
            InterpreterState.ABORTING,
            InterpreterState.STOPPING,
            InterpreterState.RESETTING,
        )

    # functions

    def load(self, name: str) -> int:
        """Load a program by name (0x04); 0x4110 if there is none, 0x4119 for a name too long."""
        return self._load(name, 0)

    def load_number(self, number: int) -> int:
        """Load the program `<number>.nc` (0x01)."""
        return self._load(f"{number}.nc", number)

    def _load(self, name: str, number: int) -> int:
        if (self.state, _E.LOAD) not in TRANSITIONS:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        try:
            path = self.files.store.path_of(name)
            if path.stat().st_size > LOAD_BUFFER:
                return NcError.LOAD_BUFFER_TOO_SMALL
            program = PartProgram.load(path)
        except GcodeError as refused:
            return refused.code
        except OSError:
            return NcError.PROGRAM_OPEN
        if self.load_log_mode:
            for line, text in enumerate(program.lines, 1):
                log.info("channel %d: load %s:%d %s", self.channel_id, program.name, line, text)
        self.program, self._file, self.program_number = program, path, number
        self.text_index = 0
        self._planned = None
        self._happens(_E.LOAD)
        return OK

    def start(self) -> int:
        """Start the program, or the next single block (0x02); 0x42C5 after a stop."""
        if self.state is InterpreterState.SINGLE_STOP:
            self._step_single()
            return OK
        if self.state is not InterpreterState.READY:
            after = self.state in (InterpreterState.IDLE, InterpreterState.ABORTED)
            if after and self.program is not None:
                return NcError.NCI_RESET_NEEDED
            return NcError.CHANNEL_NOT_READY
        return self._start(_E.START if self.search_wanted is None else _E.SEARCH)

    def retry(self) -> int:
        """After a fault, run the block at fault again and go on from there (0x12).

        The program runs up to it without motion, with the R parameters that it began with, but for
        those that a client has changed since the fault. After a fault of the program the axes are
        at the begin of the block. Where they are not, the channel waits as after a block search
        (`place`) until they are brought there (0x19). 0x4109 without a fault; errors of axes have
        to be reset before.
        """
        return self._resume(skip=False)

    def skip(self) -> int:
        """The same, but the block at fault is left out (0x13)."""
        return self._resume(skip=True)

    def _resume(self, *, skip: bool) -> int:
        fault, group = self.fault, self.group
        if self.state is not InterpreterState.ABORTED or fault is None or group is None:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        group.error_code = OK
        code = group.why_not_move()
        if code:
            return code
        own = self.data.registers.own
        own[:] = fault.registers_of_retry(self._registers, own)
        self.search_wanted = BlockSearch(SearchMode.ENTRY_COUNTER, fault.resumes_at(skip=skip))
        code = self._start(_E.RETRY)
        if code == OK and self.interpreter is not None and skip:
            origin = fault.origin
            self.interpreter.left_out = (origin.counter, origin.program, origin.line)
        return code

    def _start(self, event: InterpreterEvent) -> int:
        group, program = self.group, self.program
        if group is None or program is None:
            return NcError.CHANNEL_NOT_READY
        if event is _E.START:
            code = group.begin()
            if code:
                return code
        group.channel_single_block = self.operation_mode == ProgramMode.SINGLE_BLOCK
        self.data.single_block = self.operation_mode == ProgramMode.SINGLE_BLOCK_INTERPRETER
        self.data.subroutines = self.files.store.subroutines(self._file)
        self._registers = list(self.data.registers.own)
        x, y, z, *auxiliary = self._began_at if event is _E.RETRY else group.positions
        if self._planned is not None and self._planned.begin != (x, y, z, *auxiliary):
            self._planned = None
        self._began_at = (x, y, z, *auxiliary)
        self.interpreter = Interpreter(
            program,
            self.data,
            (x, y, z),
            tuple(auxiliary),
            self.files.default_program() if self.default_g_code else None,
        )
        self.modal = self.interpreter.modal
        self.feeder = Feeder(group, self.outputs)
        self._next, self._lines, self._go_ahead, self._step_on = None, None, False, False
        self._resumes = event is _E.RETRY
        self.found = self.fault = self._refused = None
        self.error_code = OK
        if self.search_wanted is not None:
            self.interpreter.search(self.search_wanted)
            self.search_wanted = None
        self._happens(event)
        return OK

    def _step_single(self) -> None:
        if self.interpreter is not None and self.interpreter.state is RunState.SINGLE_STOP:
            self.interpreter.go_ahead()
        elif self.group is not None:
            self.group.next_block()
        self._happens(_E.RUN)

    def stop(self) -> int:
        """Bring the axes to a halt; the program is over (0x11)."""
        if self._happens(_E.STOP):
            self._end_program()
        return super().stop()

    def reset(self) -> int:
        """End and forget the program, reset errors (0x10)."""
        self._end_program()
        self.error_code = OK
        self.program, self.text_index, self.program_number = None, 0, 0
        self.fault = self._planned = None
        self.outputs.clear()
        self.outputs.drop()
        self.search_wanted = self.found = None
        code = super().reset()
        self._happens(_E.RESET)
        if self._rests:
            self._happens(_E.WAS_RESET)
        return code

    def _end_program(self) -> None:
        if self.feeder is not None:
            self.feeder.finish()
        if self.group is not None and self.group.moving:
            self.group.clear()
        self.feeder = self.interpreter = self._next = self._lines = self._refused = None

    def set_operation_mode(self, mode: int) -> int:
        """Single blocks in the set-point task (1) or the interpreter (0x4000), or none (0x05)."""
        if mode not in list(ProgramMode):
            return NcError.CHANNEL_START_PARAMETER
        self.operation_mode = ProgramMode(mode)
        self.data.single_block = mode == ProgramMode.SINGLE_BLOCK_INTERPRETER
        if self.group is not None and self.state in ACTIVE_STATES:
            self.group.channel_single_block = mode == ProgramMode.SINGLE_BLOCK
        return OK

    def go_ahead(self) -> int:
        """Go on after a decoder stop with external trigger (0x30); 0x410A elsewhere."""
        stop = self._next
        if not isinstance(stop, DecoderStop) or stop.kind is not StopKind.EXTERNAL:
            return NcError.CHANNEL_NO_DECODER_STOP
        self._go_ahead = True
        return OK

    def delete_distance_to_go(self) -> int:
        """End a move that was programmed with DelDTG where it is (0x40); 0x42D4 elsewhere."""
        return NcError.DELETE_DISTANCE_TO_GO if self.feeder is None else self.feeder.delete()

    def enable_search(self, mode: int, dry_run: int, wanted: int, percent: float) -> int:
        """Begin the next start with a search for a block (0x18); mode 0 for none."""
        if self.state in ACTIVE_STATES:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        try:
            search = BlockSearch(SearchMode(mode), wanted, DryRun(dry_run), percent)
        except ValueError:
            return NcError.CHANNEL_START_PARAMETER
        self.search_wanted = None if search.mode is SearchMode.DISABLED else search
        return OK

    def step_on_after_search(self) -> int:
        """Go on with the found block, from where the axes are to be (0x19).

        0x4171 if they are elsewhere.
        """
        group, found = self.group, self.found
        if self.state is not InterpreterState.SEARCHING or found is None or group is None:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        for axis, place in zip(group.places, found.position, strict=False):
            if axis is not None and abs(axis.set_position - place) > _NEAR:
                return NcError.START_NOT_ON_CONTOUR
        code = group.begin()
        if code:
            return code
        self._step_on = True
        return OK

    @property
    def retrace_enable(self) -> int:
        """1: the path of the next start is kept for a way back (0x54)."""
        return int(self.group is not None and self.group.keeps_way_back)

    @retrace_enable.setter
    def retrace_enable(self, on: int) -> None:
        if self.group is not None:
            self.group.keeps_way_back = bool(on)

    def retrace(self, backwards: bool) -> int:
        """After an emergency stop, follow the path back, or forward again (0x14, 0x15).

        0x4109 while no program runs or the path does not rest, 0x42CC if it is not kept.
        """
        if self.state not in ACTIVE_STATES or self.group is None:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        return self.group.way_back.go(backwards)

    def reset_fast(self, number: int) -> int:
        """Clear the bit of a fast M function (0x60)."""
        self.outputs.clear_fast((number,))
        return OK

    # cycle

    def step(self) -> None:
        """One cycle, before the groups have theirs."""
        if self.state in ACTIVE_STATES:
            self._work()
        elif self._rests:
            for event in (_E.FAILED, _E.STOPPED, _E.WAS_RESET):
                if self._happens(event):
                    self._show_stop()
                    break

    def _show_stop(self) -> None:
        """Keep where the axes rest after a fault."""
        fault, group = self.fault, self.group
        if self.state is InterpreterState.ABORTED and fault is not None and group is not None:
            x, y, z, *_ = group.positions
            self.fault = replace(fault, stopped=(x, y, z))
            block, where = named_block(fault.origin), named_position((x, y, z))
            log.info("channel %d: %s: axes at rest at %s", self.channel_id, block, where)

    @property
    def _rests(self) -> bool:
        return not any(group.moving for group in self.groups)

    def _work(self) -> None:
        feeder, group, interpreter = self.feeder, self.group, self.interpreter
        if feeder is None or group is None or interpreter is None:
            return
        if group.error_code or (not group.moving and self.state is not InterpreterState.SEARCHING):
            code = group.error_code or NcError.GROUP_CONSEQUENTIAL_ERROR
            self._fail(self._fault_at(code, feeder.origin or interpreter.origin))
            log.error("channel %d: %s", self.channel_id, self.fault)
            return
        feeder.granted = self.granted
        feeder.pass_marks()
        if self._refused is None:
            feeder.begin_cycle()
            try:
                self._feed(feeder, interpreter)
            except GcodeError as refused:
                self._refuse(refusal(refused, interpreter, tuple(self.data.registers.own)))
        if self._refused is not None:
            self._finish_moves(feeder, self._refused)

    def _feed(self, feeder: Feeder, interpreter: Interpreter) -> None:
        if self.state is InterpreterState.SINGLE_STOP:
            return
        for _ in range(_COMMANDS_PER_CYCLE):
            if self._next is None and not self._feed_lines(feeder, interpreter):
                return
            if self._next is None:
                self._next = interpreter.advance()
            command = self._next
            if command is None:
                self._without_command(interpreter)
                return
            fed = feeder.feed(command)
            if fed is Fed.DONE:
                self._log(command)
            if fed is Fed.REFUSED:
                self._refuse(self._fault_at(feeder.error, command.origin))
                return
            if fed is Fed.FULL:
                self._happens(_E.FULL)
                return
            if fed is Fed.WAITS:
                self._happens(_E.END if isinstance(command, ProgramEnd) else _E.WAIT)
                self._show_single_block()
                return
            if isinstance(command, DecoderStop):
                if not self._pass_stop(command, interpreter):
                    return
            elif isinstance(command, ProgramStop):
                self._next = None
                self._happens(_E.SINGLE)
                return
            elif isinstance(command, ProgramEnd):
                self._finish(command)
                return
            self._next = None
            if self.state is not InterpreterState.SEARCHING:
                self._happens(_E.RUN)
        self._show_single_block()

    def _feed_lines(self, feeder: Feeder, interpreter: Interpreter) -> bool:
        """Lines in a row go over at once; whether there may be more in this cycle."""
        run = self._lines
        if run is None:
            if feeder.room < _FEWEST_LINES or self.trace_mode or self.feeder_log_enable:
                return True
            run = self._lines = interpreter.lines(feeder.room)
            if run is None:
                return True
        fed = feeder.feed_lines(run)
        if fed is Fed.REFUSED:
            self._refuse(self._fault_at(feeder.error, run.origin(run.taken)))
            return False
        if run.taken == len(run):
            self._lines = None
        self._happens(_E.RUN if fed is Fed.DONE else _E.FULL)
        return fed is Fed.DONE

    def _log(self, command: Canonical) -> None:
        """What parameters 0x08 and 0x0A ask for."""
        origin = command.origin
        if self.trace_mode:
            text = self.line_at(origin.index) if self.trace_mode > 1 else ""
            log.info("channel %d: %s:%d %s", self.channel_id, origin.program, origin.line, text)
        if self.feeder_log_enable:
            log.info("channel %d: %s", self.channel_id, command)

    def _show_single_block(self) -> None:
        """Single block in the set-point task: it waits once the path rests at a segment's end."""
        if self.group is not None and self.group.at_block_end:
            self._happens(_E.SINGLE)

    def _without_command(self, interpreter: Interpreter) -> None:
        if interpreter.state is RunState.FOUND:
            self.found = interpreter.found
            if self._resumes:
                self._resumes = False
                self._step_on_or_wait()
            if self._step_on:
                self._step_on = False
                interpreter.go_ahead()
                self._happens(_E.RUN)
        else:
            self._show_single_block()

    def _step_on_or_wait(self) -> None:
        """Go on with a retry or skip, or log the place to which the axes have to be brought."""
        code, found, group = self.step_on_after_search(), self.found, self.group
        if code and found is not None and group is not None:
            log.warning(
                "channel %d: waiting at %s (0x%04X): expected axes at %s, they are at %s; "
                "bring them there, then step on (function 0x19)",
                self.channel_id,
                named_block(found.origin),
                code,
                named_position(found.position),
                named_position(group.positions[:3]),
            )

    def _pass_stop(self, stop: DecoderStop, interpreter: Interpreter) -> bool:
        """Go on behind a decoder stop, if nothing else is to be waited for."""
        if stop.kind is StopKind.EXTERNAL and not self._go_ahead:
            self._happens(_E.WAIT)
            return False
        self._go_ahead = False
        group = self.group
        assert group is not None
        x, y, z, *auxiliary = group.positions
        if stop.kind is StopKind.RESCAN:
            group.take_positions()
        needed = stop.kind in (StopKind.RESCAN, StopKind.READ_POSITIONS)
        if needed:
            interpreter.go_ahead((x, y, z), tuple(auxiliary))
        else:
            interpreter.go_ahead()
        return True

    def _finish(self, end: ProgramEnd) -> None:
        if end.clear_fast:
            self.outputs.clear()
        assert self.feeder is not None
        assert self.group is not None
        self.feeder.finish()
        self.group.end()
        self.feeder = self.interpreter = self._next = self._lines = None
        self._happens(_E.END)
        self._happens(_E.DONE)

    def _fault_at(self, code: int, origin: Origin) -> ProgramFault:
        refused = self._refused
        registers = self.data.registers.own if refused is None else refused.registers
        return ProgramFault(code, origin, origin, tuple(registers))

    def _refuse(self, fault: ProgramFault) -> None:
        """A block cannot be run: the moves before it come first, then the program fails."""
        self._refused = fault
        log.error("channel %d: %s", self.channel_id, fault)

    def _finish_moves(self, feeder: Feeder, fault: ProgramFault) -> None:
        """Fail with the fault once the path is at the begin of its block."""
        if feeder.done:
            self._fail(fault)
        elif self.state is not InterpreterState.SINGLE_STOP:
            self._happens(_E.WAIT)
            self._show_single_block()

    def _fail(self, fault: ProgramFault) -> None:
        """An error of the program or of the group: the axes stop, the place is kept."""
        self.error_code, self.fault, self.text_index = fault.code, fault, fault.origin.index
        self._happens(_E.FAIL)
        self._end_program()

    def digest(self) -> bytes:
        """All that decides what the channel does next, as bytes."""
        outputs = self.outputs
        own = (
            self.state,
            self.error_code,
            self.block_counter,
            outputs.fast,
            outputs.number,
            outputs.request,
            self.data.registers.own,
        )
        return super().digest() + repr(own).encode()


_NEAR = 0.01
"""What the axes may be away from where a block search begins, mm."""
