"""ProgramChannel: a channel with an interpreter, which runs part programs on its 3D group.

One cycle: `ProgramRun` gives the commands of the program to the group, the group moves along its
path, the PLC sees what the program shows. `achse.motion.channels.waits` draws each reason for which
a channel waits, and what ends it. Functions answer 0 or the NC error that refuses them; they carry
the index offset of 0x2200 + channel id (002 §6.4.2.3).
"""

import logging
from collections.abc import Iterable
from dataclasses import replace

from achse.codes import NcError
from achse.gcode.canon import (
    ProgramEnd,
)
from achse.gcode.errors import GcodeError
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.search import BlockSearch, DryRun, SearchMode
from achse.gcode.state.modal import ModalState
from achse.gcode.text.program import PartProgram
from achse.motion.channels.feeder import Feeder
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_fault import (
    ProgramFault,
    named_block,
    named_position,
)
from achse.motion.channels.program_run import ProgramRun
from achse.motion.channels.program_states import ProgramStates
from achse.motion.channels.states import (
    ACTIVE_STATES,
    TRANSITIONS,
    InterpreterEvent,
    InterpreterState,
    ProgramMode,
)
from achse.motion.channels.technology import TechnologyOutputs
from achse.motion.channels.waits import WAITS, WaitEnd, WaitReason
from achse.motion.checks import OK
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.path_group import PathGroup

log = logging.getLogger("achse.channel")

LOAD_BUFFER = 1 << 24
"""Longest program, bytes (0x2000+ID:0x05); longer ones are 0x4114."""

_E, _W = InterpreterEvent, WaitReason

