"""`achse gcode`: look at a part program without a machine."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.cli.programs.gcode_run import ProgramTime
    from achse.gcode.checking import ProgramReport
    from achse.gcode.errors import GcodeError
    from achse.gcode.machine_data import MachineData
    from achse.gcode.program import PartProgram

__all__ = ["gcode"]

gcode = typer.Typer(no_args_is_help=True, help="Part programs (DIN 66025) without a machine.")

ProgramFile = Annotated[Path, typer.Argument(metavar="FILE", help="A part program.")]
Tools = Annotated[
    Path | None,
    typer.Option(help="A file of tools: D number and values.", show_default=False),
]
Offsets = Annotated[
    Path | None,
    typer.Option(help="A file of zero shifts: G54F x y z and so on.", show_default=False),
]
Subroutines = Annotated[
    Path | None,
    typer.Option(
        help="Folder with L100.NC and so on; the folder of FILE is searched too.",
        show_default=False,
    ),
]
Skip = Annotated[int, typer.Option(min=0, max=0xFFFF, help="Mask of blocks to skip: bit n is /n.")]
Velocity = Annotated[
    float, typer.Option("--velocity", "-v", min=1e-3, help="Greatest of each axis, mm/s.")
]
Acceleration = Annotated[
    float, typer.Option("--acceleration", "-a", min=1e-3, help="Of each axis, mm/s².")
]
Jerk = Annotated[float, typer.Option("--jerk", "-j", min=1e-3, help="Of each axis, mm/s³.")]
KeepJerk = Annotated[
    bool,
    typer.Option("--keep-jerk", help="Keep the jerk where the curvature jumps: keep_jerk = true."),
]


Blocks = Annotated[
    int | None,
    typer.Option(min=1, help="Give the program up after so many blocks.", show_default="1000000"),
]


def _machine(
    file: Path, tools: Path | None, offsets: Path | None, subroutines: Path | None, skip: int
) -> "MachineData":
    from achse.gcode.machine_data import MachineData
    from achse.gcode.offsets import ShiftFileError
    from achse.gcode.program import search_folders
    from achse.gcode.tool_table import ToolFileError

    data = MachineData(
        subroutines=search_folders([subroutines, file.absolute().parent]), skip_mask=skip
    )
    for path, table in ((tools, data.tools), (offsets, data.shifts)):
        try:
            if path is not None:
                table.load(path)
        except OSError as fault:
            fail(f"{path}: {fault.strerror}")
        except (ToolFileError, ShiftFileError) as fault:
            fail(f"{path}: {fault}")
    return data


def _program(file: Path) -> "PartProgram":
    from achse.gcode.errors import GcodeError
    from achse.gcode.program import PartProgram

    try:
        return PartProgram.load(file)
    except GcodeError as error:
        fail(f"{file}: {error.message}", name=error.code.name, code=error.code)


def _report(file: Path, data: "MachineData", blocks: int | None) -> "ProgramReport":
    """A run without errors, or the end of the command."""
    from achse.gcode.checking import MAX_BLOCKS, check_program

    report = check_program(_program(file), data, blocks=blocks or MAX_BLOCKS)
    if report.errors:
        first = report.errors[0]
        fail(f"{first}\n{first.caret()}", name=first.code.name, code=first.code)
    if not report.ended:
        fail(f"{file}: {report.why_no_end}")
    return report


@gcode.command()
def check(
    file: ProgramFile,
    tools: Tools = None,
    offsets: Offsets = None,
    subroutines: Subroutines = None,
    skip: Skip = 0,
    blocks: Blocks = None,
    in_json: Json = False,
) -> None:
    """Tell all errors of a part program, with line, column and a caret.

    Each line is checked, then the program runs without motion. Ends with 1 if there are errors.
    """
    from achse.gcode.canon import ArcMove, LineMove
    from achse.gcode.checking import MAX_BLOCKS, check_program

    data = _machine(file, tools, offsets, subroutines, skip)
    report = check_program(_program(file), data, blocks=blocks or MAX_BLOCKS)
    moves = sum(isinstance(each, LineMove | ArcMove) for each in report.commands)
    if in_json:
        print_json(
            {
                "blocks": report.blocks,
                "moves": moves,
                "ended": report.ended,
                "why_no_end": report.why_no_end,
                "errors": [_finding(error) for error in report.errors],
            }
        )
    else:
        for error in report.errors:
            print(f"{error}\n{error.caret()}")
        if report.why_no_end:
            print(report.why_no_end)
        print(f"{report.blocks} blocks run, {moves} moves: {len(report.errors)} errors")
    if report.errors or not report.ended:
        raise typer.Exit(1)


def _finding(error: "GcodeError") -> dict[str, Any]:
    return {
        "file": error.program,
        "line": error.line,
        "column": error.column,
        "index": error.index,
        "word": error.word,
        "code": error.code.number,
        "name": error.code.name,
        "message": error.message,
    }


@gcode.command()
def plot(
    file: ProgramFile,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="The SVG file; FILE.svg by default.", show_default=False),
    ] = None,
    view: Annotated[str, typer.Option(help="xy, zx, yz or iso.")] = "xy",
    programmed: Annotated[
        bool, typer.Option("--programmed", help="The programmed path, without velocities.")
    ] = False,
    velocity: Velocity = 500.0,
    acceleration: Acceleration = 5000.0,
    jerk: Jerk = 100000.0,
    keep_jerk: KeepJerk = False,
    tools: Tools = None,
    offsets: Offsets = None,
    subroutines: Subroutines = None,
    skip: Skip = 0,
    blocks: Blocks = None,
) -> None:
    """Draw the path as SVG, with the velocity as colour.

    The velocity is that of axes with these limits.
    """
    from achse.gcode.canon import ArcMove, LineMove
    from achse.gcode.drawing import VIEWS, draw_moves, draw_velocities

    if view not in VIEWS:
        fail(f"view {view}: expected one of {', '.join(VIEWS)}", 2)
    report = _report(file, _machine(file, tools, offsets, subroutines, skip), blocks)
    moves = [each for each in report.commands if isinstance(each, LineMove | ArcMove)]
    if programmed or not moves:
        picture = draw_moves(moves, view=view, title=file.name)
    else:
        took = _timed(report, velocity, acceleration, jerk, keep_jerk, record=True)
        title = f"{file.name}, {took.seconds:.3f} s"
        picture = draw_velocities(took.samples, view=view, title=title)
    target = out or file.with_suffix(".svg")
    try:
        target.write_text(picture, encoding="utf-8")
    except OSError as fault:
        fail(f"{target}: {fault.strerror}")
    print(f"{target}: {len(moves)} moves")


@gcode.command("time")
def how_long(
    file: ProgramFile,
    velocity: Velocity = 500.0,
    acceleration: Acceleration = 5000.0,
    jerk: Jerk = 100000.0,
    keep_jerk: KeepJerk = False,
    tools: Tools = None,
    offsets: Offsets = None,
    subroutines: Subroutines = None,
    skip: Skip = 0,
    blocks: Blocks = None,
    in_json: Json = False,
) -> None:
    """Tell how long a part program takes on axes with these limits.

    Handshakes of M functions are not in it: the PLC decides how long they take.
    """
    report = _report(file, _machine(file, tools, offsets, subroutines, skip), blocks)
    took = _timed(report, velocity, acceleration, jerk, keep_jerk)
    if in_json:
        print_json(
            {
                "seconds": round(took.seconds, 6),
                "dwell": took.dwell,
                "feed_length": took.feed_length,
                "rapid_length": took.rapid_length,
                "moves": took.moves,
                "greatest_velocity": took.greatest_velocity,
                "at_limit": {name: round(each, 6) for name, each in took.at_limit.items()},
                "complete": took.complete,
            }
        )
        return
    print(f"{took.seconds:.3f} s for {took.moves} moves" + ("" if took.complete else " so far"))
    print(f"feed {took.feed_length:.3f} mm, rapid {took.rapid_length:.3f} mm")
    print(f"dwell {took.dwell:g} s, greatest velocity {took.greatest_velocity:.3f} mm/s")
    for name, seconds in sorted(took.at_limit.items()):
        print(f"{name} at its limit for {seconds:.3f} s")


def _timed(
    report: "ProgramReport",
    velocity: float,
    acceleration: float,
    jerk: float,
    keep_jerk: bool,
    *,
    record: bool = False,
) -> "ProgramTime":
    from achse.cli.programs.gcode_run import run_commands
    from achse.motion.path import PathError, PathLimits

    try:
        limit = PathLimits(velocity, acceleration, jerk)
        start = (0.0,) * 8
        return run_commands(report.commands, limit, start, keep_jerk=keep_jerk, record=record)
    except PathError as fault:
        fail(str(fault))
