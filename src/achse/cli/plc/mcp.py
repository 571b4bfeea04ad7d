"""`achse mcp` serves an agent: tools that check, run and mend PLC projects in virtual time."""

import os
from pathlib import Path
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.options import Library


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(mcp)


def mcp(
    root: Annotated[
        Path,
        typer.Option(
            metavar="FOLDER",
            help="The folder whose projects tools may use; nothing else is read or written.",
            exists=True,
            file_okay=False,
            show_default="this folder",
        ),
    ] = Path(),
    library: Library = None,
    connect: Annotated[
        str | None,
        typer.Option(
            metavar="TARGET",
            help="A controller that tools may read, as HOST or HOST:PORT; else no network.",
            show_default=False,
        ),
    ] = None,
    allow_write: Annotated[
        bool, typer.Option("--allow-write", help="Let tools write to that controller, too.")
    ] = False,
) -> None:
    """Serve the agent that started this program by the Model Context Protocol.

    Speaks over standard input and output until the agent goes; the log is on standard error.
    Fifteen tools: check, explain, find_symbols, read_code, edit_code, test, open_station, run,
    state, read, write, axis, fault, trace, compare. Stations run in virtual time in this process.
    Sources of TcUnit that ACHSE_TCUNIT names may be read, too.
    """
    try:
        from achse.mcp.server import new_server
    except ModuleNotFoundError as missing:
        if (missing.name or "").partition(".")[0] not in ("mcp", "mcp_types", "anyio"):
            raise
        from achse.extras import needs_extra

        fail(needs_extra("achse mcp", "mcp"))
    from achse import __version__
    from achse.cli.logs import LogFormat, LogLevel, set_up_logs
    from achse.tcunit.locate import VARIABLE

    tcunit = os.environ.get(VARIABLE)
    libraries = [*(library or []), *([Path(tcunit)] if tcunit else [])]
    missing_libraries = [str(path) for path in libraries if not path.exists()]
    if missing_libraries:
        fail(f"{missing_libraries[0]}: no such file or folder")
    server = new_server(
        __version__, root, libraries=libraries, target=connect, may_write=allow_write
    )
    set_up_logs(LogFormat.TEXT, LogLevel.WARNING)  # many agents do not read it
    server.run("stdio")
