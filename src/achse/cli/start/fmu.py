"""`achse fmu` exports a station as a co-simulation unit."""

from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json
from achse.cli.target import Json

_SHOWN = 5


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(fmu)


def fmu(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A station.toml.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="The unit.", show_default="FILE with .fmu"),
    ] = None,
    fmi: Annotated[int, typer.Option(min=2, max=3, help="Version of FMI: 2 or 3.")] = 3,
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", help="A symbol that importers set in each step.", metavar="NAME"),
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option("--parameter", help="A symbol that is a parameter.", metavar="NAME"),
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option("--output", help="A symbol or pattern that is an output.", metavar="NAME"),
    ] = None,
    symbols: Annotated[
        list[str] | None,
        typer.Option("--symbol", help="A symbol or pattern to look at.", metavar="NAME"),
    ] = None,
    include: Annotated[
        list[Path] | None,
        typer.Option(help="A file or folder that the station reads later: part programs."),
    ] = None,
    in_json: Json = False,
) -> None:
    """Export a station as a co-simulation unit (FMI 3.0 or 2.0) for other simulation tools.

    Located variables (%I, %Q) and the values of axes are variables of the unit. Names have a PLC's
    port before a colon where several have it; * is any text.
    """
    from achse.fmu import ExportError, export
    from achse.fmu.variables import VariableChoice
    from achse.station import ConfigError

    choice = VariableChoice(
        inputs=inputs or (),
        parameters=parameters or (),
        outputs=outputs or (),
        locals=symbols or (),
    )
    target = out or file.with_suffix(".fmu")
    try:
        unit = export(file, fmi=fmi, choice=choice, include=include or ())
    except (ExportError, ConfigError) as fault:
        fail(str(fault), name="CANNOT_EXPORT")
    except OSError as failure:
        fail(f"{failure.filename or file}: {failure.strerror}", name="CANNOT_READ")
    write_file(target, unit.archive, lambda there: there[:2] == b"PK", "a unit")
    counts = {
        kind: sum(each.causality == kind for each in unit.variables)
        for kind in ("input", "parameter", "output", "local")
    }
    left_out = [each.name for each in unit.left_out]
    if in_json:
        print_json(
            {
                "file": str(target),
                "fmi": f"{fmi}.0",
                "states": unit.has_states,
                "variables": counts,
                "left_out": left_out,
            }
        )
        return
    summary = ", ".join(f"{count} {kind}{'s' * (count != 1)}" for kind, count in counts.items())
    print(f"{target}: FMI {fmi}.0, {summary}")
    if left_out:
        more = ", …" if len(left_out) > _SHOWN else ""
        print(f"left out, FMI 2.0 has no 64 bits: {', '.join(left_out[:_SHOWN])}{more}")