_UNTIL_REST = tuple(reason for reason, row in WAITS.items() if row.ended_by is WaitEnd.REST)
"""Reasons to wait for axes at rest."""


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
        self.load_log_mode = 0
        self.nc_logger_level = 0
        self.whole_offsets: tuple[int, ...] = (0, 0, 0, 0)
        self.real_offsets: tuple[int, ...] = (0, 0, 0, 0)
        """Group states that the cyclic structure shows (0x55, 0x56)."""
        self.tolerance_balls = [0.0] * 9
        """Radius by group of the channel, mm; stored only, auxiliary axes go with the path."""
        self.modal = ModalState()
        """Modal values in force, those of the last program too."""
        self.search_wanted: BlockSearch | None = None
        self._run: ProgramRun | None = None
        self._registers: list[float] = []
        """R parameters as the program began."""
        self._skipped: set[tuple[int, str, int]] = set()
        """Blocks that were skipped since the start, as `Interpreter.left_out`."""

    @property
    def running(self) -> bool:
        """True if the channel needs its cycle."""
        return self.state in ACTIVE_STATES or self._comes_to_rest

    @property
    def _comes_to_rest(self) -> bool:
        """True if it waits for axes at rest."""
        return self.waiting in _UNTIL_REST

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
        self.happens(_E.LOAD)
        self.wait(_W.START)
        return OK

    def start(self) -> int:
        """Start the program, or the next single block (0x02); 0x42C5 after a stop."""
        if self.waiting is _W.SINGLE_BLOCK:
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
        """Return the same, but the block at fault is left out (0x13)."""
        return self._resume(skip=True)

    def _resume(self, *, skip: bool) -> int:
        fault, group = self.fault, self.group
        if self.state is not InterpreterState.ABORTED or fault is None or group is None:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        group.error_code = OK
        code = group.check_move()
        if code:
            return code
        own = self.data.registers.own
        own[:] = fault.registers_of_retry(self._registers, own)
        self.search_wanted = BlockSearch(SearchMode.ENTRY_COUNTER, fault.resumes_at(skip=skip))
        if skip:
            origin = fault.origin
            self._skipped.add((origin.counter, origin.program, origin.line))
        return self._start(_E.RETRY)

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
        if self._planned_path is not None and self._planned_path.begin != (x, y, z, *auxiliary):
            self._planned_path = None
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
        self._run = ProgramRun(
            *(self, group, self.interpreter, self.feeder), steps_on=event is _E.RETRY
        )
        if event is not _E.RETRY:
            self._skipped.clear()
        self.interpreter.left_out = self._skipped
        self.search_result = self.fault = None
        self.error_code = OK
        if self.search_wanted is not None:
            self.interpreter.search(self.search_wanted)
            self.search_wanted = None
        self.happens(event)
        self.waiting = None
        return OK

    def _step_single(self) -> None:
        if self.interpreter is not None and self.interpreter.state is RunState.SINGLE_STOP:
            self.interpreter.go_ahead()
        elif self.group is not None:
            self.group.next_block()
        self.end_wait()

    def stop(self) -> int:
        """Bring the axes to a halt; the program is over (0x11)."""
        if (self.state, _E.STOP) in TRANSITIONS:
            self.wait(_W.STOP)
            self._end_program()
        return super().stop()

    def reset(self) -> int:
        """End and forget the program, reset errors (0x10)."""
        self._end_program()
        self.error_code = OK
        self.program, self.text_index, self.program_number = None, 0, 0
        self.fault = self._planned_path = None
        self.outputs.clear()
        self.outputs.drop()
        self.search_wanted = self.search_result = None
        code = super().reset()
        self.wait(_W.RESET)
        if self._rests:
            self.end_wait()
        return code

    def _end_program(self) -> None:
        if self.feeder is not None:
            self.feeder.finish()
        if self.group is not None and self.group.moving:
            self.group.clear()
        self.feeder = self.interpreter = self._run = None

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
        if self._run is None or not self._run.waits_for_trigger:
            return NcError.CHANNEL_NO_DECODER_STOP
        self._run.released = True
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
        return NcError.CHANNEL_COMMAND_NOT_NOW if self._run is None else self._run.step_on()

    @property
    def retrace_enable(self) -> int:
        """1: the path of the next start is stored for a way back (0x54)."""
        return int(self.group is not None and self.group.keeps_way_back)

    @retrace_enable.setter
    def retrace_enable(self, on: int) -> None:
        if self.group is not None:
            self.group.keeps_way_back = bool(on)

    def retrace(self, backwards: bool) -> int:
        """After an emergency stop, follow the path back, or forward again (0x14, 0x15).

        0x4109 while no program runs or the path does not rest, 0x42CC if it is not stored.
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
        """Run one cycle, before the groups have theirs."""
        if self.state not in ACTIVE_STATES:
            if self._comes_to_rest and self._rests:
                self.end_wait()
                self._show_stop()
            return
        run, group = self._run, self.group
        if run is None or group is None:
            return
        if group.error_code or (not group.moving and self.state is not InterpreterState.SEARCHING):
            code = group.error_code or NcError.GROUP_CONSEQUENTIAL_ERROR
            self._fail(run.fault_at(code, run.feeder.origin or run.interpreter.origin))
            log.error("channel %d: %s", self.channel_id, self.fault)
            return
        outcome = run.step(self.granted)
        if isinstance(outcome, ProgramFault):
            self._fail(outcome)
        elif outcome is not None:
            self._finish(run, group, outcome)

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

    def _finish(self, run: ProgramRun, group: PathGroup, end: ProgramEnd) -> None:
        if end.clear_fast:
            self.outputs.clear()
        run.feeder.finish()
        group.end()
        self.feeder = self.interpreter = self._run = None
        self.wait(_W.PROGRAM_END)
        self.end_wait()

    def _fail(self, fault: ProgramFault) -> None:
        """Stop the axes and store the place at an error of the program or of the group."""
        self.error_code, self.fault, self.text_index = fault.code, fault, fault.origin.index
        self.wait(_W.ABORT)
        self._end_program()

    def digest(self) -> bytes:
        """Return all that decides what the channel does next, as bytes."""
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
