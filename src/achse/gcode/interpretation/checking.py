"""All that is wrong with a part program, found without a machine.

First each line is read by itself: unknown words, words that exclude each other, jumps and calls
with a fixed target. Then the program runs as if nothing moved, up to a number of blocks; what fails
there depends on R parameters, tools and zero shifts.
"""

from dataclasses import dataclass, field

from achse.codes import NcError
from achse.gcode.canon import ArcMove, Canonical, LineMove, StopKind
from achse.gcode.errors import GcodeError, WordRefused
from achse.gcode.interpretation.flow import LoopWatch, check_operands
from achse.gcode.interpretation.interpreter import Interpreter, RunState
from achse.gcode.interpretation.machine_data import MachineData
from achse.gcode.interpretation.preparation import prepare
from achse.gcode.text.blocks import AtCall, AtOperand, ProgramBlock
from achse.gcode.text.program import PartProgram
from achse.gcode.text.words import AtForm
from achse.gcode.vectors import PathPoint

MAX_BLOCKS = 1_000_000
"""Blocks that a check runs: a program in an endless loop is given up then."""
_AT_ONCE = 1000
_STEPS_PER_BLOCK = 10


@dataclass
class ProgramReport:
    """Result of a check. `commands` are the commands up to the first error."""

    errors: list[GcodeError] = field(default_factory=list)
    commands: list[Canonical] = field(default_factory=list)
    blocks: int = 0
    """Blocks that ran."""
    ended: bool = False
    """True if the program ended by itself."""
    loop: tuple[str, int, int] | None = None
    """A loop that cannot end by itself: program, the line that jumps back, the line it goes to."""

    @property
    def why_no_end(self) -> str:
        """Reason why a program without errors has not ended; empty if it has."""
        if self.ended or self.errors:
            return ""
        if self.loop is not None:
            name, line, target = self.loop
            return (
                f"{name or 'program'}:{line}: goes back to line {target} for ever: "
                "no R parameter changes on the way"
            )
        return f"no end after {self.blocks} blocks: the program loops, or is too long"


def check_program(
    program: PartProgram,
    data: MachineData | None = None,
    *,
    blocks: int = MAX_BLOCKS,
) -> ProgramReport:
    """Return all errors of the lines, then the one at which a run stops; in the order of lines."""
    data = MachineData() if data is None else data
    report = dry_run(program, data, blocks=blocks)
    known = {(error.program, error.line, error.message) for error in report.errors}
    for error in check_lines(program, data):
        if (error.program, error.line, error.message) not in known:
            report.errors.append(error)
    report.errors.sort(key=lambda error: (error.program != program.name, error.line))
    return report


def check_lines(program: PartProgram, data: MachineData | None = None) -> list[GcodeError]:
    """Return the errors of all lines, even of lines that never run."""
    errors = []
    case: AtCall | None = None
    for line in range(len(program)):
        try:
            block = program.block(line)
        except GcodeError as error:
            errors.append(error)
            continue
        try:
            prepare(block)
            if isinstance(block.call, AtCall):
                case = block.call if block.call.row is not None else case
                _check_jumps(program, line, block.call, case)
            elif block:
                case = None
            _check_call(program, line, block, data)
        except WordRefused as refused:
            errors.append(program.error(line, refused))
    return errors


def _check_jumps(program: PartProgram, line: int, call: AtCall, case: AtCall | None) -> None:
    row = call.row
    if row is None:
        if case is None or case.row is None or case.row.form is not AtForm.CASE:
            raise WordRefused(NcError.PROGRAM_SYNTAX_RUNNING, "pairs of K belong behind @111", "K")
        targets = call.operands[1::2]
    else:
        check_operands(call)
        if row.form is AtForm.CASE:
            targets = call.operands[2::2]
        elif row.form in (AtForm.JUMP, AtForm.JUMP_IF, AtForm.LOOP_IF):
            targets = call.operands[-1:]
        else:
            return
    for target in targets:
        _check_target(program, line, target)


def _check_target(program: PartProgram, line: int, target: AtOperand) -> None:
    if target.letter != "K":
        return
    number = abs(target.value)
    direction = "-" if target.sign == "-" else "+"
    if number != int(number) or program.find_block(int(number), line, direction) is None:
        where = "before" if direction == "-" else "behind"
        raise WordRefused(
            NcError.PROGRAM_SYNTAX_RUNNING,
            f"there is no block N{number:g} {where} this one",
            f"K{target.sign}{number:g}",
        )


def _check_call(
    program: PartProgram, line: int, block: ProgramBlock, data: MachineData | None
) -> None:
    number = block.values.get("L")
    if not isinstance(number, float) or program.labels.get(int(number)) is not None:
        return
    if line == 0 and program.begin(int(number)) == 1:
        return
    source = data.subroutines if data is not None else None
    if source is None or source(int(number)) is None:
        raise WordRefused(
            NcError.SUBROUTINE_MISSING,
            f"there is neither a label L{number:g} nor L{number:g}.NC",
            f"L{number:g}",
        )


def dry_run(
    program: PartProgram,
    data: MachineData,
    *,
    positions: PathPoint = (0.0, 0.0, 0.0),
    blocks: int = MAX_BLOCKS,
) -> ProgramReport:
    """Run as if each move were done at once: decoder stops find the axes where they were sent.

    It ends after so many `blocks`, where a loop is found that cannot end by itself, or after ten
    times as many lines: subroutines without blocks may be called billions of times.
    """
    report = ProgramReport()
    run = Interpreter(program, data, positions)
    watch = run.flow.watch = LoopWatch()
    axes, most_steps = positions, _STEPS_PER_BLOCK * blocks
    try:
        while run.blocks < blocks and run.steps < most_steps and not watch.endless_jump:
            command = run.advance(_AT_ONCE)
            if command is not None:
                report.commands.append(command)
                if isinstance(command, LineMove | ArcMove):
                    axes = command.end
            elif run.state in (RunState.DECODER_STOP, RunState.SINGLE_STOP):
                if run.stop is not None and run.stop.kind is StopKind.READ_POSITIONS:
                    watch.forget()
                run.go_ahead(axes)
            elif run.state is not RunState.RUNNING:
                break
    except GcodeError as error:
        report.errors.append(error)
    report.blocks, report.loop = run.blocks, watch.endless_jump
    report.ended = run.state is RunState.ENDED
    return report
