"""The interpreter: runs a part program block by block and yields canonical commands.

How a channel uses it: `advance()` gives the next command of `canon`, or None; then `state` says
why. At a decoder stop, carry out all commands so far and call `go_ahead` with what the stop
requests. `advance` runs a limited number of blocks per call, so that an endless loop in a program
never holds the station: call it again in the next cycle. R parameters, skip mask, zero shifts and
tools may change between calls; what is already yielded stays as it is, so a program that wants new
values writes a decoder stop (@714).
"""

from collections import deque
from collections.abc import Iterator, Set
from enum import Enum

from achse.codes import NcError
from achse.gcode.canon import (
    AUXILIARY_AXES,
    Canonical,
    DecoderStop,
    HomeAxis,
    Origin,
    PathParameter,
    ProgramEnd,
    ProgramMessage,
    ProgramStop,
    StopKind,
)
from achse.gcode.errors import GcodeError, WordRefused
from achse.gcode.geometry.compensation import Bottleneck
from achse.gcode.geometry.frame import WorkFrame
from achse.gcode.interpretation.block_words import BlockWords
from achse.gcode.interpretation.flow import Flow
from achse.gcode.interpretation.line_run import LineRun
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.interpretation.moves import AXIS_LETTERS, PathMaker
from achse.gcode.interpretation.path_settings import path_setting, position_registers
from achse.gcode.interpretation.preparation import prepare
from achse.gcode.interpretation.search import BlockSearch, DryRun, SearchMode, SearchResult
from achse.gcode.state.mfunctions import PROGRAM_END, PROGRAM_END_CLEAR, SUBROUTINE_END, placed
from achse.gcode.state.modal import ModalState
from achse.gcode.text.blocks import AtCall, HashCall, ProgramBlock, RotationCall
from achse.gcode.text.program import PartProgram
from achse.gcode.text.words import AtForm
from achse.gcode.vectors import PathPoint

BLOCKS_PER_CALL = 200
"""Blocks without a command that one `advance` runs at most."""

_STOPS = {
    "empty": StopKind.EMPTY,
    "rescan": StopKind.RESCAN,
    "external": StopKind.EXTERNAL,
}


class RunState(Enum):
    """State of the interpreter."""

    RUNNING = "there is more: call `advance` again"
    DECODER_STOP = "it waits for `go_ahead`, see `stop`"
    SINGLE_STOP = "single block: it waits for `go_ahead`"
    FOUND = "block search: `found` is set, it waits for `go_ahead`"
    ENDED = "M02, M30 or the end of the text"
    FAILED = "`advance` raised a GcodeError; a new interpreter is needed"


