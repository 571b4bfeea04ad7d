"""`achse gcode` checks, times and draws a part program without a machine."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.cli.programs.gcode_run import ProgramTime
    from achse.gcode.canon import ArcMove, LineMove
    from achse.gcode.errors import GcodeError
    from achse.gcode.interpretation.checking import ProgramReport
    from achse.gcode.interpretation.machine_data import MachineData
    from achse.gcode.text.program import PartProgram


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(gcode)


def gcode(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A part program.")],
    tools: Annotated[
        Path | None,
        typer.Option(help="A file of tools: D number and values.", show_default=False),
    ] = None,
    offsets: Annotated[
        Path | None,
        typer.Option(help="A file of zero shifts: G54F x y z and so on.", show_default=False),
    ] = None,
    subroutines: Annotated[
        Path | None,
        typer.Option(
            help="Folder with L100.NC and so on; the folder of FILE is searched too.",
            show_default=False,
        ),
    ] = None,
    skip: Annotated[
        int, typer.Option(min=0, max=0xFFFF, help="Mask of blocks to skip: bit n is /n.")
    ] = 0,
    blocks: Annotated[
        int, typer.Option(min=1, help="Give the program up after so many blocks.")
    ] = 1_000_000,
    time: Annotated[
        bool, typer.Option("--time", help="Print how long it takes on axes with the limits.")
    ] = False,
    plot: Annotated[
        bool,
        typer.Option("--plot", help="Draw the path as SVG, with the velocity as colour."),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", help="The picture, with --plot.", show_default="FILE with .svg"
        ),
    ] = None,
    view: Annotated[str, typer.Option(help="Of the picture: xy, zx, yz or iso.")] = "xy",
    programmed: Annotated[
        bool, typer.Option("--programmed", help="Draw the programmed path, without velocities.")
    ] = False,
    velocity: Annotated[
        float,
        typer.Option(
            *("--velocity", "-v"),
            min=1e-3,
            help="Greatest of each axis, mm/s.",
            rich_help_panel="Limits of time and picture",
        ),
    ] = 500.0,
    acceleration: Annotated[
        float,
        typer.Option(
            *("--acceleration", "-a"),
            min=1e-3,
            help="Of each axis, mm/s².",
            rich_help_panel="Limits of time and picture",
        ),
    ] = 5000.0,
    jerk: Annotated[
        float,
        typer.Option(
            *("--jerk", "-j"),
            min=1e-3,
            help="Of each axis, mm/s³.",
            rich_help_panel="Limits of time and picture",
        ),
    ] = 100000.0,
    keep_jerk: Annotated[
        bool,
        typer.Option(
            "--keep-jerk",
            help="Keep the jerk where the curvature jumps: keep_jerk = true.",
            rich_help_panel="Limits of time and picture",
        ),
    ] = False,
    in_json: Json = False,
) -> None:
    """Check a part program without a machine, calculate its time, draw its path.

    Each line is checked, then the program runs without motion; errors have line, column and a
    caret. Ends with 1 if there are errors. Handshakes of M functions are not part of the time: the
    PLC decides how long they take.
    """
    from achse.gcode.canon import ArcMove, LineMove
    from achse.gcode.geometry.drawing import VIEWS
    from achse.gcode.interpretation.checking import check_program

    if view not in VIEWS:
        fail(f"view {view}: expected one of {', '.join(VIEWS)}", 2)
    data = _machine(file, tools, offsets, subroutines, skip)
    report = check_program(_program(file), data, blocks=blocks)
    moves = [each for each in report.commands if isinstance(each, LineMove | ArcMove)]
    facts = _facts(report, len(moves))
    if not in_json:
        _print_report(report, len(moves))
    whole = report.ended and not report.errors
    took = None
    if whole and (time or (plot and moves and not programmed)):
        took = _timed(report, velocity, acceleration, jerk, keep_jerk, record=plot)
    if took is not None and time:
        facts["time"] = _time_facts(took)
        if not in_json:
            _print_time(took)
    if whole and plot:
        target = out or file.with_suffix(".svg")
        _draw(target, moves, None if programmed else took, view, file.name)
        facts["picture"] = str(target)
        if not in_json:
            print(f"{target}: {len(moves)} moves")
    if in_json:
        print_json(facts)
    if not whole:
        raise typer.Exit(1)


def _facts(report: "ProgramReport", moves: int) -> dict[str, Any]:
    return {
        "blocks": report.blocks,
        "moves": moves,
        "ended": report.ended,
        "why_no_end": report.why_no_end,
        "errors": [_finding(error) for error in report.errors],
    }


def _print_report(report: "ProgramReport", moves: int) -> None:
    """Print the errors of a program, and how far it ran."""
    for error in report.errors:
        print(f"{error}\n{error.caret()}")
    if report.why_no_end:
        print(report.why_no_end)
    print(f"{report.blocks} blocks run, {moves} moves: {len(report.errors)} errors")


def _time_facts(took: "ProgramTime") -> dict[str, Any]:
    return {
        "seconds": round(took.seconds, 6),
        "dwell": took.dwell,
        "feed_length": took.feed_length,
        "rapid_length": took.rapid_length,
        "moves": took.moves,
        "greatest_velocity": took.greatest_velocity,
        "at_limit": {name: round(each, 6) for name, each in took.at_limit.items()},
        "complete": took.complete,
    }


def _print_time(took: "ProgramTime") -> None:
    """Print how long a program takes, and which limits hold it up."""
    print(f"{took.seconds:.3f} s for {took.moves} moves" + ("" if took.complete else " so far"))
    print(f"feed {took.feed_length:.3f} mm, rapid {took.rapid_length:.3f} mm")
    print(f"dwell {took.dwell:g} s, greatest velocity {took.greatest_velocity:.3f} mm/s")
    for name, seconds in sorted(took.at_limit.items()):
        print(f"{name} at its limit for {seconds:.3f} s")


def _draw(
    target: Path,
    moves: "list[LineMove | ArcMove]",
    took: "ProgramTime | None",
    view: str,
    name: str,
) -> None:
    """Write the picture of a path, by its velocities if it was timed."""
    from achse.gcode.geometry.drawing import draw_moves, draw_velocities

    if took is None:
        picture = draw_moves(moves, view=view, title=name)
    else:
        title = f"{name}, {took.seconds:.3f} s"
        picture = draw_velocities(took.samples, view=view, title=title)
    try:
        target.write_text(picture, encoding="utf-8")
    except OSError as fault:
        fail(f"{target}: {fault.strerror}")


def _machine(
    file: Path, tools: Path | None, offsets: Path | None, subroutines: Path | None, skip: int
) -> "MachineData":
    from achse.gcode.interpretation.machine_data import MachineData
    from achse.gcode.state.offsets import ShiftFileError
    from achse.gcode.state.tool_table import ToolFileError
    from achse.gcode.text.program import search_folders

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
    from achse.gcode.text.program import PartProgram

    try:
        return PartProgram.load(file)
    except GcodeError as error:
        fail(f"{file}: {error.message}", name=error.code.name, code=error.code)


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