class Interpreter:
    """One run of a part program.

    `positions` and `auxiliary` are where the axes are now, mm. `default_program` (DefaultGCode)
    runs before the program and leaves its modal words behind.
    """

    def __init__(
        self,
        program: PartProgram,
        data: MachineData | None = None,
        positions: PathPoint = (0.0, 0.0, 0.0),
        auxiliary: tuple[float, ...] = (0.0,) * AUXILIARY_AXES,
        default_program: PartProgram | None = None,
    ) -> None:
        self.data = MachineData() if data is None else data
        self.program = program
        self.modal = ModalState()
        bottleneck = self.data.bottleneck
        own = Bottleneck(False, bottleneck.mode, bottleneck.look_ahead)
        self.path = PathMaker(self.modal, WorkFrame(), positions, auxiliary, own)
        self._words = BlockWords(self.data, self.modal, self.path, own)
        self.flow = Flow(program, self.data.registers, self.data.subroutines)
        if default_program is not None:
            self._default: Flow | None = Flow(
                default_program, self.data.registers, self.data.subroutines
            )
        else:
            self._default = None
        self._main = self.flow
        if self._default is not None:
            self.flow = self._default
        self.state = RunState.RUNNING
        self.stop: DecoderStop | None = None
        """The decoder stop at which it waits."""
        self.blocks = 0
        """Blocks that ran so far: the counter of `Origin`."""
        self.steps = 0
        """Lines that ran so far, with ends of texts and lines without a block: the work done."""
        self.origin = Origin(program.name, 1, 0, 0, 0)
        """The block that ran last."""
        self.unmade: Origin | None = None
        """First block that cutter compensation delayed as the last block began to run."""
        self.left_out: Set[tuple[int, str, int]] = frozenset()
        """Blocks that do not run: their counters, and file and line as in `Origin`."""
        self.search_result: SearchResult | None = None
        self._search: BlockSearch | None = None
        self._ready: deque[Canonical] = deque()
        self._data_version = (-1, -1)
        """Changes of zero shifts and tools that the frame knows."""
        self._targets: tuple[int, ...] = ()
        """R parameters that wait for positions (#get)."""

    # running

    def advance(self, blocks: int = BLOCKS_PER_CALL) -> Canonical | None:
        """Return the next command; None if there is none now, see `state`. Raises `GcodeError`
        once.

        Commands of blocks before the wrong one come first. At most `blocks` blocks run.
        """
        while not self._ready:
            if self.state is not RunState.RUNNING or blocks <= 0:
                return None
            blocks -= 1
            self.steps += 1
            move = self._step()
            if move is not None:
                return move
        return self._ready.popleft()

    def lines(self, most: int) -> LineRun | None:
        """Return the next lines with nothing but X, Y, Z at once, `most` of them; None where
        `advance` has to go on. The same moves come out, in less time."""
        running = self.state is RunState.RUNNING and not self._ready and self._search is None
        if (
            not running
            or self._frame_changed
            or self.data.single_block
            or self._words.factor() != 1.0
        ):
            return None
        place = self.flow.places[-1]
        run = self.path.bare_lines(place.program, place.line, most, self._words.velocity())
        if run is not None:
            run.counter = self.blocks + 1
            place.line += len(run)
            self.blocks += len(run)
            self.flow.case = None
            self.origin = run.origin(len(run) - 1)
        return run

    def __iter__(self) -> Iterator[Canonical]:
        """Yield all commands until it waits, ends or fails. An endless program never ends."""
        while True:
            command = self.advance()
            if command is not None:
                yield command
            elif self.state is not RunState.RUNNING:
                return

    def go_ahead(
        self, positions: PathPoint | None = None, auxiliary: tuple[float, ...] | None = None
    ) -> None:
        """Go on behind a decoder stop, a single block or a found block.

        `positions` of X, Y, Z in mm are needed by RESCAN and READ_POSITIONS, and allowed elsewhere:
        the program then goes on from there. RuntimeError if it waits for nothing.
        """
        if self._ready or self.state not in _WAITING:
            raise RuntimeError("the interpreter does not wait: take its commands first")
        if self.state is RunState.FOUND and self._search is not None:
            # a decoder stop of the found block is still to come
            self.state = RunState.RUNNING if self.stop is None else RunState.DECODER_STOP
            self._ready.extend(self._search.rest)
            self._search = None
            return
        stop = self.stop
        needed = stop is not None and stop.kind in (StopKind.RESCAN, StopKind.READ_POSITIONS)
        if needed and positions is None:
            raise ValueError("this decoder stop needs the positions of the axes")
        if positions is not None and self.state is RunState.DECODER_STOP:
            if self._targets:
                for number, value in zip(self._targets, positions, strict=False):
                    self.data.registers[number] = float(value)
            self.path.rescan(positions, auxiliary)
        self._targets = ()
        self.stop = None
        self.state = RunState.RUNNING

    def search(self, wanted: BlockSearch) -> None:
        """Search a block: run without motion up to it. Call before the first `advance`.

        When it is there, `state` is FOUND and `found` says where the axes have to be; `go_ahead`
        begins the rest. 0x42F8 if the program ends before.
        """
        if self.blocks:
            raise RuntimeError("a block search begins before the program")
        self._search = None if wanted.mode is SearchMode.DISABLED else wanted

    # one block

    def _step(self) -> Canonical | None:
        """Run a block. Its commands are ready then; the move of a bare line comes back at once."""
        place = self.flow.places[-1]
        program, line = place.program, place.line
        if line >= len(program.lines):
            self._text_end()
            return None
        place.line = line + 1
        if self.left_out and (self.blocks + 1, program.name, line + 1) in self.left_out:
            self.blocks += 1
            self.flow.case = None
            return None
        try:
            block = program.block(line)
            if block.bare and self._is_quiet:
                self.blocks += 1
                origin = self.origin = Origin(
                    program.name, line + 1, program.starts[line], block.number, self.blocks
                )
                self.flow.case = None
                move = self.path.bare_line(origin, block.values, self._words.velocity())
                if move is not None:
                    return move
                self.blocks -= 1
            self._run_block(program, line, block)
        except WordRefused as refused:
            self.state = RunState.FAILED
            raise program.error(line, refused) from None
        except GcodeError:
            self.state = RunState.FAILED
            raise
        return None

    @property
    def _frame_changed(self) -> bool:
        """True if zero shifts or tools differ from the shifts and tools of the frame."""
        return (self.data.shifts.changes, self.data.tools.changes) != self._data_version

    @property
    def _is_quiet(self) -> bool:
        """True if a line with nothing but positions may use the fast path."""
        data = self.data
        if self._frame_changed:
            self._data_version = (data.shifts.changes, data.tools.changes)
            return False
        return self._search is None and not data.single_block and self._words.factor() == 1.0

    def _run_block(self, program: PartProgram, line: int, block: ProgramBlock) -> None:
        skipped = block.skip >= 0 and self.data.skip_mask >> block.skip & 1
        if not block or skipped:
            if block and not isinstance(block.call, AtCall):
                self.flow.case = None
            return
        self.blocks += 1
        origin = Origin(program.name, line + 1, program.starts[line], block.number, self.blocks)
        self.origin = origin
        self.unmade = self.path.delayed_origin
        if program.begins_subroutine(line, block):
            return
        commands = list(self._run(block, origin, line))
        self._hand_out(commands, origin)

    def _hand_out(self, commands: list[Canonical], origin: Origin) -> None:
        """Output the commands of a block, or what a block search leaves of them."""
        search = self._search
        if search is not None and self.search_result is None:
            ended = self.state is RunState.ENDED
            self.search_result = search.take(commands, origin, self.path.axes)
            if self.search_result is not None:
                self.state = RunState.FOUND
                return
            if ended:
                raise WordRefused(NcError.BLOCK_NOT_FOUND, "the block searched for never runs")
            commands = [each for each in commands if search.keeps(each)]
            if self.state is RunState.DECODER_STOP and search.dry_run is DryRun.SKIP_ALL:
                # nothing moves: the positions are those of the program
                self._targets, self.stop, self.state = (), None, RunState.RUNNING
                commands = []
        self._ready.extend(commands)
        if self.data.single_block and self.state is RunState.RUNNING and commands:
            self._ready.append(ProgramStop(origin))
            self.state = RunState.SINGLE_STOP

    def _text_end(self) -> None:
        """Note that the text is over: back to a caller, from the default program to the main one,
        or end."""
        flow = self.flow
        if flow.leave():
            return
        if flow is not self._main:
            self.flow = self._main
            return
        origin = Origin(flow.place.program.name, len(flow.place.program), 0, 0, self.blocks)
        self.unmade = self.path.delayed_origin
        try:
            self._hand_out(list(self._end(origin, clear=False)), origin)
        except WordRefused as refused:
            self.state = RunState.FAILED
            raise flow.place.program.error(len(flow.place.program) - 1, refused) from None

    def _end(self, origin: Origin, clear: bool) -> Iterator[Canonical]:
        if self.flow is not self._main:
            self.flow = self._main
            return
        yield from self.path.end_compensation()
        self.state = RunState.ENDED
        yield ProgramEnd(origin, clear)

    def _run(self, block: ProgramBlock, origin: Origin, line: int) -> Iterator[Canonical]:
        call = block.call
        registers = self.data.registers
        if not isinstance(call, AtCall):
            self.flow.case = None
        for number, formula in block.assignments:
            registers[number] = formula.evaluate(registers)
        if not (block.words or block.values or block.functions):
            if isinstance(call, AtCall):  # nothing but flow
                yield from self._at(call, origin, line)
                return
            if call is None:
                return
        before, after = placed(block.functions, self.data.m_rules, origin)
        prepared = prepare(block)
        values = self._words.values(block, prepared)
        yield from self._words.modal_words(prepared, values, origin)
        yield from self._words.technology(values, origin)
        for command in before:
            yield from self.path.other(command)
        if prepared.homing and not prepared.dwell:
            yield from self._home(values, origin)
        else:
            yield from self._words.motion(prepared, values, origin)
        for command in after:
            yield from self.path.other(command)
        if isinstance(call, AtCall):
            yield from self._at(call, origin, line)
        elif isinstance(call, HashCall):
            yield from self._hash(call, origin)
        elif isinstance(call, RotationCall):
            self._words.calculate(call)
        if (number_ := values.get("L")) is not None:
            self._subroutine(number_, values.get("P"))
        yield from self._leave(block.functions, origin)

    def _home(self, values: dict[str, float | None], origin: Origin) -> Iterator[Canonical]:
        names = [*AXIS_LETTERS, *(f"Q{number}" for number in range(1, AUXILIARY_AXES + 1))]
        axes = [axis for axis, name in enumerate(names) if name in values]
        if len(axes) != 1:
            raise WordRefused(NcError.PROGRAM_SYNTAX_RUNNING, "expected one axis behind G74", "G74")
        yield HomeAxis(origin, axes[0])
        yield from self._decoder_stop(origin, StopKind.RESCAN)

    # commands

    def _decoder_stop(self, origin: Origin, kind: StopKind) -> Iterator[Canonical]:
        if self.path.compensation is not None:
            raise WordRefused(
                NcError.TOOL_COMPENSATION_GEOMETRY,
                "G40 is needed before a decoder stop",
            )
        self.stop = DecoderStop(origin, kind)
        self.state = RunState.DECODER_STOP
        yield self.stop

    def _at(self, call: AtCall, origin: Origin, line: int) -> Iterator[Canonical]:
        if call.row is not None and call.row.form is AtForm.STOP:
            if call.operands:
                raise WordRefused(
                    NcError.PROGRAM_SYNTAX_RUNNING,
                    "a decoder stop has no operands",
                    f"@{call.row.number}",
                )
            yield from self._decoder_stop(origin, _STOPS[call.row.relation])
        else:
            self.flow.run(call, line)

    def _hash(self, call: HashCall, origin: Origin) -> Iterator[Canonical]:
        if call.verb == "MSG":
            yield from self.path.other(ProgramMessage(origin, call.text))
        elif call.verb == "GET":
            yield from self._get_positions(call, origin)
        else:
            setting = path_setting(call, self.data.registers, origin)
            if setting.parameter is PathParameter.VERTEX_SMOOTHING:
                self.modal.smoothing = setting.values[0] if setting.values[2] else 0.0
            yield from self.path.other(setting)

    def _get_positions(self, call: HashCall, origin: Origin) -> Iterator[Canonical]:
        self._targets = position_registers(call, self.data.registers)
        yield from self._decoder_stop(origin, StopKind.READ_POSITIONS)

    def _subroutine(self, number: float, repeats: float | None) -> None:
        times = 1.0 if repeats is None else repeats
        if number != int(number) or number < 0.0:
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING, "expected a whole number behind L", "L"
            )
        if times != int(times) or times < 0.0:
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING, "expected P with a whole number of runs", "P"
            )
        if times:
            self.flow.call(int(number), int(times))

    def _leave(self, functions: list[int], origin: Origin) -> Iterator[Canonical]:
        for number in functions:
            if number in (PROGRAM_END, PROGRAM_END_CLEAR):
                yield from self._end(origin, clear=number == PROGRAM_END_CLEAR)
                return
            if number == SUBROUTINE_END and not self.flow.leave():
                if self.flow is not self._main:
                    self.flow = self._main
                    return
                raise WordRefused(
                    NcError.SUBROUTINE_STACK_UNDERFLOW, "M17 ends a subroutine only", "M17"
                )


_WAITING = (RunState.DECODER_STOP, RunState.SINGLE_STOP, RunState.FOUND)
